"""Infrared sensors near things, and edges of the floor."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.fit import Fit
from p2os_emu.world import STEP, Block, MovingDoor, Person, RobotBody, World, WorldError, WorldSpec, load_world
from p2os_emu.world.movable import Movable, Shape

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

POST = Movable("post", Shape.CYLINDER, Pose2D(), 0.06, 0.06, 0.3, 1.0, 0.5, "grey")
STAIRS = WorldSpec("stairs", drops=(Block(2.0, 0.0, 0.0, 2.0, 4.0, 0.0, "stairs"),))
LEDGE = Fit({"ledge": ""})


def drive(world: World, body: RobotBody, speed: float, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        body.drive(speed, speed)
        world.step()


@pytest.mark.parametrize("name", ["powerbot", "powerbot-sh", "powerbot-sh-uarcs"])
@pytest.mark.parametrize("number", range(8))
def test_each_sensor_of_a_powerbot_sees_what_stands_before_it(
    name: str, number: int, model: Models, make_world: MakeWorld
) -> None:
    shape = model(name)
    sensor = shape.irs[number]
    there = replace(POST, pose=Pose2D(shape.length_front + 0.2, sensor.y))
    world = make_world(WorldSpec("post", objects=(there,)))
    body = world.add_robot("robot", shape, Pose2D())
    world.step()
    assert body.state.infrared == 0xFF & ~(1 << number)
    world.place("robot", Pose2D(-0.2))
    drive(world, body, 0.0, 0.1)
    assert body.state.infrared == 0xFF


def test_infrared_sees_people_and_shut_doors(model: Models, make_world: MakeWorld) -> None:
    shape = model("powerbot-sh")
    ahead = shape.length_front + 0.2
    person = Person("Anna", ((ahead + 0.1, 0.0), (ahead + 0.1, 5.0)), speed=1.0)
    door = MovingDoor("door", (ahead, -1.0), (ahead, 1.0), is_open=False)
    for spec in (WorldSpec("street", people=(person,)), WorldSpec("gate", moving_doors=(door,))):
        world = make_world(spec)
        body = world.add_robot("robot", shape, Pose2D(-0.3))
        world.place("robot", Pose2D(0.0))
        world.step()
        assert body.state.infrared != 0xFF


def test_the_first_sensor_of_a_powerbot_is_the_rightmost(model: Models) -> None:
    ys = [sensor.y for sensor in model("powerbot-sh").irs]
    assert ys == sorted(ys)


@pytest.mark.parametrize(("name", "right"), [("peoplebot-sh", 0), ("perfpb", 0), ("perfpb+", 0), ("p2pp", 0)])
def test_a_peoplebot_sees_a_table_at_its_right_corner(
    name: str, right: int, model: Models, make_world: MakeWorld
) -> None:
    shape = model(name)
    table = Block(shape.length_front + 0.27, -0.5, 0.0, 0.5, 0.6, 0.74, "table")
    body = make_world(WorldSpec("table", furniture=(table,))).add_robot("robot", shape, Pose2D())
    body.refresh()
    assert body.state.infrared == 0xFF & ~(1 << right)


def test_a_robot_sees_nothing_of_itself_and_only_what_it_has_sensors_for(model: Models, make_world: MakeWorld) -> None:
    wall = WorldSpec("wall", walls=(Block(0.5, 0.0, 0.0, 0.1, 4.0, 2.0, "wall"),))
    blind = make_world(wall).add_robot("robot", model("p3dx-sh"), Pose2D())
    alone = make_world().add_robot("robot", model("powerbot-sh"), Pose2D())
    for body in (blind, alone):
        body.refresh()
        assert body.state.infrared == 0xFF


def test_ledge_sensors_see_an_edge_from_far_and_from_near(model: Models, make_world: MakeWorld) -> None:
    world = make_world(STAIRS)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(), fit=LEDGE)
    seen = []
    for x in (0.0, 0.5, 0.75):
        world.place("robot", Pose2D(x))
        seen.append((body.state.far_ledge, body.state.near_ledge))
    assert seen == [(False, False), (True, False), (True, True)]
    bare = world.add_robot("bare", model("p3dx-sh"), Pose2D(0.75, 1.0, 0.0))
    assert not bare.state.far_ledge


def test_a_robot_whose_axle_passes_an_edge_hangs_there_until_it_is_lifted(model: Models, make_world: MakeWorld) -> None:
    world = make_world(STAIRS)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(0.5))
    drive(world, body, 0.3, 3.0)
    hung = world.truth("robot").pose
    assert hung.x == pytest.approx(1.0, abs=0.01)
    travelled = body.state.left_travel
    drive(world, body, -0.3, 2.0)
    assert world.truth("robot").pose.x == pytest.approx(hung.x, abs=0.001)
    assert body.state.left_travel == pytest.approx(travelled - 0.6, abs=0.1)
    world.place("robot", Pose2D(-1.0))
    drive(world, body, -0.3, 2.0)
    assert world.truth("robot").pose.x == pytest.approx(-1.6, abs=0.1)


def test_no_robot_is_put_where_there_is_no_floor(model: Models, make_world: MakeWorld) -> None:
    world = make_world(STAIRS)
    with pytest.raises(WorldError, match="stairs is in the way"):
        world.add_robot("robot", model("p3dx-sh"), Pose2D(2.0))


def test_a_drop_is_read_from_a_world_file(tmp_path: Path) -> None:
    path = tmp_path / "hole.toml"
    path.write_text('about = "a hole"\n[[drops]]\nname = "hole"\nat_m = [1.0, 2.0]\nsize_m = [0.5, 0.6]\n')
    assert load_world(path).drops == (Block(1.0, 2.0, 0.0, 0.5, 0.6, 0.0, "hole"),)
    path.write_text('about = "a hole"\n[[drops]]\nname = "hole"\nat_m = [1.0, 2.0]\nsize_m = [0.5, 0.0]\n')
    with pytest.raises(WorldError, match=r"drops\[0\] hole: length and width must be above 0 m"):
        load_world(path)

"""Doors that open and shut: read from files, by the seed and by hand, seen by sensors, and never onto a robot."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.body import ScanBeams
from p2os_emu.world import STEP, MovingDoor, Person, World, WorldError, WorldSpec, load_world
from p2os_emu.world.spec import DoorEntry, WallEntry

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

WALL = tuple(WallEntry((2.0, -3.0), (2.0, 3.0), "wall", doors=(DoorEntry(2.5, 1.0),)).blocks())
DOOR = MovingDoor("door", (2.0, -0.5), (2.0, 0.5))
ROOM = WorldSpec("room", walls=WALL, moving_doors=(DOOR,))
AHEAD = ScanBeams(x=0.0, y=0.0, height=0.3, first=0.0, step=pi / 360, count=1, reach=8.0)
FILE = """
about = "a door"

[[moving_doors]]
name = "door"
from_m = [2.0, -0.5]
to_m = [2.0, 0.5]
is_open = false
open_s = [3.0, 4.0]
shut_s = [1.0, 2.0]
speed_m_s = 0.5
colour = "red"
"""


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        world.step()


def test_moving_doors_are_read_from_a_world_file(tmp_path: Path) -> None:
    path = tmp_path / "room.toml"
    path.write_text(FILE)
    door = MovingDoor("door", (2.0, -0.5), (2.0, 0.5), False, (3.0, 4.0), (1.0, 2.0), 0.5, "red")
    assert load_world(path).moving_doors == (door,)
    assert door.width == 1.0


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("to_m = [2.0, 0.5]", "to_m = [2.0, -0.5]", r"moving_doors\[0\] door: from_m and to_m must differ"),
        ("speed_m_s = 0.5", "speed_m_s = 0.0", "speed_m_s must be above 0"),
        ("open_s = [3.0, 4.0]", "open_s = [4.0, 3.0]", "open_s must be a shortest and a longest time"),
        ('"red"', '"rad"', "did you mean red"),
    ],
)
def test_a_door_that_makes_no_sense_is_refused_with_a_reason(
    before: str, after: str, reason: str, tmp_path: Path
) -> None:
    path = tmp_path / "room.toml"
    path.write_text(FILE.replace(before, after))
    with pytest.raises(WorldError, match=reason):
        load_world(path)


def test_a_door_is_shut_and_opened_by_hand(make_world: MakeWorld) -> None:
    world = make_world(ROOM)
    run(world, 5.0)
    assert world.doors()["door"] == (1.0, 1.0), "it stays until somebody moves it"
    world.set_door("door", False)
    run(world, 1.0)
    assert world.doors()["door"].opening == pytest.approx(1.0 - DOOR.speed, abs=0.01)
    run(world, 1.0)
    assert world.doors()["door"].opening == 0.0
    world.set_door("door", True)
    run(world, 2.0)
    assert world.doors()["door"].opening == 1.0


def test_an_unknown_door_names_the_nearest(make_world: MakeWorld) -> None:
    with pytest.raises(WorldError, match="did you mean door"):
        make_world(ROOM).set_door("dor", True)


def test_a_door_opens_and_shuts_by_the_seed(make_world: MakeWorld) -> None:
    spec = replace(ROOM, moving_doors=(replace(DOOR, open_time=(2.0, 6.0), shut_time=(1.0, 2.0)),))

    def openings(seed: int) -> list[float]:
        world = make_world(spec, seed=seed)
        found = []
        for _ in range(40):
            run(world, 0.5)
            found.append(world.doors()["door"].opening)
        return found

    assert openings(1) == openings(1)
    assert openings(1) != openings(2)
    assert {0.0, 1.0} <= set(openings(1))


def test_a_shut_door_is_seen_by_scanner_and_sonar_and_an_open_one_is_not(model: Models, make_world: MakeWorld) -> None:
    world = make_world(ROOM)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    run(world, STEP)
    assert body.scan(AHEAD).ranges[0] > 8.0
    world.set_door("door", False)
    run(world, 2.0)
    assert body.scan(AHEAD).ranges[0] == pytest.approx(1.98)
    assert min(body.ping([3, 4])) == pytest.approx(1.98 - body.model.sonar[3].x, abs=0.03)


def test_a_robot_does_not_get_through_a_shut_door_and_that_is_a_touch(model: Models, make_world: MakeWorld) -> None:
    world = make_world(replace(ROOM, moving_doors=(replace(DOOR, is_open=False),)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(1.0, 0.0, 0.0))
    for _ in range(round(4.0 / STEP)):
        body.drive(0.4, 0.4)
        world.step()
    assert world.truth("robot").pose.x < 1.98 - body.chassis.front + 0.01
    assert [touch.what for touch in world.touches("robot").last] == ["door"]


@pytest.mark.parametrize("who", ["robot", "person"])
def test_a_door_waits_for_whoever_stands_in_it(who: str, model: Models, make_world: MakeWorld) -> None:
    there = Person("Anna", ((2.0, 0.0), (3.0, 0.0)), pause=(60.0, 60.0), begin=0.0, speed=0.1)
    world = make_world(replace(ROOM, people=(there,) if who == "person" else ()))
    if who == "robot":
        world.add_robot("robot", model("p3dx-sh"), Pose2D(2.0, 0.2, pi / 2))
    world.set_door("door", False)
    run(world, 2.0)
    assert world.doors()["door"].opening == 1.0
    if who == "robot":
        assert world.touches("robot").count == 0
        world.place("robot", Pose2D(0.0, 0.0, 0.0))
        run(world, 2.0)
    else:
        run(world, 5.0)
    assert world.doors()["door"].opening == 0.0


def test_people_wait_at_a_shut_door(make_world: MakeWorld) -> None:
    anna = Person("Anna", ((0.0, 0.0), (4.0, 0.0)), speed=1.0, patience=(30.0, 30.0))
    world = make_world(replace(ROOM, people=(anna,), moving_doors=(replace(DOOR, is_open=False),)))
    run(world, 4.0)
    assert 0.8 < world.people()["Anna"].x < 1.2
    world.set_door("door", True)
    run(world, 4.0)
    assert world.people()["Anna"].x > 2.5


def test_no_robot_is_put_onto_a_shut_door(model: Models, make_world: MakeWorld) -> None:
    world = make_world(ROOM)
    world.add_robot("robot", model("p3dx-sh"), Pose2D(2.0, 0.0, 0.0))
    world.place("robot", Pose2D(0.0, 0.0, 0.0))
    world.set_door("door", False)
    run(world, 2.0)
    with pytest.raises(WorldError, match="door is in the way"):
        world.place("robot", Pose2D(2.0, 0.0, 0.0))

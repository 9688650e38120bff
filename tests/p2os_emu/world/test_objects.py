"""Movable objects: read from files, pushed, seen, in the way."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, hypot, pi, sin
from pathlib import Path

import pytest

import configs
from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.world import STEP, RobotBody, World, WorldError, WorldSpec, load_world
from p2os_emu.world.chassis import HULL_BOTTOM
from p2os_emu.world.movable import LEAST_HEIGHT, Movable, Shape

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

CRATE = Movable("crate", Shape.BOX, Pose2D(1.0, 0.0, 0.0), 0.4, 0.6, 0.4, 3.0, 0.5, "brown")
ONE_CRATE = WorldSpec("one crate", objects=(CRATE,))
FILE = """
about = "things"

[[objects]]
name = "tin"
shape = "cylinder"
at_m = [1.0, 2.0]
size_m = [0.1, 0.1, 0.2]
mass_kg = 0.4
colour = "green"
heading_deg = 90.0
"""
WITH_BUMPERS = [
    name
    for name in configs.names("robots")
    if configs.load(RobotModel, "robots", name).front_bumpers or configs.load(RobotModel, "robots", name).rear_bumpers
]


def push(world: World, body: RobotBody, speed: float, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        body.drive(speed, speed)
        world.step()


def test_an_object_is_read_from_a_world_file(tmp_path: Path) -> None:
    path = tmp_path / "things.toml"
    path.write_text(FILE)
    tin = Movable("tin", Shape.CYLINDER, Pose2D(1.0, 2.0, pi / 2), 0.1, 0.1, 0.2, 0.4, 0.5, "green")
    assert load_world(path).objects == (tin,)


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("0.1, 0.1, 0.2", "0.1, 0.1, 0.03", r"objects\[0\] tin: it must be at least 0.06 m high"),
        ("0.1, 0.1, 0.2", "0.1, 0.2, 0.2", "make them equal"),
        ("0.1, 0.1, 0.2", "0.1, -0.1, 0.2", "must be above 0"),
        ("mass_kg = 0.4", "mass_kg = 0", "must be above 0"),
        ('"green"', '"gren"', "did you mean green"),
        ('"cylinder"', '"ball"', "shape must be one of box, cylinder"),
        ('name = "tin"', "", "name is missing"),
    ],
)
def test_an_object_that_makes_no_sense_is_refused_with_a_reason(
    before: str, after: str, reason: str, tmp_path: Path
) -> None:
    path = tmp_path / "things.toml"
    path.write_text(FILE.replace(before, after))
    with pytest.raises(WorldError, match=reason):
        load_world(path)


def test_two_objects_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "things.toml"
    path.write_text(FILE + FILE[FILE.index("[[objects]]") :])
    with pytest.raises(WorldError, match=r"objects\[1\] tin: there is one of this name already"):
        load_world(path)


def test_no_object_gets_under_a_hull() -> None:
    assert LEAST_HEIGHT > HULL_BOTTOM


def test_a_cylinders_footprint_is_round() -> None:
    tin = replace(CRATE, shape=Shape.CYLINDER, width=0.4)
    corners = tin.footprint(Pose2D(2.0, 1.0, 0.3))
    assert {round(hypot(x - 2.0, y - 1.0), 9) for x, y in corners} == {0.2}
    assert corners[0] == pytest.approx((2.0 + 0.2 * cos(0.3), 1.0 + 0.2 * sin(0.3)))


def test_an_object_stays_where_it_stands(make_world: MakeWorld) -> None:
    world = make_world(ONE_CRATE)
    for _ in range(600):
        world.step()
    place = world.object_places()["crate"]
    assert (place.x, place.y, place.z, place.heading) == pytest.approx((1.0, 0.0, 0.2, 0.0), abs=0.001)


def test_a_robot_pushes_a_crate_along(model: Models, make_world: MakeWorld) -> None:
    world = make_world(ONE_CRATE)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    push(world, body, 0.3, 5.0)
    place = world.object_places()["crate"]
    assert place.x > 1.3
    assert place.x == pytest.approx(world.truth("robot").pose.x + 0.21 + 0.2, abs=0.01)
    push(world, body, -0.3, 2.0)
    stood = world.object_places()["crate"].x
    push(world, body, -0.3, 1.0)
    assert world.object_places()["crate"].x == pytest.approx(stood, abs=0.001)


def test_a_crate_that_is_too_heavy_stalls_the_robot(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("heavy", objects=(replace(CRATE, mass=80.0),)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    push(world, body, 0.3, 5.0)
    assert world.object_places()["crate"].x == pytest.approx(1.0, abs=0.01)
    assert body.state.left_load == pytest.approx(1.0, abs=0.05)


def test_sonar_hears_an_object_that_is_as_high_as_its_discs(model: Models, make_world: MakeWorld) -> None:
    low = replace(CRATE, height=0.1)
    for crate, heard in ((CRATE, True), (low, False)):
        body = make_world(WorldSpec("crate", objects=(crate,))).add_robot("robot", model("p3dx-sh"), Pose2D())
        assert (body.ping([3])[0] < 1.0) is heard


def test_everything_that_moves_is_told_with_its_outline_and_height(model: Models, make_world: MakeWorld) -> None:
    world = make_world(ONE_CRATE)
    world.add_robot("robot", model("p3dx-sh"), Pose2D(-1.0, 0.0, pi / 2))
    crate, robot = world.moving
    assert crate.name == "crate"
    assert (crate.bottom, crate.top) == pytest.approx((0.0, 0.4), abs=1e-6)
    assert sorted((round(x, 6), round(y, 6)) for x, y in crate.footprint)[0] == (0.8, -0.3)
    assert robot.name == "robot"
    assert max(y for _, y in robot.footprint) == pytest.approx(0.21)
    world.place("robot", Pose2D(-2.0, 0.0, 0.0))
    _, robot = world.moving
    assert max(x for x, _ in robot.footprint) == pytest.approx(-2.0 + 0.21)
    world.remove_robot("robot")
    assert [each.name for each in world.moving] == ["crate"]


def test_no_robot_is_put_onto_an_object(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("full", objects=(replace(CRATE, pose=Pose2D()),)))
    with pytest.raises(WorldError, match="crate is in the way"):
        world.add_robot("robot", model("p3dx-sh"), Pose2D(0.3, 0.0, 0.0))
    world.add_robot("robot", model("p3dx-sh"))
    pose = world.truth("robot").pose
    assert hypot(pose.x, pose.y) > 0.5


@pytest.mark.parametrize("name", WITH_BUMPERS)
def test_every_bumper_feels_an_object_where_it_touches(name: str, model: Models, make_world: MakeWorld) -> None:
    shape = model(name)
    post = Movable("post", Shape.CYLINDER, Pose2D(), 0.1, 0.1, 0.4, 200.0, 1.0, "grey")
    for segments, ahead in ((shape.front_bumpers, 1), (shape.rear_bumpers, -1)):
        reach = shape.length_front if ahead > 0 else shape.length_rear
        for side in (-1, 0, 1) if segments else ():
            place = Pose2D(ahead * (reach + 0.1), side * 0.4 * shape.width)
            world = make_world(WorldSpec("post", objects=(replace(post, pose=place),)))
            body = world.add_robot("robot", shape, Pose2D())
            while not (body.state.front_bumpers or body.state.rear_bumpers) and world.time < 3.0:
                push(world, body, ahead * 0.1, 2 * STEP)
            front, rear = body.state.front_bumpers, body.state.rear_bumpers
            pressed, other = (front, rear) if ahead > 0 else (rear, front)
            felt = [segment - (segments - 1) / 2 for segment in range(segments) if pressed >> segment & 1]
            assert other == 0
            assert felt
            # Counted from right to left, in front and behind alike.
            assert all(segment * side > 0 if side else abs(segment) < 1 for segment in felt)


def test_the_lab_repeats_itself_bit_by_bit(model: Models, make_world: MakeWorld) -> None:
    def run() -> object:
        world = make_world(load_world("gripper-lab"), perfect=False)
        body = world.add_robot("robot", model("p3dx-sh"), Pose2D(3.5, 1.0, 0.1))
        push(world, body, 0.4, 3.0)
        return world.object_places(), world.truth("robot")

    assert run() == run()

"""Touches: what a robot bumps into is known by name and counted, and the floor is no touch."""

from collections.abc import Callable
from dataclasses import replace
from math import pi

import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.fit import read_fit
from p2os_emu.world import STEP, Block, RobotBody, World, WorldError, WorldSpec
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.touches import APART, REMEMBERED, TouchLog

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

WALL = Block(1.0, 0.0, pi / 2, 4.0, 0.1, 2.0, "north wall")
CRATE = Movable("crate", Shape.BOX, Pose2D(1.0, 0.0, 0.0), 0.4, 0.6, 0.4, 3.0, 0.5, "brown")


def drive(world: World, body: RobotBody, speed: float, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        body.drive(speed, speed)
        world.step()


@pytest.mark.parametrize("name", ["p3dx-sh", "powerbot-sh"])
def test_standing_and_driving_touch_nothing(name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name))
    drive(world, body, 0.5, 3.0)
    drive(world, body, 0.0, 1.0)
    assert world.touches("robot").count == 0


@pytest.mark.parametrize(
    ("spec", "what"),
    [
        (WorldSpec("a", walls=(WALL,)), "north wall"),
        (WorldSpec("a", walls=(replace(WALL, name=""),)), "a wall"),
        (WorldSpec("a", furniture=(replace(WALL, name="desk"),)), "desk"),
        (WorldSpec("a", furniture=(replace(WALL, name=""),)), "furniture"),
        (WorldSpec("a", objects=(CRATE,)), "crate"),
    ],
)
def test_a_touch_tells_when_and_what(spec: WorldSpec, what: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world(spec)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    drive(world, body, 0.3, 4.0)
    touches = world.touches("robot")
    assert touches.count == 1, "one that lasts is one"
    assert touches.last[0].what == what
    assert 1.5 < touches.last[0].time < 3.5


def test_two_robots_touch_each_other(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("happy", model("p3dx-sh"), Pose2D())
    world.add_robot("grumpy", model("p3dx-sh"), Pose2D(0.8, 0.0, 0.0))
    drive(world, body, 0.3, 3.0)
    assert [touch.what for touch in world.touches("happy").last] == ["grumpy"]
    assert [touch.what for touch in world.touches("grumpy").last] == ["happy"]


def test_touching_again_counts_again(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WorldSpec("a", walls=(WALL,)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    for _ in range(3):
        drive(world, body, 0.3, 3.0)
        drive(world, body, -0.3, 1.0)
    assert world.touches("robot").count == 3


def test_what_a_gripper_takes_is_no_touch_and_what_it_runs_into_is(model: Models, make_world: MakeWorld) -> None:
    _, fit = read_fit(["gripper"], model("p3dx-sh"))
    tin = Movable("tin", Shape.CYLINDER, Pose2D(0.6, 0.0, 0.0), 0.06, 0.06, 0.12, 0.3, 0.5, "red")
    world = make_world(WorldSpec("lab", objects=(tin,), walls=(WALL,)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D(), fit)
    drive(world, body, 0.2, 1.0)
    assert world.touches("robot").count == 0
    drive(world, body, 0.2, 4.0)
    assert "north wall" in {touch.what for touch in world.touches("robot").last}
    assert world.truth("robot").pose.x < 0.95 - body.chassis.front - 0.05, "the paddles were there first"


def test_a_log_keeps_the_latest_and_counts_them_all() -> None:
    log = TouchLog()
    for number in range(REMEMBERED + 5):
        log.note(number * 2 * APART, ["wall"])
        log.note(number * 2 * APART + 0.1, ["wall"])
    assert log.touches.count == REMEMBERED + 5
    assert len(log.touches.last) == REMEMBERED


def test_an_unknown_robot_touches_nothing(make_world: MakeWorld) -> None:
    with pytest.raises(WorldError, match="no robot 'happy'"):
        make_world().touches("happy")

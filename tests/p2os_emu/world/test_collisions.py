"""Walls stop robots, stall their wheels and press their bumpers."""

from collections.abc import Callable
from math import pi

import pytest

from geometry import Pose2D, wrap_angle
from p2os.robot_model import RobotModel
from p2os_emu.world import Block, RobotBody, World, WorldSpec

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

WALL_AT_TWO = WorldSpec("walled", walls=(Block(2.05, 0.0, 0.0, 0.1, 8.0, 2.0, "wall"),))


def push(world: World, body: RobotBody, speed: float, seconds: float) -> None:
    for _ in range(int(seconds * 120)):
        body.drive(speed, speed)
        world.step()


@pytest.mark.parametrize("speed", [0.3, -0.3, 1.0])
@pytest.mark.parametrize("name", ["p3dx", "powerbot", "amigo", "p3at"])
def test_a_wall_stalls_the_wheels(name: str, speed: float, model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    shape = model(name)
    body = world.add_robot("robot", shape, Pose2D(1.0, 0.0, 0.0 if speed > 0 else pi))
    push(world, body, speed, 4.0)
    reach = shape.length_front if speed > 0 else shape.length_rear
    held = world.truth("robot").pose
    assert held.x == pytest.approx(2.0 - reach, abs=0.003)
    assert body.state.left_load == pytest.approx(1.0, abs=0.01)
    assert body.state.right_load == pytest.approx(1.0, abs=0.01)
    assert abs(body.state.left_velocity) < 0.01
    push(world, body, speed, 2.0)
    after = world.truth("robot").pose
    assert (after.x, after.y) == pytest.approx((held.x, held.y), abs=0.001)
    assert wrap_angle(after.heading - held.heading) == pytest.approx(0.0, abs=0.001)


def test_a_robot_at_a_wall_can_back_away(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    body = world.add_robot("robot", model("powerbot"), Pose2D(1.0, 0.0, 0.0))
    push(world, body, 0.5, 3.0)
    push(world, body, -0.5, 2.0)
    assert world.truth("robot").pose.x == pytest.approx(0.6, abs=0.2)
    assert body.state.front_bumpers == 0


def test_a_wheel_that_turns_freely_carries_little_load(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    body = world.add_robot("robot", model("p3dx"), Pose2D(0.0, 0.0, pi))
    push(world, body, 0.3, 2.0)
    assert body.state.left_load < 0.05


def test_a_wall_ahead_presses_the_middle_of_the_front_bumper(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    body = world.add_robot("robot", model("powerbot"), Pose2D(1.0, 0.0, 0.0))
    assert body.state.front_bumpers == 0
    push(world, body, 0.3, 4.0)
    assert body.state.front_bumpers == 0b0111110
    assert body.state.rear_bumpers == 0


def test_a_wall_behind_presses_the_rear_bumper(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    body = world.add_robot("robot", model("powerbot"), Pose2D(1.0, 0.0, pi))
    push(world, body, -0.3, 4.0)
    assert body.state.rear_bumpers == 0b01110
    assert body.state.front_bumpers == 0


@pytest.mark.parametrize(("side", "segments"), [(-1, 0b0000110), (1, 0b0110000)])
def test_a_post_at_a_corner_presses_that_corner_only(
    side: int, segments: int, model: Models, make_world: MakeWorld
) -> None:
    shape = model("powerbot")
    post = Block(2.0, side * shape.width / 2, 0.0, 0.1, 0.1, 1.0)
    world = make_world(WorldSpec("post", furniture=(post,)))
    body = world.add_robot("robot", shape, Pose2D(1.2, 0.0, 0.0))
    pressed = 0
    for _ in range(240):
        body.drive(0.3, 0.3)
        world.step()
        pressed |= body.state.front_bumpers
    assert pressed
    assert pressed & ~segments == 0


def test_a_model_without_bumpers_feels_nothing(model: Models, make_world: MakeWorld) -> None:
    world = make_world(WALL_AT_TWO)
    body = world.add_robot("robot", model("p3dx"), Pose2D(1.0, 0.0, 0.0))
    push(world, body, 0.3, 4.0)
    assert body.state.front_bumpers == 0


def test_robots_bump_into_each_other(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    pusher = world.add_robot("pusher", model("powerbot"), Pose2D(0.0, 0.0, 0.0))
    pushed = world.add_robot("pushed", model("peoplebot-sh"), Pose2D(1.2, 0.0, 0.0))
    pushed.drive(0.0, 0.0)
    push(world, pusher, 0.5, 2.0)
    assert pusher.state.front_bumpers
    assert pushed.state.rear_bumpers
    assert pushed.state.front_bumpers == 0
    assert world.truth("pushed").pose.x > 1.21

"""What encoders see agrees with the truth in a perfect world, and differs from it as robots differ in another."""

from collections.abc import Callable
from math import degrees, hypot, pi

import pytest

from geometry import Pose2D, wrap_angle
from p2os.robot_model import RobotModel
from p2os_emu.world import STEP, RobotBody, World

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]
Roll = Callable[[World, RobotBody, float, float], None]

MODELS = ["p3dx", "powerbot", "amigo", "p3at", "peoplebot-sh"]


@pytest.mark.parametrize("name", MODELS)
def test_two_metres_straight_are_two_metres_true(name: str, model: Models, make_world: MakeWorld, roll: Roll) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name))
    roll(world, body, 2.0, 2.0)
    travelled = (body.state.left_travel + body.state.right_travel) / 2
    truth = world.truth("robot")
    assert travelled == pytest.approx(2.0, abs=0.001)
    assert truth.pose.x == pytest.approx(travelled, abs=0.002)
    assert truth.pose.y == pytest.approx(0.0, abs=0.002)
    assert degrees(truth.pose.heading) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("name", MODELS)
def test_a_quarter_turn_by_the_wheels_is_a_quarter_turn_true(
    name: str, direction: int, model: Models, make_world: MakeWorld, roll: Roll
) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name))
    arc = direction * body.model.wheel_track * pi / 4
    roll(world, body, -arc, arc)
    turned = (body.state.right_travel - body.state.left_travel) / body.model.wheel_track
    truth = world.truth("robot")
    assert degrees(turned) == pytest.approx(90 * direction, abs=0.2)
    assert degrees(wrap_angle(truth.pose.heading - turned)) == pytest.approx(0.0, abs=0.3)
    assert hypot(truth.pose.x, truth.pose.y) < 0.002


def test_driving_backwards_comes_back_to_the_start(model: Models, make_world: MakeWorld, roll: Roll) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"), Pose2D(1.0, 1.0, 2.0))
    roll(world, body, 1.0, 1.0)
    roll(world, body, -1.0, -1.0)
    truth = world.truth("robot").pose
    assert hypot(truth.x - 1.0, truth.y - 1.0) < 0.002


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("powered", [True, False])
def test_a_robot_at_rest_stays_there(name: str, powered: bool, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name), Pose2D(1.0, 2.0, 0.5))
    if powered:
        body.drive(0.0, 0.0)
    for _ in range(1200):
        world.step()
    pose = world.truth("robot").pose
    assert hypot(pose.x - 1.0, pose.y - 2.0) < 1e-5
    assert pose.heading == pytest.approx(0.5, abs=5e-5)


@pytest.mark.parametrize("name", MODELS)
def test_wheels_follow_a_steep_profile(name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model(name))
    for step in range(1, 61):
        body.drive(step * STEP, step * STEP)  # 1 m/s2
        world.step()
        assert body.state.left_velocity == pytest.approx(step * STEP, abs=0.02)
        assert body.state.left_load < 0.9
    truth = world.truth("robot")
    assert truth.linear == pytest.approx(0.5, abs=0.02)
    assert truth.angular == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("name", MODELS)
def test_a_robot_cruises_at_its_top_speed_without_effort(name: str, model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    shape = model(name)
    body = world.add_robot("robot", shape)
    top = shape.max_velocity
    for step in range(int(top / STEP) + 60):
        speed = min(top, step * STEP)
        body.drive(speed, speed)
        world.step()
    assert world.truth("robot").linear == pytest.approx(top, rel=0.001)
    assert body.state.left_load < 0.05


def test_a_robot_without_power_rolls_to_a_stop_soon(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"))
    for _ in range(240):
        body.drive(0.5, 0.5)
        world.step()
    before = world.truth("robot")
    body.release()
    for _ in range(240):
        world.step()
        assert body.state.left_load == 0.0
    after = world.truth("robot")
    assert before.linear == pytest.approx(0.5, abs=0.01)
    assert after.linear == pytest.approx(0.0, abs=0.001)
    assert 0.05 < after.pose.x - before.pose.x < 0.3


def test_driving_again_after_a_release_turns_the_wheels(model: Models, make_world: MakeWorld) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"))
    body.drive(0.2, 0.2)
    body.release()
    body.drive(0.2, 0.2)
    for _ in range(60):
        world.step()
    assert body.state.left_velocity == pytest.approx(0.2, abs=0.01)


def test_an_imperfect_robot_drives_otherwise_than_its_encoders_say(
    model: Models, make_world: MakeWorld, roll: Roll
) -> None:
    world = make_world(perfect=False, seed=3)
    body = world.add_robot("robot", model("p3dx"))
    roll(world, body, 2.0, 2.0)
    straight = world.truth("robot").pose
    arc = body.model.wheel_track * pi
    roll(world, body, -arc, arc)
    turned = wrap_angle(world.truth("robot").pose.heading - straight.heading)
    assert 0.001 < abs(straight.x - 2.0) < 0.02
    assert 0.001 < abs(straight.y) < 0.2
    assert 0.002 < abs(turned) < 0.15


def test_encoders_count_on_when_a_robot_is_lifted(model: Models, make_world: MakeWorld, roll: Roll) -> None:
    world = make_world()
    body = world.add_robot("robot", model("p3dx"))
    roll(world, body, 0.5, 0.5)
    before = body.state
    world.place("robot", Pose2D(4.0, -1.0, pi / 2))
    assert body.state.left_travel == before.left_travel
    for _ in range(120):
        world.step()
    pose = world.truth("robot").pose
    assert hypot(pose.x - 4.0, pose.y + 1.0) < 0.001
    assert body.state.left_travel == pytest.approx(before.left_travel, abs=0.001)

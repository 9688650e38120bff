"""What gyro and compass feel of the physics."""

from collections.abc import Callable

import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.fit import Fit
from p2os_emu.world import RobotBody, World

MakeWorld = Callable[..., World]
MakeModel = Callable[[str], RobotModel]


def spin(world: World, body: RobotBody) -> None:
    body.drive(-0.1, 0.1)
    for _ in range(240):
        world.step()


@pytest.mark.parametrize("part", ["gyro", "compass"])
def test_hull_that_turns_is_felt_where_a_sensor_for_it_is_fitted(
    make_world: MakeWorld, model: MakeModel, part: str
) -> None:
    world = make_world()
    body = world.add_robot("happy", model("p3dx-sh"), Pose2D(0.0, 0.0, 1.0), Fit({part: ""}))
    spin(world, body)
    truth = world.truth("happy")
    assert body.state.turn_rate == pytest.approx(truth.angular)
    assert truth.angular > 0.3
    assert body.state.heading == pytest.approx(truth.pose.heading)


def test_nothing_is_read_where_nothing_feels_it(make_world: MakeWorld, model: MakeModel) -> None:
    world = make_world()
    body = world.add_robot("happy", model("p3dx-sh"), Pose2D(0.0, 0.0, 1.0))
    spin(world, body)
    assert (body.state.turn_rate, body.state.heading) == (0.0, 0.0)

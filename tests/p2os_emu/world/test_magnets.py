from collections.abc import Callable
from math import atan2, pi, radians
from random import Random

import pytest

import configs
from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.accessories.tcm2 import Tcm2, Tcm2Spec
from p2os_emu.fit import Fit
from p2os_emu.world import World, WorldSpec
from p2os_emu.world.magnets import MagnetEntry, field_at

MAGNET = MagnetEntry((1.0, 2.0), 20.0, heading_deg=90.0).magnet()


def test_field_falls_with_the_cube_of_the_distance_and_stays_finite() -> None:
    assert field_at([MAGNET], 2.0, 2.0) == pytest.approx((0.0, 20e-6))
    assert field_at([MAGNET], 3.0, 2.0) == pytest.approx((0.0, 20e-6 / 8))
    assert field_at([MAGNET], 1.0, 2.0) == pytest.approx(field_at([MAGNET], 1.2, 2.0))
    assert field_at([], 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize(("parts", "feels"), [({"compass": "tcm2"}, True), ({}, False)])
def test_only_robots_with_a_compass_feel_magnets(
    make_world: Callable[..., World], model: Callable[[str], RobotModel], parts: dict[str, str], feels: bool
) -> None:
    world = make_world(WorldSpec("lab", magnets=(MAGNET,)))
    body = world.add_robot("happy", model("p3dx-sh"), Pose2D(2.0, 2.0, 0.0), Fit(parts))
    world.step()
    assert (body.state.magnetic[1] > 19e-6) is feels


def test_compass_beside_a_magnet_is_off_by_the_angle_of_both_fields() -> None:
    spec = configs.load(Tcm2Spec, "accessories", "tcm2")
    module = Tcm2(spec, Random(1))
    nearby = (spec.horizontal_t, 0.0)  # as strong as the earth's, and across it
    clockwise = module.measure(0.0, nearby).heading
    assert (clockwise + pi) % (2 * pi) - pi == pytest.approx(
        atan2(spec.horizontal_t, spec.horizontal_t), abs=radians(20)
    )

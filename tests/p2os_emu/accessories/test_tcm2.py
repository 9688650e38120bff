from dataclasses import replace
from math import hypot, pi, radians
from random import Random
from statistics import pstdev

import pytest

import configs
from p2os_emu.accessories.tcm2 import FULL_SCORE, Tcm2, Tcm2Spec


@pytest.fixture
def spec() -> Tcm2Spec:
    return configs.load(Tcm2Spec, "accessories", "tcm2")


@pytest.fixture
def ideal(spec: Tcm2Spec) -> Tcm2Spec:
    return replace(spec, hard_iron_t=0.0, field_noise_t=0.0, tilt_noise_deg=0.0)


def error(module: Tcm2, heading: float) -> float:
    """How far the module's heading lies beside the true one, rad."""
    clockwise = radians(module.spec.north_deg) - heading
    return (module.measure(heading).heading - clockwise + pi) % (2 * pi) - pi


@pytest.mark.parametrize(("heading", "compass"), [(90, 0), (0, 90), (-90, 180), (180, 270)])
def test_it_counts_clockwise_from_north_which_lies_along_y(ideal: Tcm2Spec, heading: float, compass: float) -> None:
    report = Tcm2(ideal, Random(1)).measure(radians(heading))
    assert (report.heading - radians(compass) + pi) % (2 * pi) - pi == pytest.approx(0.0, abs=1e-9)


def test_the_field_is_the_earths(ideal: Tcm2Spec) -> None:
    report = Tcm2(ideal, Random(1)).measure(radians(30))
    assert hypot(report.field_x, report.field_y) == pytest.approx(ideal.horizontal_t)
    assert report.field_z == pytest.approx(ideal.down_t)


def test_the_robots_own_iron_bends_headings_by_degrees(spec: Tcm2Spec) -> None:
    errors = [error(Tcm2(spec, Random(seed)), 0.0) for seed in range(100)]
    assert radians(3) < pstdev(errors) < radians(20)


def turn(module: Tcm2, angle: float) -> None:
    for step in range(101):
        module.measure(angle * step / 100)


def test_a_calibration_over_a_full_turn_takes_the_iron_away(spec: Tcm2Spec) -> None:
    module = Tcm2(spec, Random(3))
    before = max(abs(error(module, radians(angle))) for angle in range(0, 360, 10))
    module.begin_calibration()
    turn(module, 2 * pi)
    module.end_calibration()
    after = max(abs(error(module, radians(angle))) for angle in range(0, 360, 10))
    assert after < radians(2) < before
    assert module.measure(0.0).h_score == FULL_SCORE
    module.reset()
    assert max(abs(error(module, radians(angle))) for angle in range(0, 360, 10)) > radians(2)


def test_a_calibration_over_half_a_turn_is_scored_and_not_used(spec: Tcm2Spec) -> None:
    module = Tcm2(replace(spec, field_noise_t=0.0), Random(3))
    before = error(module, 1.0)
    module.begin_calibration()
    turn(module, pi)
    module.end_calibration()
    assert error(module, 1.0) == pytest.approx(before)
    assert 0 < module.measure(0.0).h_score < FULL_SCORE


def test_a_calibration_that_saw_nothing_changes_nothing(spec: Tcm2Spec) -> None:
    module = Tcm2(spec, Random(3))
    module.end_calibration()
    module.begin_calibration()
    assert module.is_calibrating
    module.end_calibration()
    assert module.measure(0.0).h_score == 0

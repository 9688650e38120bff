"""A body behind its faults: healthy it passes everything on, and each fault changes what it must and no more."""

from itertools import pairwise
from math import inf
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os_emu.faulty_body import HEALTHY_SONAR, FaultyBody, SonarFaults
from tests.p2os_emu.microcontroller.bench import STEP, PlainBody

RATIOS = st.floats(0.0, 1.0)
SPEEDS = st.floats(-1.0, 1.0)


class Rig:
    def __init__(self) -> None:
        self.machine = PlainBody()
        self.body = FaultyBody(self.machine, Random(1))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.body.advance(STEP)
            self.machine.step(STEP)


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_healthy_body_is_the_machine_itself(rig: Rig) -> None:
    rig.body.drive(0.3, 0.2)
    rig.run(1.0)
    assert rig.body.state == rig.machine.state
    assert rig.body.ping([3, 5]) == rig.machine.ping([3, 5])
    rig.body.release()
    assert not rig.machine.powered


@given(RATIOS, SPEEDS, SPEEDS)
def test_slipping_wheels_turn_as_commanded_and_roll_less(grip: float, left: float, right: float) -> None:
    rig = Rig()
    rig.body.grip = grip, 1.0
    rig.body.drive(left, right)
    rig.run(1.0)
    state, true = rig.body.state, rig.machine.state
    assert (state.left_velocity, state.right_velocity) == pytest.approx((left, right))
    assert (state.left_travel, state.right_travel) == pytest.approx((left, right))
    assert (true.left_travel, true.right_travel) == pytest.approx((left * grip, right))


def test_encoders_do_not_jump_when_slipping_begins_or_ends_in_mid_drive(rig: Rig) -> None:
    rig.body.drive(0.5, 0.5)
    travels = []
    for grip in (1.0, 0.4, 0.0, 1.0):
        rig.body.grip = grip, grip
        for _ in range(30):
            rig.run(STEP)
            travels.append(rig.body.state.left_travel)
    steps = [after - before for before, after in pairwise(travels)]
    assert steps == pytest.approx([0.5 * STEP] * len(steps))
    assert rig.machine.state.left_travel == pytest.approx(0.5 * 0.25 * (1.0 + 0.4 + 0.0 + 1.0))


def test_blocked_wheel_stands_while_its_motor_strives(rig: Rig) -> None:
    rig.body.drive(0.5, 0.5)
    rig.run(0.5)
    rig.body.blocked = True, False
    rig.run(0.5)
    state = rig.body.state
    assert (state.left_velocity, state.left_load) == (0.0, 1.0)
    assert (state.right_velocity, state.right_load) == (0.5, rig.machine.state.right_load)
    rig.body.release()
    assert rig.body.state.left_load < 1.0, "without power it does not strive"
    rig.body.drive(0.5, 0.5)
    rig.body.blocked = False, False
    rig.run(0.5)
    assert rig.body.state.left_velocity == 0.5


def test_blocked_wheel_does_not_slip(rig: Rig) -> None:
    rig.body.grip = 0.5, 0.5
    rig.body.blocked = True, True
    rig.body.drive(0.5, 0.5)
    rig.run(1.0)
    assert rig.body.state.left_travel == rig.machine.state.left_travel == 0.0


def test_discs_hear_nothing_or_always_the_same_or_what_they_hear(rig: Rig) -> None:
    rig.body.sonar = SonarFaults(dead=frozenset({1}), stuck={2: 0.7})
    assert rig.body.ping([0, 1, 2, 3]) == [pytest.approx(1.0), inf, 0.7, pytest.approx(1.3)]
    rig.body.sonar = HEALTHY_SONAR
    assert rig.body.ping([1, 2]) == pytest.approx([1.1, 1.2])


def test_noisy_disc_hears_phantoms_in_its_share_of_firings_by_its_seed() -> None:
    def heard() -> list[float]:
        rig = Rig()
        rig.body.sonar = SonarFaults(noisy={0: 0.25})
        return [rig.body.ping([0])[0] for _ in range(2000)]

    first = heard()
    assert first == heard()
    phantoms = [each for each in first if each != 1.0]
    assert len(phantoms) / len(first) == pytest.approx(0.25, abs=0.04)
    assert all(0.1 <= each <= 5.0 for each in phantoms)

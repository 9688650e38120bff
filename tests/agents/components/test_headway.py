"""What is blocked is told from what is slow."""

import pytest

from agents.components.pose_control import Headway, Velocity
from geometry import Pose2D, Twist2D, integrate

STEP = 0.1  # s between two odometries


def blocked_after(told: Velocity, twist: Twist2D, seconds: float = 20.0) -> float | None:
    """s after which a robot that is told one thing and does another is found to be blocked."""
    pose = Pose2D(0.0, 0.0, 0.0)
    headway = Headway(pose, 0.0)
    for number in range(1, round(seconds / STEP)):
        pose = integrate(pose, twist, STEP)
        rolls = abs(twist.linear) > 0.01 or abs(twist.angular) > 0.02
        if headway.is_blocked(pose, rolls, told, number * STEP):
            return number * STEP
    return None


@pytest.mark.parametrize(
    "told", [Velocity(0.4, 0.0), Velocity(0.05, 0.0), Velocity(0.3, 2.0), Velocity(-0.2, 0.0), Velocity(0.0, 0.3)]
)
def test_who_does_as_told_is_not_blocked(told: Velocity) -> None:
    assert blocked_after(told, Twist2D(told.linear, told.angular)) is None


def test_who_is_slow_because_the_robot_goes_no_faster_is_not_blocked() -> None:
    assert blocked_after(Velocity(99.0, 0.0), Twist2D(0.3, 0.0)) is None


def test_who_is_told_to_stand_is_not_blocked() -> None:
    assert blocked_after(Velocity(0.0, 0.0), Twist2D(0.0, 0.0)) is None


@pytest.mark.parametrize("told", [Velocity(0.4, 0.0), Velocity(0.02, 0.0), Velocity(0.0, 0.5)])
def test_who_stands_is_blocked_soon(told: Velocity) -> None:
    assert blocked_after(told, Twist2D(0.0, 0.0)) == pytest.approx(1.5, abs=0.2)


def test_who_creeps_and_turns_along_a_thing_is_blocked() -> None:
    assert blocked_after(Velocity(0.15, -0.8), Twist2D(0.02, 0.1)) == pytest.approx(3.0, abs=0.2)

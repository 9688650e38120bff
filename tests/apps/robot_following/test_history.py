"""Poses by time, and what shows that odometry has begun anew."""

import pytest

from apps.robot_following.history import StampedPoses
from geometry import Pose2D, Twist2D

BEYOND = 0.5  # s


@pytest.fixture
def poses() -> StampedPoses:
    """A robot that drives at 0.4 m/s; its last pose is (3, 1), at 10 s."""
    poses = StampedPoses(BEYOND)
    for step in range(5):
        poses.add(9.6 + 0.1 * step, Pose2D(2.84 + 0.04 * step, 1.0), Twist2D(0.4))
    return poses


@pytest.mark.parametrize(
    ("stamp", "x", "is_jump"),
    [
        (10.1, 3.04, False),
        (10.1, 0.0, True),
        (12.5, 3.9, False),  # it has rolled on until its watchdog stopped it
        (12.5, 0.0, True),
        (40.0, 0.0, True),
        (9.9, 0.0, True),
    ],
)
def test_a_pose_that_no_robot_comes_to_is_a_jump_however_long_the_readings_were_away(
    poses: StampedPoses, stamp: float, x: float, is_jump: bool
) -> None:
    assert poses.is_jump(stamp, Pose2D(x, 1.0)) == is_jump


def test_the_first_pose_is_no_jump() -> None:
    assert not StampedPoses(BEYOND).is_jump(1.0, Pose2D(9.0))

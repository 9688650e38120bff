"""The waypoint follower, driven on an ideal robot in virtual time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.waypoints import Follower
from geometry import Pose2D, Twist2D, integrate

DT = 0.1
SQUARE = [(2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)]


def drive(follower: Follower, pose: Pose2D, seconds: float = 120.0) -> list[Pose2D]:
    """Follow with a robot that does exactly what it is told, and return every pose."""
    poses = [pose]
    for _ in range(round(seconds / DT)):
        if follower.is_done:
            break
        poses.append(integrate(poses[-1], follower.steer(poses[-1]), DT))
    return poses


def test_follower_passes_every_waypoint_and_ends_on_the_last() -> None:
    follower = Follower(SQUARE)
    end = drive(follower, Pose2D())[-1]
    assert follower.is_done
    assert math.hypot(end.x, end.y) < 0.1


def test_follower_stays_on_the_legs_between_waypoints() -> None:
    for pose in drive(Follower(SQUARE), Pose2D()):
        off = min(abs(pose.x), abs(pose.x - 2.0), abs(pose.y), abs(pose.y - 2.0))
        assert off < 0.1


def test_follower_turns_on_the_spot_before_it_drives_away_from_behind_it() -> None:
    twist = Follower([(-1.0, 0.0)]).steer(Pose2D())
    assert twist.linear == 0.0
    assert abs(twist.angular) > 0.5


def test_follower_halts_when_there_is_nowhere_to_go() -> None:
    assert Follower([]).steer(Pose2D(1.0, 2.0, 3.0)) == Twist2D(0.0, 0.0)


def test_follower_passes_a_waypoint_that_it_stands_on() -> None:
    follower = Follower([(0.0, 0.0), (0.0, 0.0)])
    assert follower.steer(Pose2D()) == Twist2D(0.0, 0.0)
    assert follower.is_done


@given(x=st.floats(-3, 3), y=st.floats(-3, 3), heading=st.floats(-3.1, 3.1))
def test_follower_arrives_from_any_pose(x: float, y: float, heading: float) -> None:
    follower = Follower([(1.0, -1.0), (0.0, 0.0)])
    end = drive(follower, Pose2D(x, y, heading))[-1]
    assert follower.is_done
    assert math.hypot(end.x, end.y) == pytest.approx(0.0, abs=0.12)

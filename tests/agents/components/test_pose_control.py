"""Steering as pure functions, on a robot that does at once what it is told."""

from math import cos, hypot, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.components.pose_control import PoseControlLimits, PoseGoal
from geometry import Pose2D, Twist2D, integrate, wrap_angle

LIMITS = PoseControlLimits(0.4, 0.8)
DT = 0.1
places = st.floats(-5.0, 5.0)
headings = st.floats(-pi + 1e-6, pi)


@given(places, places, headings, st.one_of(st.none(), headings))
def test_every_goal_is_reached_from_everywhere(x: float, y: float, start: float, end: float | None) -> None:
    pose, goal, is_there = Pose2D(0.0, 0.0, start), PoseGoal(x, y, end), False
    for _ in range(round((10.0 + 4.0 * hypot(x, y)) / LIMITS.linear / DT)):
        velocity, is_there = LIMITS.towards(goal, pose, is_there)
        assert abs(velocity.linear) <= LIMITS.linear
        assert abs(velocity.angular) <= LIMITS.angular
        assert velocity.linear >= 0.0  # its sensors look ahead
        if velocity.is_done:
            break
        pose = integrate(pose, Twist2D(velocity.linear, velocity.angular), DT)
    assert velocity.is_done
    assert goal.distance(pose) < 0.1
    assert end is None or abs(wrap_angle(end - pose.heading)) < 0.05


@given(st.floats(-3.0, 3.0), headings, st.floats(-0.05, 0.05), st.floats(-0.2, 0.2))
def test_a_straight_way_is_kept_to_forward_and_backward(
    distance: float, heading: float, aside: float, askew: float
) -> None:
    start = Pose2D(1.0, -2.0, heading)
    pose = start.compose(Pose2D(0.0, aside, askew))
    for _ in range(1000):
        velocity = LIMITS.along(start, distance, pose)
        if velocity.is_done:
            break
        assert velocity.linear * distance > 0.0
        pose = integrate(pose, Twist2D(velocity.linear, velocity.angular), DT)
    done, off = start.locate(pose.x, pose.y)
    assert velocity.is_done
    assert done == pytest.approx(distance, abs=0.05)
    assert abs(off) < 0.2


def test_who_comes_near_slows_down() -> None:
    speeds = [LIMITS.towards(PoseGoal(left, 0.0), Pose2D())[0].linear for left in (2.0, 0.3, 0.1)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] == LIMITS.linear
    assert speeds[-1] < 0.2


def test_a_goal_behind_is_turned_to_before_anything_is_driven() -> None:
    velocity, _ = LIMITS.towards(PoseGoal(cos(2.5), sin(2.5)), Pose2D())
    assert velocity.linear == 0.0
    assert velocity.angular > 0.0


def test_at_the_place_a_small_slip_is_not_driven_back() -> None:
    goal = PoseGoal(0.07, 0.0, 1.0)
    assert LIMITS.towards(goal, Pose2D(), was_there=True)[0].linear == 0.0
    assert LIMITS.towards(goal, Pose2D(), was_there=False)[0].linear > 0.0

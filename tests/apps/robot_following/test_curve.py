"""The curve from the follower to the leader."""

from math import atan2, hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.robot_following.curve import BezierCurve
from geometry import Pose2D, wrap_angle

ANGLES = st.floats(-pi, pi)
NEAR = st.floats(-5.0, 5.0)


def test_straight_ahead_it_is_a_straight_line_of_even_pace() -> None:
    curve = BezierCurve.between(Pose2D(0.0, 0.0, 0.0), Pose2D(3.0, 0.0, 0.0), 1 / 3)
    assert curve.length == pytest.approx(3.0)
    assert curve.at(np.array([0.0, 0.5, 1.0])) == pytest.approx(np.array([[0.0, 0.0], [1.5, 0.0], [3.0, 0.0]]))
    assert curve.pose_after(0.75).x == pytest.approx(0.75, abs=1e-3)


@given(NEAR, NEAR, ANGLES, ANGLES)
def test_it_leads_from_pose_to_pose_along_both_headings(x: float, y: float, first: float, last: float) -> None:
    if hypot(x, y) < 0.1:
        return
    curve = BezierCurve.between(Pose2D(0.0, 0.0, first), Pose2D(x, y, last), 0.4)
    begin, end = curve.pose_after(0.0), curve.pose_after(curve.length)
    assert (begin.x, begin.y, end.x, end.y) == pytest.approx((0.0, 0.0, x, y), abs=1e-9)
    assert wrap_angle(begin.heading - first) == pytest.approx(0.0, abs=1e-6)
    assert wrap_angle(end.heading - last) == pytest.approx(0.0, abs=1e-6)
    assert curve.length >= hypot(x, y) * 0.999


@given(NEAR, NEAR, ANGLES)
def test_it_turns_with_what_it_joins(x: float, y: float, turn: float) -> None:
    if hypot(x, y) < 0.1:
        return
    here, there, turned = Pose2D(0.0, 0.0, 0.3), Pose2D(x, y, 1.0), Pose2D(1.0, -2.0, turn)
    plain = BezierCurve.between(here, there, 0.4)
    moved = BezierCurve.between(turned.compose(here), turned.compose(there), 0.4)
    for parameter in (0.2, 0.7):
        at = plain.at(np.array([parameter]))[0]
        assert moved.at(np.array([parameter]))[0] == pytest.approx(turned.transform(*at.tolist()), abs=1e-9)


def test_beyond_its_end_is_its_end() -> None:
    curve = BezierCurve.between(Pose2D(0.0, 0.0, 0.0), Pose2D(1.0, 1.0, pi / 2), 0.4)
    end = curve.pose_after(9.0)
    assert (end.x, end.y) == pytest.approx((1.0, 1.0))
    assert end.heading == pytest.approx(atan2(1.0, 0.0))

from math import cos, hypot, inf, isclose, nan, pi, sin, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import Pose2D, Twist2D, integrate, wrap_angle

angles = st.floats(-1e4, 1e4)
headings = st.floats(-pi, pi, exclude_min=True)
metres = st.floats(-50.0, 50.0)
poses = st.builds(Pose2D, metres, metres, headings)
twists = st.builds(Twist2D, st.floats(-3.0, 3.0), st.floats(-6.0, 6.0))
times = st.floats(0.0, 5.0)


def assert_same(a: Pose2D, b: Pose2D, tolerance: float = 1e-9) -> None:
    assert hypot(a.x - b.x, a.y - b.y) < tolerance
    assert abs(wrap_angle(a.heading - b.heading)) < tolerance


@given(angles)
def test_a_wrapped_angle_lies_in_the_half_open_turn_and_points_the_same_way(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -pi < wrapped <= pi
    assert isclose(cos(wrapped), cos(angle), abs_tol=1e-9)
    assert isclose(sin(wrapped), sin(angle), abs_tol=1e-9)


@pytest.mark.parametrize(("angle", "wrapped"), [(pi, pi), (-pi, pi), (3 * pi, pi), (tau, 0.0), (-0.5, -0.5)])
def test_the_ends_of_the_turn_wrap_to_plus_pi(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped)


@pytest.mark.parametrize("angle", [nan, inf])
def test_an_angle_that_is_no_number_is_refused(angle: float) -> None:
    with pytest.raises(ValueError, match="not finite"):
        wrap_angle(angle)


@given(poses, twists, times, times)
def test_one_long_step_equals_two_short_ones(pose: Pose2D, twist: Twist2D, first: float, second: float) -> None:
    assert_same(integrate(pose, twist, first + second), integrate(integrate(pose, twist, first), twist, second), 1e-7)


@given(poses, twists)
def test_no_time_is_no_motion(pose: Pose2D, twist: Twist2D) -> None:
    assert_same(integrate(pose, twist, 0.0), pose)


@given(poses, twists, times)
def test_driving_backwards_undoes_driving(pose: Pose2D, twist: Twist2D, dt: float) -> None:
    there = integrate(pose, twist, dt)
    assert_same(integrate(there, Twist2D(-twist.linear, -twist.angular), dt), pose, 1e-7)


def test_a_quarter_circle_of_one_metre_ends_beside_its_centre() -> None:
    assert_same(integrate(Pose2D(), Twist2D(pi / 2, pi / 2), 1.0), Pose2D(1.0, 1.0, pi / 2))


def test_a_straight_line_keeps_its_heading() -> None:
    assert_same(integrate(Pose2D(1.0, 2.0, pi / 2), Twist2D(0.5, 0.0), 2.0), Pose2D(1.0, 3.0, pi / 2))


@pytest.mark.parametrize("dt", [-0.1, nan, inf])
def test_a_time_that_runs_backwards_or_is_no_number_is_refused(dt: float) -> None:
    with pytest.raises(ValueError, match="dt"):
        integrate(Pose2D(), Twist2D(1.0, 0.0), dt)


@given(poses, poses)
def test_relative_to_undoes_compose(origin: Pose2D, other: Pose2D) -> None:
    assert_same(origin.compose(other).relative_to(origin), other)


@given(poses, metres, metres)
def test_a_transformed_point_keeps_its_distance_from_the_pose(pose: Pose2D, x: float, y: float) -> None:
    world_x, world_y = pose.transform(x, y)
    assert isclose(hypot(world_x - pose.x, world_y - pose.y), hypot(x, y), abs_tol=1e-9)


@given(poses, metres, metres)
def test_locate_undoes_transform(pose: Pose2D, x: float, y: float) -> None:
    assert pose.locate(*pose.transform(x, y)) == pytest.approx((x, y), abs=1e-9)


def test_a_bearing_is_taken_from_straight_ahead() -> None:
    assert Pose2D(1.0, 1.0, pi / 2).bearing_to(0.0, 1.0) == pytest.approx(pi / 2)
    assert Pose2D(0.0, 0.0, pi).bearing_to(0.0, 2.0) == pytest.approx(-pi / 2)

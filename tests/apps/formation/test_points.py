"""The leader's path, the virtual points on it and beside it, the assignment, and the twist towards a point."""

import math

import numpy as np
import pytest

from apps.formation.path import LeaderPath
from apps.formation.settings import FormationSettings
from apps.formation.shapes import assign
from apps.formation.tracking import VirtualPoint, frame_point, path_point, twist_towards
from geometry import Pose2D, Twist2D, integrate

TUNING = FormationSettings.load().tracking
ORIGIN = Pose2D()


def driven(*legs: tuple[Twist2D, float], start: Pose2D = ORIGIN) -> tuple[LeaderPath, Pose2D]:
    """A path of twists and their times in s, and the pose at its end."""
    path, pose = LeaderPath(20.0), start
    path.add(pose)
    for twist, seconds in legs:
        for _ in range(round(seconds / 0.1)):
            pose = integrate(pose, twist, 0.1)
            path.add(pose)
    return path, pose


def test_before_its_first_pose_the_path_is_straight() -> None:
    path, _ = driven(start=Pose2D(1.0, 1.0, math.pi / 2))
    at = path.at(2.0)
    assert (at.x, at.y, at.heading) == pytest.approx((1.0, -1.0, math.pi / 2))


def test_a_point_behind_is_where_the_leader_was() -> None:
    path, _ = driven((Twist2D(0.2, 0.0), 10.0), (Twist2D(0.2, 0.2), 10.0))
    expected = integrate(Pose2D(2.0, 0.0, 0.0), Twist2D(0.2, 0.2), 5.0)
    at = path.at(1.0)
    assert math.dist((at.x, at.y), (expected.x, expected.y)) < 0.01
    assert at.heading == pytest.approx(expected.heading, abs=0.02)
    assert path.curvature(1.0) == pytest.approx(1.0, abs=0.02)


def test_a_turn_on_the_spot_does_not_swing_the_points_round() -> None:
    path, _ = driven((Twist2D(0.2, 0.0), 10.0), (Twist2D(0.0, 0.5), 3.0))
    at = path.at(1.0)
    assert (at.x, at.y, at.heading) == pytest.approx((1.0, 0.0, 0.0), abs=0.02)


def test_a_leader_that_reverses_makes_its_path_shorter() -> None:
    path, _ = driven((Twist2D(0.2, 0.0), 10.0), (Twist2D(-0.2, 0.0), 5.0))
    assert path.at(0.5).x == pytest.approx(0.5, abs=0.04)


def test_where_a_point_is_beside_the_path() -> None:
    path, _ = driven((Twist2D(0.2, 0.0), 10.0))
    backs, lefts = path.locate(np.array([[1.0, 0.5], [3.0, -0.5]]), 2.0, 5.0)
    assert backs.tolist() == pytest.approx([1.0, -1.0], abs=0.01)
    assert lefts.tolist() == pytest.approx([0.5, -0.5], abs=0.01)


def test_the_inner_point_is_slower_than_the_outer_one() -> None:
    twist = Twist2D(0.2, 0.2)
    path, pose = driven((twist, 20.0))
    assert path_point(path, twist, (-0.5, 0.5)).twist.linear == pytest.approx(0.1, abs=0.01)
    assert path_point(path, twist, (-0.5, -0.5)).twist.linear == pytest.approx(0.3, abs=0.01)
    assert frame_point(pose, twist, (0.0, 0.5)).twist.linear == pytest.approx(0.1)


@pytest.mark.parametrize("offset", [(-0.87, 0.5), (-0.87, -0.5), (0.0, 1.0), (0.5, 0.5)])
def test_a_point_of_the_frame_moves_as_its_velocity_tells(offset: tuple[float, float]) -> None:
    twist, pose = Twist2D(0.25, 0.15), Pose2D(1.0, 2.0, 0.5)
    now, later = (frame_point(at, twist, offset) for at in (pose, integrate(pose, twist, 1e-3)))
    speed = math.dist((now.pose.x, now.pose.y), (later.pose.x, later.pose.y)) / 1e-3
    direction = math.atan2(later.pose.y - now.pose.y, later.pose.x - now.pose.x)
    assert speed == pytest.approx(now.twist.linear, rel=1e-3)
    assert direction == pytest.approx(now.pose.heading, abs=1e-3)


@pytest.mark.parametrize("start", [Pose2D(-1.0, 0.5, 0.0), Pose2D(0.5, 1.0, math.pi), Pose2D(-0.3, -0.8, -2.0)])
def test_a_robot_comes_to_a_moving_point_and_stays_with_it(start: Pose2D) -> None:
    twist = Twist2D(0.2, 0.1)
    target, robot = Pose2D(), start
    for _ in range(200):
        robot = integrate(robot, twist_towards(VirtualPoint(target, twist), robot, TUNING), 0.1)
        target = integrate(target, twist, 0.1)
    assert math.dist((robot.x, robot.y), (target.x, target.y)) < 0.03


def test_a_robot_at_a_point_that_stands_stands_too() -> None:
    point = VirtualPoint(Pose2D(1.0, 0.0, 0.0), Twist2D())
    assert twist_towards(point, Pose2D(0.97, 0.0, 1.0), TUNING) == Twist2D()


def test_no_twist_exceeds_the_limits() -> None:
    for heading in np.linspace(-3.0, 3.0, 13):
        twist = twist_towards(VirtualPoint(Pose2D(9.0, 9.0), Twist2D(0.3, 0.0)), Pose2D(0.0, 0.0, heading), TUNING)
        assert abs(twist.linear) <= TUNING.speed_m_s
        assert abs(twist.angular) <= TUNING.turn_rad_s


@pytest.mark.parametrize("count", [3, 9])
def test_the_straight_ways_to_the_points_do_not_cross(count: int) -> None:
    robots = {f"robot-{number}": (0.0, float(number)) for number in range(count)}
    points = [(5.0, float(number)) for number in reversed(range(count))]
    assigned = assign(robots, points)
    assert [points[assigned[f"robot-{number}"]][1] for number in range(count)] == list(range(count))

"""Avoidance: no admissible twist leads to a collision, and narrow places are seen."""

import math

import pytest

from apps.formation.avoidance import MovingDisc, admissible_twist
from apps.formation.passages import EchoMemory
from apps.formation.path import LeaderPath
from apps.formation.settings import FormationSettings
from geometry import Point, Pose2D, Twist2D, integrate

SETTINGS = FormationSettings.load()
SAFETY = SETTINGS.safety
RADIUS = SAFETY.radius_m
MOST = Twist2D(0.6, 1.2)
TRIANGLE = ((-0.87, 0.5), (-0.87, -0.5))


def chosen(wanted: Twist2D, echoes: tuple[Point, ...] = (), others: tuple[MovingDisc, ...] = ()) -> Twist2D:
    return admissible_twist(wanted, wanted, echoes, others, RADIUS, SAFETY, MOST)


def test_a_free_way_is_driven_as_wanted() -> None:
    wanted = Twist2D(0.4, 0.1)
    assert chosen(wanted, ((3.0, 0.0), (0.0, 1.0))) == wanted


@pytest.mark.parametrize("start", [0.6, 1.0, 2.0])
def test_a_robot_stands_before_a_wall(start: float) -> None:
    x, speed = 0.0, 0.0
    for _ in range(100):
        wall = tuple((start - x, side / 10) for side in range(-20, 21))
        wanted = Twist2D(min(0.5, speed + 0.03), 0.0)
        speed = max(0.0, chosen(wanted, wall).linear)
        x += 0.1 * speed
    assert start - x >= RADIUS + SAFETY.obstacle_gap_m - 0.01


def test_a_robot_drives_round_a_post() -> None:
    pose, post = Pose2D(), (1.2, 0.05)
    nearest = math.inf
    for _ in range(120):
        wanted = Twist2D(0.3, max(-1.0, min(1.0, 2 * pose.bearing_to(3.0, 0.0))))
        pose = integrate(pose, chosen(wanted, (pose.locate(*post),)), 0.1)
        nearest = min(nearest, math.dist((pose.x, pose.y), post))
    assert nearest > RADIUS
    assert pose.x > 1.6


def test_a_robot_waits_for_one_that_crosses() -> None:
    crossing = MovingDisc(Pose2D(0.9, -0.7, math.pi / 2), Twist2D(0.3, 0.0), RADIUS)
    twist = chosen(Twist2D(0.4, 0.0), (), (crossing,))
    assert twist != Twist2D(0.4, 0.0)


def test_a_robot_that_stands_lets_another_pass_beside_it() -> None:
    passing = MovingDisc(Pose2D(-1.0, 0.9, 0.0), Twist2D(0.3, 0.0), RADIUS)
    assert chosen(Twist2D(), (), (passing,)) == Twist2D()


def test_robots_that_are_too_near_come_apart_again() -> None:
    near = MovingDisc(Pose2D(0.0, 2 * RADIUS + 0.1, 0.0), Twist2D(), RADIUS)
    assert chosen(Twist2D(0.3, -0.3), (), (near,)).linear > 0.0


def straight_path() -> LeaderPath:
    path = LeaderPath(20.0)
    for number in range(40):
        path.add(Pose2D(number * 0.05, 0.0, 0.0))
    return path


@pytest.mark.parametrize(
    ("place", "is_narrow"),
    [
        ((3.0, 0.6), True),  # a jamb before the leader, in the lane of the left follower
        ((1.5, -0.5), True),  # between the leader and the right follower
        ((3.0, 1.2), False),  # beside all lanes
        ((3.0, 0.0), False),  # before the leader, which has to see it
        ((0.0, 0.5), False),  # behind all
        ((4.5, 0.5), False),  # far ahead
    ],
)
def test_an_obstacle_in_a_lane_makes_a_place_narrow(place: Point, is_narrow: bool) -> None:
    echoes = EchoMemory(SETTINGS.passages)
    for number in range(5):
        echoes.add(0.1 * number, [(place[0] + 0.01 * number, place[1])], [])
    assert echoes.blocks(straight_path(), TRIANGLE, RADIUS) is is_narrow
    assert not echoes.blocks(straight_path(), ((-0.9, 0.0), (-1.8, 0.0)), RADIUS)


def test_single_echoes_and_robots_make_no_place_narrow() -> None:
    echoes = EchoMemory(SETTINGS.passages)
    echoes.add(0.0, [(2.5, 0.5), (3.0, 0.5), (2.2, -0.6)], [])
    robot = (Pose2D(1.2, 0.5, 0.0), RADIUS)
    for number in range(5):
        echoes.add(0.1 * number, [(1.2, 0.3 + 0.01 * number)], [robot])
    assert not echoes.blocks(straight_path(), TRIANGLE, RADIUS)

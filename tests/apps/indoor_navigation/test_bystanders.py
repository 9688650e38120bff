"""What may be a leg, or has moved, is a body until it is seen to be something else."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.bodies import HIDDEN_TIME, LEG_RADIUS, Bodies, BodyTracker
from apps.indoor_navigation.algorithms.body_track import BODY_RADIUS, MAX_SPREAD
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perception
from apps.indoor_navigation.algorithms.walkers import ScanMotion
from apps.indoor_navigation.data import Floats, LaserRead, ObstRead
from apps.indoor_navigation.parameters import shipped_parameters
from geometry import Pose2D
from tests.apps.indoor_navigation.closed_loop import ClosedLoop, Walker, box
from tests.apps.indoor_navigation.planning.house import distances

LEG, TABLE_LEG, POST = 0.07, 0.025, 0.08  # m, radii
BODY = 0.25  # m, radius of the body that must not be touched

Round = tuple[float, float, float]  # x, y and radius of something round
Pose = tuple[float, float, float]
ORIGIN: Pose = (0.0, 0.0, 0.0)
ROBOT = Outline(0.21, 0.3, 0.42)


def person(x: float, y: float, heading: float = 0.0, stride: float = 0.1) -> list[Round]:
    """Two legs beside the middle, one of them ahead."""
    along, aside = (cos(heading), sin(heading)), (-sin(heading), cos(heading))
    return [
        (x + sign * (stride * along[0] + 0.08 * aside[0]), y + sign * (stride * along[1] + 0.08 * aside[1]), LEG)
        for sign in (1.0, -1.0)
    ]


def scan(things: Sequence[Round], stamp: float, pose: Pose = ORIGIN, wall: float = 4.0) -> LaserRead:
    """A scan of round things in front of a wall all round, m away."""
    angles = np.radians(np.linspace(-90.0, 90.0, 361))
    ux, uy = np.cos(angles + pose[2]), np.sin(angles + pose[2])
    ranges = np.full(361, wall)
    for x, y, radius in things:
        along = (x - pose[0]) * ux + (y - pose[1]) * uy
        half = radius**2 - ((x - pose[0]) ** 2 + (y - pose[1]) ** 2 - along**2)
        is_met = (half > 0.0) & (along > 0.0)
        ranges = np.where(is_met, np.minimum(ranges, along - np.sqrt(np.maximum(half, 0.0))), ranges)
    return LaserRead(stamp, pose, (0.0, 0.0, 0.0), -pi / 2.0, float(angles[1] - angles[0]), 8.0, ranges)


class Watch:
    """Scans, 0.1 s apart."""

    def __init__(self) -> None:
        self.time = 0.0
        self._tracker, self._motion = BodyTracker(), ScanMotion()

    def look(self, *things: Round, poses: Sequence[Pose] = (ORIGIN,) * 3, wall: float = 4.0) -> Bodies:
        """Return the bodies after a scan from each pose."""
        for pose in poses:
            self.time += 0.1
            self._take(scan(things, self.time, pose, wall))
        return self._tracker.bodies

    def look_at(self, lines: Floats, *things: Round, poses: Sequence[Pose]) -> Bodies:
        """Likewise where straight walls stand, too: x and y of both ends of each."""
        for pose in poses:
            self.time += 0.1
            seen = scan(things, self.time, pose, wall=8.0)
            angles = pose[2] + seen.angle_min + seen.angle_increment * np.arange(len(seen.ranges), dtype=np.float64)
            self._take(replace(seen, ranges=np.minimum(seen.ranges, distances(*pose[:2], angles, lines, 8.0))))
        return self._tracker.bodies

    def _take(self, seen: LaserRead) -> None:
        self._tracker.see(seen, self._motion.look(seen))


def around(x: float, y: float, radius: float, turn: float, steps: int = 30) -> list[Pose]:
    """Poses on an arc about a place, all facing it."""
    angles = [pi + turn * step / (steps - 1) for step in range(steps)]
    return [(x + radius * cos(angle), y + radius * sin(angle), angle - pi) for angle in angles]


def test_one_body_is_about_two_legs_with_arms() -> None:
    bodies = Watch().look(*person(1.5, 0.2, pi / 2.0))
    assert bodies.x == pytest.approx([1.5], abs=0.05)
    assert bodies.y == pytest.approx([0.2], abs=0.05)
    assert bodies.radius == pytest.approx([BODY_RADIUS])
    assert not bodies.have_moved[0]


@pytest.mark.parametrize("heading", [0.0, 0.2, -0.2])
def test_a_person_of_whom_one_leg_is_seen_is_within_the_disc(heading: float) -> None:
    bodies = Watch().look(*person(1.2, 0.0, heading, stride=0.16)[1:])
    assert len(bodies.x) == 1
    assert BODY_RADIUS <= bodies.radius[0] <= BODY_RADIUS + MAX_SPREAD
    apart = np.hypot(bodies.x - 1.2, bodies.y)
    assert apart + BODY < bodies.radius + 0.05


def test_outlines_of_bodies_are_as_far_from_the_middle_as_the_radius() -> None:
    bodies = Bodies(np.array([1.0, 3.0]), np.zeros(2), np.array([0.35, 0.4]), np.zeros(2, bool))
    x, y = bodies.outlines()
    assert np.hypot(x[:12] - 1.0, y[:12]) == pytest.approx(np.full(12, 0.35))
    assert np.hypot(x[12:] - 3.0, y[12:]) == pytest.approx(np.full(12, 0.4))


def test_nothing_stands_in_an_empty_room_and_one_scan_is_not_enough() -> None:
    assert len(Watch().look().x) == 0
    assert len(Watch().look(*person(1.5, 0.0), poses=[ORIGIN]).x) == 0


def test_the_leg_of_a_table_is_thinner_than_a_person_s() -> None:
    watch = Watch()
    approach = [(0.05 * step, 0.0, 0.0) for step in range(12)]
    assert len(watch.look((2.0, 0.1, TABLE_LEG), poses=approach).x) == 0


def test_four_legs_of_a_chair_are_no_two_people() -> None:
    legs = [(1.6 + x, 0.1 + y, 0.015) for x in (0.0, 0.38) for y in (0.0, 0.38)]
    approach = [(0.05 * step, 0.0, 0.0) for step in range(12)]
    assert len(Watch().look(*legs, poses=approach).x) == 0


def test_a_single_post_is_a_body_until_it_is_seen_from_another_side() -> None:
    watch = Watch()
    assert len(watch.look((1.2, 0.0, POST)).x) == 1
    assert len(watch.look((1.2, 0.0, POST), poses=around(1.2, 0.0, 1.2, radians(70.0))).x) == 0
    assert len(watch.look((1.2, 0.0, POST)).x) == 0, "it is remembered"


@pytest.mark.parametrize("radius", [0.11, 0.12])
def test_a_post_that_is_wider_than_a_leg_is_soon_seen_to_be_none(radius: float) -> None:
    assert len(Watch().look((1.2, 0.0, radius)).x) == 1
    assert len(Watch().look((1.2, 0.0, radius), poses=[ORIGIN] * AFTER_SOME_TIME).x) == 0


@pytest.mark.parametrize("radius", [0.05, 0.09])
def test_a_leg_stays_one_for_who_stands_before_it(radius: float) -> None:
    assert len(Watch().look((1.2, 0.0, radius), poses=[ORIGIN] * AFTER_SOME_TIME).x) == 1


def test_a_person_is_a_body_from_all_sides() -> None:
    watch = Watch()
    for pose in around(1.2, 0.0, 1.2, radians(120.0)):
        bodies = watch.look(*person(1.2, 0.0, 0.3), poses=[pose])
        if watch.time > 0.15:
            assert any(np.hypot(bodies.x - 1.2, bodies.y) + BODY < bodies.radius + 0.05), f"seen from {pose}"


def test_who_walked_and_stands_is_a_body_with_motion() -> None:
    watch = Watch()
    for step in range(11):
        bodies = watch.look(*person(1.5, -1.0 + 0.1 * step, pi / 2.0), poses=[ORIGIN])
    assert len(bodies.x)
    for _ in range(20):
        bodies = watch.look(*person(1.5, 0.0, pi / 2.0), poses=[ORIGIN])
    assert len(bodies.x) == 1
    assert bodies.have_moved[0]


def test_what_stands_where_somebody_passes_by_has_not_moved() -> None:
    watch = Watch()
    post = (1.5, 0.0, POST)
    watch.look(post, poses=[ORIGIN] * 10)
    for step in range(20):
        bodies = watch.look(post, *person(1.1, -1.0 + 0.1 * step, pi / 2.0), poses=[ORIGIN])
    beside = np.hypot(bodies.x - 1.5, bodies.y) < 0.3
    assert len(bodies.x) > beside.sum() > 0
    assert not bodies.have_moved[beside].any()


JAMB = np.array([(1.0, 0.6, 1.0, 3.0), (1.0, 0.6, 1.12, 0.6), (1.12, 0.6, 1.12, 3.0), (-4.0, 5.0, 6.0, 5.0)])
FACING_THE_WALL, FACING_ITS_END = (0.0, 1.5, 0.0), (1.06, -1.0, pi / 2.0)
AFTER_SOME_TIME = 40  # scans


def test_the_end_of_a_wall_that_stands_alone_in_the_scan_may_be_a_leg() -> None:
    assert len(Watch().look_at(JAMB, poses=[FACING_ITS_END] * AFTER_SOME_TIME).x) == 1


def test_the_end_of_a_wall_that_was_seen_before_is_soon_known_to_be_none() -> None:
    watch = Watch()
    watch.look_at(JAMB, poses=[FACING_THE_WALL] * 3)
    assert len(watch.look_at(JAMB, poses=[FACING_ITS_END] * AFTER_SOME_TIME).x) == 0


@pytest.mark.parametrize("y", [0.0, 0.2])
def test_who_stands_before_the_end_of_a_wall_that_was_seen_before_stays_a_body(y: float) -> None:
    watch = Watch()
    watch.look_at(JAMB, poses=[FACING_THE_WALL] * 3)
    bodies = watch.look_at(JAMB, *person(1.06, y), poses=[FACING_ITS_END] * AFTER_SOME_TIME)
    assert any(np.hypot(bodies.x - 1.06, bodies.y - y) < 0.1)


# As deep as a wall's end is wide, and 0.45 m long: from one side it looks as slender as a leg.
CABINET = np.array([(1.0, 0.6, 1.2, 0.6), (1.2, 0.6, 1.2, 1.05), (1.2, 1.05, 1.0, 1.05), (1.0, 1.05, 1.0, 0.6)])
FACING_ITS_FRONT, FACING_IT_FROM_ELSEWHERE = (0.0, 0.82, 0.0), (0.3, 0.1, pi / 4.0)
FACING_ITS_SIDE = (1.1, -1.0, pi / 2.0)


@pytest.mark.parametrize(
    ("seen_before", "bodies"),
    [([FACING_ITS_FRONT, FACING_IT_FROM_ELSEWHERE], 0), ([FACING_ITS_FRONT] * 2, 1)],
    ids=["from two places", "from one"],
)
def test_the_side_of_a_box_is_no_leg_where_its_front_was_seen(seen_before: list[Pose], bodies: int) -> None:
    watch = Watch()
    watch.look_at(CABINET, poses=seen_before)
    assert len(watch.look_at(CABINET, poses=[FACING_ITS_SIDE] * AFTER_SOME_TIME).x) == bodies


def test_who_is_not_seen_there_any_more_has_gone() -> None:
    watch = Watch()
    assert len(watch.look(*person(1.5, 0.0)).x) == 1
    assert len(watch.look(poses=[ORIGIN]).x) == 0


def test_who_is_beside_the_robot_and_out_of_view_is_believed_for_a_while() -> None:
    watch = Watch()
    assert len(watch.look(*person(0.8, 0.3)).x) == 1
    away: Pose = (0.0, 0.0, pi)
    assert len(watch.look(poses=[away]).x) == 1
    assert len(watch.look(poses=[away] * round(10.0 * HIDDEN_TIME)).x) == 0


def test_a_pose_that_was_set_anew_leaves_nobody() -> None:
    perception = Perception(shipped_parameters("obstacle_avoiding").senses)

    def bodies(stamp: float, x: float) -> int:
        perception.take(scan(person(x + 1.5, 0.0), stamp, (x, 0.0, 0.0)))
        perceived = perception.perceived(ROBOT)
        assert perceived is not None
        return len(perceived.bodies.x)

    assert [bodies(stamp, 0.0) for stamp in (0.0, 0.1)] == [0, 1]
    assert bodies(0.2, 3.0) == 0


def test_nobody_is_thought_to_stand_in_the_robot() -> None:
    jamb, far = (0.25, 0.4), (1.5, -0.4)
    x, y = np.array([jamb, far]).T
    bodies = Bodies(x, y, np.array([0.45, 0.35]), np.zeros(2, bool)).beside(ROBOT, ORIGIN)
    assert bodies.radius == pytest.approx([float(ROBOT.distance(*np.array([jamb]).T)[0]), 0.35])
    turned = bodies.beside(ROBOT, (0.1, 0.2, 0.0))
    assert turned.radius[0] == LEG_RADIUS, "what was hit stays in the way"


def test_bodies_travel_in_the_reading() -> None:
    empty: Floats = np.empty(0)
    body = np.array([1.5]), np.array([0.2]), np.array([0.35]), np.array([1.0])
    read = ObstRead(0.0, ORIGIN, None, 0.0, empty, empty, empty, empty, empty, False, *body)
    again = ObstRead.from_json(read.to_json())
    assert [again.body_x, again.body_y, again.body_radius, again.body_moved] == list(body)


@pytest.mark.parametrize("aside", [0.45, 0.55, -0.5])
@pytest.mark.parametrize("walked", [0.0, 0.16, 0.3])
def test_a_robot_touches_nobody_who_stands_beside_its_way(aside: float, walked: float) -> None:
    standing = Walker((2.5, aside), (0.0, 1e-9), walked=walked)
    loop = ClosedLoop("p3dx", [], Pose2D(), walkers=[standing])
    trace = loop.go(5.0, 0.0)
    assert trace.reached_at is not None
    assert not trace.touched
    assert trace.clearance > 0.05


def test_posts_of_a_wide_gap_hold_no_robot_up() -> None:
    posts = [*box(2.5, 0.55, 0.1, 0.1), *box(2.5, -0.55, 0.1, 0.1)]
    trace = ClosedLoop("p3dx", posts).go(5.0, 0.0)
    assert trace.reached_at is not None
    assert not trace.touched

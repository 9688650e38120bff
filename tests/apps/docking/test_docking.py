"""The pose of a dock by its station in a scan, and what a robot does to stand on it, on exact readings."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.docking.cycle import DockingCycle, DockingHull, DockingOrders, DockingState
from apps.docking.settings import DockingSettings
from apps.docking.station import Floats, find_dock, to_frame
from apps.echoes import echo_points
from geometry import Pose2D, Twist2D, integrate, wrap_angle

SETTINGS = DockingSettings.load()
HULL = DockingHull(front=0.37, width=0.68)
MOUNT = Pose2D(0.1, 0.0, 0.0)
STEP = math.radians(1.0)
DOCK = Pose2D(3.0, 1.0, 0.0)
WALL, HALF, DEPTH = 3.65, 0.2, 0.2  # m in odom: the wall behind the station; half its width, and its depth
STATION = ((WALL - DEPTH, DOCK.y - HALF), (WALL - DEPTH, DOCK.y + HALF), (WALL, DOCK.y + HALF), (WALL, DOCK.y - HALF))


def segments(*, station: bool = True, box: tuple[float, float] | None = None) -> list[tuple[float, ...]]:
    """The wall, the faces of the station and of a small box, as x1, y1, x2, y2 in odom."""
    lines: list[tuple[float, ...]] = [(WALL, -5.0, WALL, 5.0)]
    if station:
        lines += [(*STATION[a], *STATION[b]) for a, b in ((0, 1), (1, 2), (3, 0))]
    if box is not None:
        x, y = box
        lines += [(x - 0.1, y - 0.1, x - 0.1, y + 0.1), (x - 0.1, y - 0.1, x + 0.1, y - 0.1)]
    return lines


def scan(pose: Pose2D, lines: list[tuple[float, ...]]) -> Floats:
    """Echoes of a laser at a pose of the robot, in its frame."""
    laser = pose.compose(MOUNT)
    angles = -math.pi / 2 + STEP * np.arange(181)
    ways = np.column_stack((np.cos(laser.heading + angles), np.sin(laser.heading + angles)))
    ranges = np.full(181, np.inf)
    for x1, y1, x2, y2 in lines:
        along = np.array((x2 - x1, y2 - y1))
        start = np.array((x1 - laser.x, y1 - laser.y))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # parallel to a beam
            cross = ways[:, 0] * along[1] - ways[:, 1] * along[0]
            away = (start[0] * along[1] - start[1] * along[0]) / cross
            share = (start[0] * ways[:, 1] - start[1] * ways[:, 0]) / cross
        hit = (away > 0.0) & (share >= 0.0) & (share <= 1.0)
        ranges = np.where(hit & (away < ranges), away, ranges)
    return echo_points(ranges, -math.pi / 2, STEP, MOUNT)


class Drive:
    """A robot that moves exactly as it is told, 0.1 s a step."""

    def __init__(self, start: Pose2D, cycle: DockingCycle, lines: list[tuple[float, ...]]) -> None:
        self.pose, self.cycle, self.lines = start, cycle, lines
        self.now, self.charging, self.contact = 0.0, False, False
        self.is_powered = True  # the dock
        self.lowered_at, self.speed = math.inf, 0.0
        self.told: list[DockingOrders] = []

    def step(self) -> DockingOrders:
        self.now += 0.1
        self.cycle.take_scan(self.now, scan(self.pose, self.lines), self.pose)
        self.charging = self.is_powered and self.now - self.lowered_at > 5.0
        orders = self.cycle.step(self.now, self.pose, charging=self.charging, contact=self.contact)
        if orders.contacts is not None:
            self.lowered_at = self.now if orders.contacts else math.inf
        self.speed = 0.0 if orders.twist is None else orders.twist.linear
        if orders.twist is not None:
            self.pose = integrate(self.pose, orders.twist, 0.1)
        if orders.changed:
            self.told.append(orders)
        return orders

    def until(self, condition: Callable[[], bool], limit: float = 200.0) -> None:
        while not condition():
            assert self.now < limit, [f"{each.state}: {each.reason}" for each in self.told]
            self.step()


START = Pose2D(0.5, 0.2, 0.4)


def drive(start: Pose2D = START, expected: Pose2D = DOCK, **given: bool) -> Drive:
    return Drive(start, DockingCycle(SETTINGS, expected, HULL, **given), segments())


@settings(max_examples=25)
@given(
    away=st.floats(0.5, 1.8),
    aside=st.floats(-0.4, 0.4),
    turned=st.floats(-0.4, 0.4),
    wrong=st.tuples(st.floats(-0.15, 0.15), st.floats(-0.15, 0.15), st.floats(-0.15, 0.15)),
)
def test_a_dock_is_found_by_its_station_from_anywhere_before_it(
    away: float, aside: float, turned: float, wrong: tuple[float, float, float]
) -> None:
    robot = DOCK.compose(Pose2D(-away, aside, turned))
    found = find_dock(scan(robot, segments()), DOCK.compose(Pose2D(*wrong)).relative_to(robot), SETTINGS.station)
    assert found is not None
    there = robot.compose(found)
    # From afar the face of the station has few echoes; the robot looks again when it is nearer.
    assert math.hypot(there.x - DOCK.x, there.y - DOCK.y) < (0.03 if away < 1.2 else 0.04)
    assert abs(wrap_angle(there.heading - DOCK.heading)) < (0.03 if away < 1.2 else 0.08)


@pytest.mark.parametrize("lines", [segments(station=False), segments(station=False, box=(3.4, 1.0)), []])
def test_a_wall_or_a_box_of_another_width_is_no_station(lines: list[tuple[float, ...]]) -> None:
    robot = DOCK.compose(Pose2D(-1.0, 0.0, 0.0))
    assert find_dock(scan(robot, lines), DOCK.relative_to(robot), SETTINGS.station) is None


def test_points_in_the_frame_of_a_pose_are_those_that_the_pose_locates() -> None:
    frame = Pose2D(1.0, -2.0, 0.7)
    points = np.array(((3.0, 4.0), (-1.0, 0.5)))
    assert to_frame(points, frame) == pytest.approx(np.array([frame.locate(*point) for point in points]))


def test_a_robot_whose_dock_is_expected_elsewhere_stands_on_it_in_the_end_and_lowers_its_contacts_there() -> None:
    robot = drive(expected=DOCK.compose(Pose2D(0.1, -0.14, 0.08)))
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED
    off = robot.pose.relative_to(DOCK)
    assert max(abs(off.x), abs(off.y)) < 0.03
    assert [each.state for each in robot.told][-3:] == [
        DockingState.APPROACH,
        DockingState.CHARGE,
        DockingState.CHARGED,
    ]


def test_while_its_contacts_are_down_the_motors_are_left_alone() -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is DockingState.CHARGE)
    assert all(robot.step().twist is None for _ in range(20))


def test_a_dock_without_power_is_left_and_tried_again_and_then_given_up() -> None:
    robot = drive()
    robot.is_powered = False
    robot.until(lambda: robot.cycle.has_ended, limit=400.0)
    assert robot.cycle.state is DockingState.GIVEN_UP
    assert robot.cycle.reason == "3 attempts have failed; the contacts have found no power"
    assert robot.lowered_at == math.inf
    assert [each.state for each in robot.told].count(DockingState.CHARGE) == 3


def test_no_station_is_said_to_be_seen_where_there_is_none() -> None:
    robot = drive()
    robot.lines = segments(station=False)
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.reason == "3 attempts have failed; no station is seen where the dock should be"


def test_without_a_station_the_pose_of_the_dock_counts_as_it_is() -> None:
    robot = drive(needs_station=False)
    robot.lines = segments(station=False)
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED


@pytest.mark.parametrize("state", [DockingState.GO, DockingState.APPROACH])
def test_a_robot_waits_for_what_is_in_its_way_and_goes_on_when_it_is_gone(state: DockingState) -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is state and robot.speed > 0.0)
    x, y = robot.pose.transform(HULL.front + 0.25, 0.1)
    robot.lines = segments(box=(x, y))
    for _ in range(5):
        orders = robot.step()
    assert orders.twist == Twist2D()
    assert orders.reason == "something is in the way"
    robot.lines = segments()
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED


def test_what_stays_in_the_way_ends_the_attempt_with_the_reason() -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is DockingState.APPROACH)
    robot.lines = segments(box=robot.pose.transform(HULL.front + 0.25, 0.1))
    robot.until(lambda: robot.cycle.has_ended)
    assert (robot.cycle.state, robot.cycle.reason) == (DockingState.GIVEN_UP, "something is in the way")


def test_a_silent_laser_stops_the_robot() -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is DockingState.APPROACH)
    later = robot.now + SETTINGS.silent_s + 0.1
    orders = robot.cycle.step(later, robot.pose, charging=False)
    assert (orders.twist, orders.reason) == (Twist2D(), "the laser is silent")


def test_a_contact_on_the_way_onto_the_dock_is_a_lost_attempt() -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is DockingState.APPROACH)
    robot.contact = True
    assert robot.step().state is DockingState.BACK
    robot.contact = False
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED


def test_a_robot_backs_off_although_it_still_touches_what_it_leaves() -> None:
    robot = drive()
    robot.until(lambda: robot.cycle.state is DockingState.APPROACH)
    robot.until(lambda: DOCK.locate(robot.pose.x, robot.pose.y)[0] > -0.2)
    robot.contact = True
    robot.step()
    touched = robot.pose
    for _ in range(10):
        robot.step()
    assert robot.told[-1].state is DockingState.BACK
    assert touched.locate(robot.pose.x, robot.pose.y)[0] < -0.05
    robot.contact = False
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED


def test_a_robot_that_something_holds_on_its_way_gives_up_in_the_end() -> None:
    robot = drive()
    robot.contact = True
    robot.until(lambda: robot.cycle.has_ended, limit=60.0)
    assert robot.cycle.state is DockingState.GIVEN_UP
    assert robot.cycle.reason == "3 attempts have failed; the robot has touched something"


def test_a_robot_that_brushes_something_on_its_way_drives_on() -> None:
    robot = drive()
    for _ in range(5):
        robot.contact = True
        robot.step()
        robot.contact = False
        for _ in range(30):
            robot.step()
    assert robot.cycle.state is not DockingState.BACK
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.CHARGED


def test_a_robot_that_is_charged_already_stays_where_it_is() -> None:
    cycle = DockingCycle(SETTINGS, DOCK, HULL)
    assert cycle.step(0.0, DOCK, charging=True).state is DockingState.CHARGED


def test_leaving_raises_the_contacts_first_and_ends_before_the_dock() -> None:
    robot = drive(start=DOCK, leaves=True)
    assert robot.step().contacts is False
    robot.until(lambda: robot.cycle.has_ended)
    assert robot.cycle.state is DockingState.LEFT
    assert DOCK.locate(robot.pose.x, robot.pose.y)[0] == pytest.approx(-SETTINGS.charge.leave_m, abs=0.02)


def test_a_contact_behind_ends_the_leaving_with_the_reason() -> None:
    robot = drive(start=DOCK, leaves=True)
    robot.step()
    robot.contact = True
    robot.step()
    assert (robot.cycle.state, robot.cycle.reason) == (DockingState.GIVEN_UP, "something is behind the robot")

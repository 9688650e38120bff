"""Where the robot was, what its discs have seen from there, and which beams say nothing."""

from math import inf, isnan, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.pose_history import PoseHistory, is_jump
from apps.indoor_navigation.algorithms.sonar_memory import SonarMemory
from apps.indoor_navigation.components.inbox import LastSecond
from apps.indoor_navigation.components.laser_server import filled
from apps.indoor_navigation.data import RobotOdometry
from geometry import Pose2D, Twist2D, integrate

EPOCH = 1.8e9
speeds = st.floats(-0.8, 0.8)


def along(linear: float, angular: float, times: list[float], jumps: int = 0) -> list[RobotOdometry]:
    """Of a robot that goes on evenly."""
    poses = [integrate(Pose2D(), Twist2D(linear, angular), time) for time in times]
    return [
        RobotOdometry(EPOCH + time, pose.x, pose.y, pose.heading, linear, angular, jumps)
        for time, pose in zip(times, poses, strict=True)
    ]


@given(speeds, speeds, st.floats(0.0, 1.4))
def test_a_robot_that_goes_on_evenly_is_known_at_any_moment(linear: float, angular: float, time: float) -> None:
    history = PoseHistory()
    for odometry in along(linear, angular, [0.1 * step for step in range(11)]):
        history.add(odometry)
    truth, told = integrate(Pose2D(), Twist2D(linear, angular), time), history.at(EPOCH + time)
    assert told is not None
    assert (told.x, told.y, told.heading) == pytest.approx((truth.x, truth.y, truth.heading), abs=2e-3)


def test_a_turn_over_the_back_is_no_turn_around() -> None:
    history = PoseHistory()
    history.add(RobotOdometry(EPOCH, 0.0, 0.0, pi - 0.1, 0.0, 2.0))
    history.add(RobotOdometry(EPOCH + 0.1, 0.0, 0.0, -pi + 0.1, 0.0, 2.0))
    told = history.at(EPOCH + 0.05)
    assert told is not None
    assert abs(told.heading) == pytest.approx(pi, abs=1e-6)


def test_long_after_the_last_odometry_nobody_knows_where_the_robot_is() -> None:
    history = PoseHistory()
    history.add(RobotOdometry(EPOCH, 0.0, 0.0, 0.0, 1.0, 0.0))
    told = history.at(EPOCH + 0.5)
    assert told is not None
    assert told.x == 0.5
    assert history.at(EPOCH + 0.6) is None


def test_before_any_odometry_nobody_knows() -> None:
    assert PoseHistory().at(EPOCH) is None


@pytest.mark.parametrize("after", [{"jumps": 1, "time": 1.0}, {"jumps": 0, "time": -3600.0}])
def test_after_a_jump_and_a_set_clock_what_was_before_says_nothing(after: dict[str, float]) -> None:
    history = PoseHistory()
    for odometry in along(0.5, 0.0, [0.0, 0.1, 0.2]):
        history.add(odometry)
    history.add(RobotOdometry(EPOCH + after["time"], 9.0, 9.0, 0.0, 0.0, 0.0, int(after["jumps"])))
    told = history.at(EPOCH - 7200.0)
    assert told == Pose2D(9.0, 9.0, 0.0)


@given(speeds, st.floats(-2.0, 2.0), st.floats(0.0, 3.0))
def test_driving_is_no_jump(linear: float, angular: float, elapsed: float) -> None:
    before, after = along(linear, angular, [0.0, elapsed])
    if abs(angular) * elapsed < pi and elapsed <= 2.0:
        assert not is_jump(before, after)


@given(speeds, st.floats(0.5, 50.0), st.floats(-pi, pi))
def test_a_place_that_no_robot_reaches_in_a_tenth_of_a_second_is_a_jump(
    linear: float, far: float, heading: float
) -> None:
    before = RobotOdometry(EPOCH, 0.0, 0.0, 0.0, linear, 0.0)
    assert is_jump(before, RobotOdometry(EPOCH + 0.1, far, 0.0, heading, linear, 0.0))


@given(speeds, st.floats(-1.0, 1.0), st.floats(0.3, 4.0))
def test_an_echo_stays_where_it_was_heard_while_the_robot_goes_on(linear: float, angular: float, far: float) -> None:
    memory, disc = SonarMemory(1.0), Pose2D(0.15, 0.1, 0.5)
    memory.hear(EPOCH, {4: far}, {4: disc}, Pose2D())
    echo = disc.transform(far, 0.0)
    robot = integrate(Pose2D(), Twist2D(linear, angular), 0.5)
    reading = memory.read(EPOCH + 0.5, robot)
    assert reading is not None
    seen = Pose2D(reading.places_x[0], reading.places_y[0], reading.headings[0]).transform(reading.ranges[0], 0.0)
    assert robot.transform(*seen) == pytest.approx(echo, abs=1e-9)


def test_what_was_forgotten_is_not_read() -> None:
    memory = SonarMemory(1.0)
    memory.hear(EPOCH, {4: 1.0}, {4: Pose2D()}, Pose2D())
    memory.forget()
    assert memory.read(EPOCH, Pose2D()) is None


@given(st.lists(st.sampled_from([nan, inf]) | st.floats(0.05, 8.0), max_size=40))
def test_no_beam_without_a_measurement_is_longer_than_the_measured_ones_beside_it(given_ranges: list[float]) -> None:
    ranges = filled(np.array(given_ranges))
    if all(map(isnan, given_ranges)):
        assert ranges is None
        return
    assert ranges is not None
    for place, (before, after) in enumerate(zip(given_ranges, ranges, strict=True)):
        if not isnan(before):
            assert after == before
            continue
        left = next((each for each in reversed(given_ranges[:place]) if not isnan(each)), inf)
        right = next((each for each in given_ranges[place:] if not isnan(each)), inf)
        assert after == min(left, right)


def test_the_last_second_is_counted() -> None:
    second = LastSecond()
    for tick in range(50):
        second.add(0.1 * tick, 2.0)
    assert second.total(4.9) == 20.0
    assert second.total(10.0) == 0.0

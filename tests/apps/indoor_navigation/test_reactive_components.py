"""Goto, orienting, avoidance and detection on the bus: what they hear, what they push, and when they are silent."""

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np
import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.component import query_key, send_key
from apps.indoor_navigation.components.goto import Goto
from apps.indoor_navigation.components.obstacle_avoiding import ObstacleAvoiding
from apps.indoor_navigation.components.obstacle_detecting import ObstacleDetecting
from apps.indoor_navigation.components.orienting import Orienting
from apps.indoor_navigation.data import LaserRead, MotionCmd, ObstRead, RobotOdometry, WorldCoord
from tests.apps.indoor_navigation.site import ROBOT, Site

BASE, LASER = "robot_base_server", "laser_server"
ASKS = {"robot": BASE}
BODY = {
    "name": ROBOT,
    "model": "p2dx",
    "front": 0.21,
    "rear": 0.3,
    "width": 0.42,
    "radius": 0.25,
}


@pytest.fixture
def deceleration() -> float:
    """Of the robot, m/s²."""
    return 0.3


@pytest.fixture
def site(deceleration: float) -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    body = {**BODY, "limits": {"deceleration": deceleration}}
    site.bus.serve(query_key(ROBOT, BASE, "robot"), lambda arguments: body)
    yield site
    site.close()
    loop.close()


def hears(*connections: tuple[str, str], **more: Any) -> dict[str, Any]:
    return {"hears": [list(each) for each in connections], "asks": ASKS, **more}


def goto(site: Site) -> None:
    site.start(Goto(f"goto@{ROBOT}", hears((BASE, "Odometry"), ("obstacle_detecting", "ObstRead"))))
    site.run(0.1)


def avoiding(site: Site, **parameters: Any) -> None:
    wires = hears((BASE, "Odometry"), (BASE, "SonarRead"), (LASER, "LaserRead"), numbers=parameters)
    site.start(ObstacleAvoiding(f"obstacle_avoiding@{ROBOT}", wires))
    site.run(0.1)


def order(site: Site, receiver: str, aim: str, number: int = 1, x: float = 0.0, heading: float = 0.0) -> None:
    target = WorldCoord(site.time, number, aim, x, 0.0, heading, 0.5)
    site.bus.send(send_key(ROBOT, receiver, WorldCoord), target.to_json())
    site.run(0.01)


def stand(site: Site, x: float = 0.0, heading: float = 0.0, jumps: int = 0) -> None:
    site.push(BASE, RobotOdometry(site.time, x, 0.0, heading, 0.0, 0.0, jumps))
    site.run(0.05)


def see(site: Site, distance: float, x: float = 0.0) -> None:
    """A wall all about."""
    noise = 0.01 * np.sin(np.arange(361) + site.time)
    pose = x, 0.0, 0.0
    site.push(LASER, LaserRead(site.time, pose, (0.0, 0.0, 0.0), -pi / 2.0, pi / 360.0, 8.0, distance + noise))
    site.run(0.01)


def nothing_in_the_way(site: Site) -> None:
    empty = np.empty(0)
    read = ObstRead(site.time, (0.0, 0.0, 0.0), None, 0.0, empty, empty, empty, empty, empty, False)
    site.push("obstacle_detecting", read)
    site.run(0.05)


def test_goto_wants_to_its_target_and_to_stand_when_told_to_rest(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "go", x=3.0)
    for _ in range(5):
        nothing_in_the_way(site)
        stand(site)
    assert wanted[-1].weight == 1.0
    assert wanted[-1].linear > 0.0
    order(site, "goto", "rest", 2)
    stand(site)
    assert (wanted[-1].weight, wanted[-1].linear) == (1.0, 0.0)


def test_goto_does_not_drive_onto_a_line_that_no_sensor_shows(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    for number, away in ((1, 2.0), (2, 0.27)):
        line = np.stack((np.full(61, away), np.linspace(-1.5, 1.5, 61)), axis=1)
        target = WorldCoord(site.time, number, "go", 3.0, 0.0, 0.0, 0.5, barred=tuple(line.ravel().tolist()))
        site.bus.send(send_key(ROBOT, "goto", WorldCoord), target.to_json())
        for _ in range(5):
            nothing_in_the_way(site)
            stand(site)
        assert (wanted[-1].linear > 0.1) == (away > 1.0)


def test_avoiding_does_not_let_the_robot_onto_a_line_that_no_sensor_shows(site: Site) -> None:
    avoiding(site)
    pushed = site.pushed("obstacle_avoiding", MotionCmd)
    line = np.stack((np.full(61, 0.27), np.linspace(-1.5, 1.5, 61)), axis=1)
    # An older order changes nothing; a newer one without forbidden places frees the way.
    for number, barred, is_free in ((2, line, False), (1, line[:0], False), (3, line[:0], True)):
        target = WorldCoord(site.time, number, "go", 3.0, 0.0, 0.0, 0.5, barred=tuple(barred.ravel().tolist()))
        site.bus.send(send_key(ROBOT, "obstacle_avoiding", WorldCoord), target.to_json())
        stand(site)
        see(site, 5.0)
        limit = pushed[-1].limit
        assert (limit is None or limit > 0.3) == is_free, number


def test_avoiding_forgets_forbidden_places_when_odom_is_set_anew(site: Site) -> None:
    avoiding(site)
    pushed = site.pushed("obstacle_avoiding", MotionCmd)
    stand(site)
    line = np.stack((np.full(61, 0.27), np.linspace(-1.5, 1.5, 61)), axis=1)
    target = WorldCoord(site.time, 1, "go", 3.0, 0.0, 0.0, 0.5, barred=tuple(line.ravel().tolist()))
    site.bus.send(send_key(ROBOT, "obstacle_avoiding", WorldCoord), target.to_json())
    limits = []
    for jumps in (0, 1):
        stand(site, jumps=jumps)
        see(site, 5.0)
        limits.append(pushed[-1].limit)
    before, after = limits
    assert before is not None
    assert before < 0.1
    assert after is None or after > 0.3


def test_avoiding_creeps_to_where_an_ordered_turn_is_free_and_stands_once_the_orders_cease(site: Site) -> None:
    avoiding(site)
    pushed = site.pushed("obstacle_avoiding", MotionCmd)
    beside_the_tail = -0.25, -0.24
    target = WorldCoord(site.time, 1, "turn", heading=1.5, barred=beside_the_tail)
    site.bus.send(send_key(ROBOT, "obstacle_avoiding", WorldCoord), target.to_json())
    stand(site)
    see(site, 5.0)
    assert pushed[-1].left is not None
    assert pushed[-1].left < 0.1
    assert pushed[-1].linear > 0.0
    for _ in range(20):
        stand(site)
        see(site, 5.0)
    assert pushed[-1].left is not None
    assert pushed[-1].left < 0.1
    assert pushed[-1].linear == 0.0


def test_goto_does_not_obey_an_order_that_was_overtaken(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "rest", 7)
    order(site, "goto", "go", 6, x=3.0)
    for _ in range(5):
        nothing_in_the_way(site)
        stand(site)
    assert wanted[-1].linear == 0.0


def test_goto_stands_when_nobody_tells_what_is_in_the_way(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "go", x=3.0)
    nothing_in_the_way(site)
    for _ in range(30):
        stand(site)
    assert (wanted[-1].weight, wanted[-1].linear) == (1.0, 0.0)


def test_goto_stands_after_a_jump_until_obstacles_are_seen_anew(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "go", x=3.0)
    for _ in range(5):
        nothing_in_the_way(site)
        stand(site)
    assert wanted[-1].linear > 0.0
    stand(site, jumps=1)
    assert wanted[-1].linear == 0.0


def test_goto_backs_to_what_is_behind_it_without_turning(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "back", x=-2.0)
    for _ in range(5):
        nothing_in_the_way(site)
        stand(site)
    assert wanted[-1].linear < 0.0
    assert wanted[-1].angular == pytest.approx(0.0, abs=1e-3)


def test_goto_wants_nothing_while_the_robot_turns(site: Site) -> None:
    goto(site)
    wanted = site.pushed("goto", MotionCmd)
    order(site, "goto", "turn", heading=1.0)
    nothing_in_the_way(site)
    stand(site)
    assert wanted[-1].weight == 0.0


def test_orienting_wants_to_turn_only_when_told_to(site: Site) -> None:
    site.start(Orienting(f"orienting@{ROBOT}", hears((BASE, "Odometry"))))
    wanted = site.pushed("orienting", MotionCmd)
    order(site, "orienting", "turn", heading=1.0)
    stand(site)
    assert wanted[-1].angular > 0.0
    order(site, "orienting", "go", 2, x=1.0)
    stand(site)
    assert (wanted[-1].weight, wanted[-1].angular) == (0.0, 0.0)


def test_avoidance_answers_a_reading_at_once_and_with_its_stamp(site: Site) -> None:
    avoiding(site)
    stand(site)
    wanted = site.pushed("obstacle_avoiding", MotionCmd)
    stamp = site.time
    see(site, 0.26)
    assert [each.stamp for each in wanted] == [pytest.approx(stamp)]
    assert wanted[-1].limit is not None
    assert wanted[-1].limit < 0.05


@pytest.mark.parametrize(("deceleration", "used"), [(0.1, 0.088), (0.3, 0.264), (0.6, 0.5), (3.0, 0.5)])
def test_avoidance_counts_on_no_more_braking_than_the_robot_has_and_its_numbers_allow(site: Site, used: float) -> None:
    avoiding(site, avoidance={"deceleration": 0.5, "reaction": 0.35})
    wanted = site.pushed("obstacle_avoiding", MotionCmd)
    for _ in range(5):
        stand(site)
        see(site, 0.7)
    way = 0.36  # of the 0.7 m to the wall, without the robot's front, its margin, and what a step of its search leaves
    assert wanted[-1].limit == pytest.approx(safe_speed(way, used, 0.35), abs=0.005)


def test_avoidance_is_silent_without_sensors_so_that_the_fuser_holds_the_robot(site: Site) -> None:
    avoiding(site)
    wanted = site.pushed("obstacle_avoiding", MotionCmd)
    for _ in range(10):
        stand(site)
    assert not wanted


def test_detection_says_what_is_near_and_a_dead_end_only_when_it_lasts(site: Site) -> None:
    site.start(ObstacleDetecting(f"obstacle_detecting@{ROBOT}", hears((BASE, "SonarRead"), (LASER, "LaserRead"))))
    site.run(0.1)
    reads = site.pushed("obstacle_detecting", ObstRead)
    for _ in range(4):
        see(site, 0.9)
    assert [each.is_dead_end for each in reads] == [False, False, True, True]
    assert reads[-1].nearest == pytest.approx(0.6, abs=0.1)
    assert len(reads[-1].end_x) <= 121


def test_detection_says_once_that_the_laser_is_stuck(site: Site) -> None:
    site.start(ObstacleDetecting(f"obstacle_detecting@{ROBOT}", hears((BASE, "SonarRead"), (LASER, "LaserRead"))))
    site.run(0.1)
    ranges = np.linspace(1.0, 3.0, 361)
    for step in range(10):
        pose = 0.1 * step, 0.0, 0.0
        site.push(LASER, LaserRead(site.time, pose, (0.0, 0.0, 0.0), -pi / 2.0, pi / 360.0, 8.0, ranges))
        site.run(0.1)
    assert len(site.reports) == 1
    assert "the laser repeats the same ranges while the robot moves" in site.reports[0]

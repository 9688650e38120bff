"""Robots of the team that come nearer, and how avoiding slows the robot before them."""

from collections.abc import Iterator
from math import cos, hypot, inf, pi, sin
from typing import Any

import numpy as np
import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.algorithms.avoidance import AvoidanceParameters, avoid
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.teammates import CLOSING, Teammates
from apps.indoor_navigation.component import query_key
from apps.indoor_navigation.components.obstacle_avoiding import ObstacleAvoiding
from apps.indoor_navigation.data import LaserRead, MotionCmd, Pose, RobotOdometry
from apps.indoor_navigation.parameters import shipped_parameters
from bus import keys
from bus.messages import NS_PER_S, header, quaternion
from bus.messages import Point as PointMessage
from bus.messages import Pose as PoseMessage
from bus.ros_msgs import PoseWithCovariance, PoseWithCovarianceStamped
from tests.apps.indoor_navigation.site import ROBOT, Site

OTHER, THIRD = "grumpy", "doc"
BASE, LASER = "robot_base_server", "laser_server"
OUTLINE = Outline(0.21, 0.3, 0.42)
NOTHING = np.empty(0), np.empty(0)


def drive(team: Teammates, robot: str, start: Pose, speed: float, until: float) -> None:
    """Share the poses of a robot that drives straight on."""
    x, y, heading = start
    for now in np.arange(0.0, until + 1e-9, 0.1).tolist():
        team.see(robot, (x + speed * now * cos(heading), y + speed * now * sin(heading), heading), now)


def test_a_robot_comes_nearer_by_the_part_of_its_speed_that_points_here() -> None:
    team = Teammates(ROBOT)
    drive(team, ROBOT, (1.0, 1.0, pi / 2.0), 0.0, 1.0)
    drive(team, OTHER, (1.0, 3.0, -pi / 2.0), 0.4, 1.0)
    drive(team, THIRD, (0.0, 1.0, pi / 4.0), 0.4, 1.0)
    x, y, speeds, _ = team.closing(1.0)
    assert x == pytest.approx([1.6, 0.4 * sin(pi / 4.0)], abs=1e-6)
    assert y == pytest.approx([0.0, 1.0 - 0.4 * cos(pi / 4.0)], abs=1e-6)
    third = 1.0 - 0.4 * cos(pi / 4.0), -0.4 * sin(pi / 4.0)
    assert speeds == pytest.approx([0.4, 0.4 * (third[0] + third[1]) / 2**0.5 / hypot(*third)], abs=1e-6)


@pytest.mark.parametrize(
    ("start", "speed"), [((1.0, 3.0, pi / 2.0), 0.4), ((1.0, 2.0, 0.0), 0.0), ((1.0, 9.0, -pi / 2.0), 0.4)]
)
def test_robots_that_drive_away_or_stand_or_are_far_do_not_come_nearer(start: Pose, speed: float) -> None:
    team = Teammates(ROBOT)
    drive(team, ROBOT, (1.0, 1.0, 0.0), 0.0, 1.0)
    drive(team, OTHER, start, speed, 1.0)
    assert not len(team.closing(1.0)[0])


@pytest.mark.parametrize("silent", [ROBOT, OTHER])
def test_a_robot_that_shares_its_pose_no_longer_is_not_counted_on(silent: str) -> None:
    team = Teammates(ROBOT)
    for robot, start, speed in ((ROBOT, (1.0, 1.0, 0.0), 0.0), (OTHER, (3.0, 1.0, pi), 0.4)):
        drive(team, robot, start, speed, 1.0 if robot == silent else 2.0)
    assert len(team.closing(1.2)[0]) == 1
    assert not len(team.closing(2.0)[0])


def test_two_robots_that_drive_at_each_other_are_slow_before_they_are_near() -> None:
    """Both drive at 0.5 m/s, at right angles or head-on. What is as slow as `CLOSING` the sensors avoid."""
    slow = 1.5 * CLOSING  # since only a part of a speed across points at the other one
    numbers: AvoidanceParameters = shipped_parameters("obstacle_avoiding").avoidance
    for crossing in (pi, 0.6 * pi, pi / 2.0):
        start = 1.2 * cos(crossing), -1.2 * sin(crossing)
        robots: dict[str, tuple[float, float, float]] = {
            ROBOT: (-1.2, 0.0, 0.0),
            OTHER: (-start[0], start[1], crossing),
        }
        speeds = dict.fromkeys(robots, 0.5)
        teams = {name: Teammates(name) for name in robots}
        for step in range(80):
            now = 0.1 * step
            for name in robots:
                for other, pose in robots.items():
                    teams[name].see(other, pose, now)
            for name, (x, y, heading) in list(robots.items()):
                push = avoid(numbers, OUTLINE, NOTHING, NOTHING, speeds[name], 0.0, teammates=teams[name].closing(now))
                wanted = min(0.5, push.limit if push.limit is not None else inf)
                speeds[name] = min(speeds[name], max(wanted, speeds[name] - 0.07))  # it brakes at 0.7 m/s²
                gone = 0.1 * speeds[name]
                robots[name] = x + gone * cos(heading), y + gone * sin(heading), heading
            if max(speeds.values()) < slow:
                break
        a, b = robots.values()
        assert max(speeds.values()) < slow, crossing
        assert hypot(a[0] - b[0], a[1] - b[1]) > 0.6, crossing


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    body = {"name": ROBOT, "model": "p3dx-sh", "front": 0.21, "rear": 0.3, "width": 0.42, "radius": 0.25}
    site.bus.serve(query_key(ROBOT, BASE, "robot"), lambda arguments: {**body, "limits": {"deceleration": 0.7}})
    wires = {
        "hears": [[BASE, "Odometry"], [BASE, "SonarRead"], [LASER, "LaserRead"]],
        "asks": {"robot": BASE},
    }
    site.start(ObstacleAvoiding(f"obstacle_avoiding@{ROBOT}", wires))
    site.run(0.1)
    yield site
    site.close()
    loop.close()


def share(site: Site, robot: str, x: float, heading: float) -> None:
    pose = PoseMessage(position=PointMessage(x=x, y=0.0, z=0.0), orientation=quaternion(heading))
    told = PoseWithCovarianceStamped(header(round(site.time * NS_PER_S), "map"), PoseWithCovariance(pose, np.zeros(36)))
    site.bus.put(keys.POSE.key(robot), told)


def describe(site: Site, robot: str, length: float, width: float) -> None:
    """Let the gateway of a robot tell its size."""
    size = {"length_front": length / 2.0, "length_rear": length / 2.0, "width": width}
    site.bus.serve(keys.DESCRIPTION.key(robot), lambda arguments: {"name": robot, "geometry": size})


def limit_before(site: Site, others: dict[str, float]) -> Any:
    """The speed limit of a robot at the place 0 after two seconds in which others drive to it from so many m away."""
    pushed = site.pushed("obstacle_avoiding", MotionCmd)
    for step in range(20):
        for robot, away in others.items():
            share(site, robot, away - 0.05 * step if away else 0.0, pi if away else 0.0)
        site.push(BASE, RobotOdometry(site.time, 0.0, 0.0, 0.0, 0.3, 0.0, 0))
        far = np.full(361, 8.0) + 0.01 * np.sin(np.arange(361) + step)
        site.push(LASER, LaserRead(site.time, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), -pi / 2.0, pi / 360.0, 8.1, far))
        site.run(0.1)
    return pushed[-1].limit


def test_avoiding_slows_the_robot_before_another_one_that_drives_at_it(site: Site) -> None:
    limit = limit_before(site, {ROBOT: 0.0, OTHER: 1.9})
    assert limit is not None
    assert limit < 0.3
    assert not site.reports


def test_the_larger_a_robot_is_the_earlier_avoiding_slows_before_it(site: Site) -> None:
    describe(site, OTHER, 0.4, 0.3)
    describe(site, THIRD, 0.95, 0.66)
    small = limit_before(site, {ROBOT: 0.0, OTHER: 2.1})
    large = limit_before(site, {ROBOT: 0.0, THIRD: 2.1})
    assert large < small - 0.1
    assert not site.reports


def test_a_robot_that_does_not_tell_its_size_is_asked_again(site: Site) -> None:
    limit = limit_before(site, {ROBOT: 0.0, OTHER: 2.1})
    describe(site, OTHER, 0.95, 0.66)
    site.run(6.0)
    assert limit_before(site, {ROBOT: 0.0, OTHER: 2.1}) < limit - 0.1
    assert not site.reports


def test_without_a_place_on_the_map_avoiding_goes_by_the_sensors_alone(site: Site) -> None:
    limit = limit_before(site, {OTHER: 1.9})
    assert limit is None or limit > 0.8

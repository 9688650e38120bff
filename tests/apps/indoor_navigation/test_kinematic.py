"""Portability: another base and another laser, no other file changed."""

from collections.abc import Iterator
from math import cos, inf, pi, sin
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.platform import Kinds
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component
from apps.indoor_navigation.data import LaserRead, MotionCmd, RobotOdometry, SonarRead
from apps.indoor_navigation.kinematic.plane import Plane
from apps.indoor_navigation.kinematic.robot import KinematicRobot
from apps.indoor_navigation.parameters import WIRING, shipped_parameters
from apps.indoor_navigation.wiring import load_wiring
from configs import ConfigError
from geometry import Pose2D, Segment, Twist2D
from tests.apps.indoor_navigation.site import ROBOT, Site

KINEMATIC = WIRING.with_name("wiring-kinematic.toml")
BOX = (Segment(-1.0, -1.0, 3.0, -1.0), Segment(3.0, -1.0, 3.0, 2.0), Segment(3.0, 2.0, -1.0, 2.0))

metres = st.floats(-5.0, 5.0)


@pytest.fixture
def site() -> Iterator[Site]:
    """The kinematic pair, as the wiring has it."""
    loop = VirtualTimeLoop()
    site = Site(loop)
    for part in (part for part in load_wiring(KINEMATIC).parts if part.process == "hardware"):
        component = Kinds().make(part.kind, part.agent(ROBOT), part.properties)
        assert isinstance(component, Component)
        site.start(component)
    yield site
    site.close()
    loop.close()


def test_two_lines_make_the_navigation_that_of_another_robot(tmp_path: Path) -> None:
    text = WIRING.read_text()
    other = text.replace(
        "components.robot_base_server:RobotBaseServer", "kinematic.base_server:KinematicBaseServer"
    ).replace("components.laser_server:LaserServer", "kinematic.laser_server:KinematicLaserServer")
    assert sum(ours != theirs for ours, theirs in zip(text.splitlines(), other.splitlines(), strict=True)) == 2
    (tmp_path / "wiring.toml").write_text(other)
    kinds = {part.local: part.kind for part in load_wiring(tmp_path / "wiring.toml").parts}
    ours = {part.local: part.kind for part in load_wiring().parts}
    assert {name for name in ours if ours[name] != kinds[name]} == {"robot_base_server", "laser_server"}


def test_it_says_what_it_is(site: Site) -> None:
    about = site.ask("robot_base_server", "robot")
    assert about["model"] == "kinematic"
    assert about.keys() == {"name", "model", "front", "rear", "width", "radius", "limits"}


def test_it_drives_as_it_is_told_and_stops_when_nobody_tells_it(site: Site) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    for _ in range(40):
        site.push("motion_fuser", MotionCmd(site.time, "motion_fuser", 0.4, 0.0, 1.0))
        site.run(0.05)
    assert heard[-1].x == pytest.approx(0.4 * 2.0, abs=0.1)
    assert heard[-1].linear == pytest.approx(0.4)
    site.run(1.0)
    assert heard[-1].linear == 0.0
    assert heard[-1].x == pytest.approx(0.4 * 2.35, abs=0.1)


def test_it_stops_at_a_wall_and_does_not_go_through(site: Site) -> None:
    heard = site.pushed("robot_base_server", RobotOdometry)
    for _ in range(400):
        site.push("motion_fuser", MotionCmd(site.time, "motion_fuser", 0.9, 0.0, 1.0))
        site.run(0.05)
    assert 7.6 < heard[-1].x <= 7.75  # through the gap at x = 3 to the wall at x = 8, less its radius


def test_its_sonar_and_laser_see_the_walls_of_the_same_map(site: Site) -> None:
    sonar = site.pushed("robot_base_server", SonarRead)
    laser = site.pushed("laser_server", LaserRead)
    site.run(1.0)
    reading, scan = sonar[-1], laser[-1]
    assert len(reading.ranges) == 16
    assert reading.ranges[8] == pytest.approx(2.0 - 0.25, abs=0.01)  # behind it, the wall at x = -2
    assert len(scan.ranges) == 361
    assert scan.ranges[0] == pytest.approx(3.0)  # to the right, the wall at y = -3
    assert scan.ranges[180] == pytest.approx(8.0 - 0.1)  # ahead, through the gap
    assert scan.pose == (0.0, 0.0, 0.0)


def test_without_its_base_the_laser_says_nothing_new_of_the_place(site: Site) -> None:
    laser = site.pushed("laser_server", LaserRead)
    site.kill("robot_base_server")
    site.run(1.0)
    assert not {scan.pose for scan in laser} - {(0.0, 0.0, 0.0)}


def test_a_map_that_is_not_there_is_told() -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.map: cannot be read"):
        Plane.read("nowhere.map")


@given(metres, metres, st.lists(st.floats(-pi, pi), min_size=1, max_size=8))
def test_rays_end_at_the_first_wall(x: float, y: float, directions: list[float]) -> None:
    ranges = Plane(BOX, Pose2D()).ranges(x, y, np.array(directions), 4.0)
    for direction, measured in zip(directions, ranges, strict=True):
        nearest = min(wall.hit_by(x, y, direction) for wall in BOX)
        if abs(nearest - 4.0) > 1e-6:
            beside = any(
                min(wall.hit_by(x, y, direction + side) for wall in BOX) == pytest.approx(measured, abs=1e-3)
                for side in (-1e-6, 1e-6)
            )
            assert beside or measured == pytest.approx(nearest if nearest <= 4.0 else inf)


@given(st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-3.0, 3.0)), max_size=60))
def test_a_kinematic_robot_never_leaves_its_room(wanted: list[tuple[float, float]]) -> None:
    walls = (*BOX, Segment(-1.0, 2.0, -1.0, -1.0))
    plane = Plane(walls, Pose2D())
    body = shipped_parameters("robot_base_server", KINEMATIC).body
    robot = KinematicRobot(body, plane)
    for linear, angular in wanted:
        for _ in range(10):
            robot.step(Twist2D(linear, angular), 0.05)
            assert plane.clearance(robot.pose.x, robot.pose.y) >= body.radius - 1e-9
    assert cos(robot.pose.heading) ** 2 + sin(robot.pose.heading) ** 2 == pytest.approx(1.0)


def test_an_empty_plane_is_seen_as_empty() -> None:
    plane = Plane((), Pose2D())
    assert plane.ranges(0.0, 0.0, np.array([0.0, 1.0]), 8.0).tolist() == [inf, inf]
    assert plane.clearance(0.0, 0.0) == inf

"""What the map is drawn from: records for the browser, ranges, and the cells that a laser has seen."""

import struct
from math import inf, nan, pi
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.console.map_feed import encoded_goal
from apps.console.map_layers import HEADER, NOTHING, SeenCells, mission_layout, ranges_mm, robot_layout, robot_record
from apps.console.robots import WatchedRobot
from bus.messages import quaternion
from geometry import Pose2D


def odom(x: float, y: float, heading: float) -> SimpleNamespace:
    pose = SimpleNamespace(position=SimpleNamespace(x=x, y=y), orientation=quaternion(heading))
    twist = SimpleNamespace(linear=SimpleNamespace(x=0.25), angular=SimpleNamespace(z=-0.5))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=SimpleNamespace(twist=twist))


def scan(*ranges: float) -> SimpleNamespace:
    return SimpleNamespace(
        ranges=np.array(ranges), angle_min=-pi / 2, angle_increment=pi / 2, range_min=0.02, range_max=8.0
    )


@given(st.integers(0, 40), st.integers(0, 40))
def test_records_are_aligned_and_hold_pose_and_ranges(discs: int, beams: int) -> None:
    sonar, laser = np.arange(discs, dtype=np.uint16), np.arange(100, 100 + beams, dtype=np.uint16)
    record = robot_record(3, odom(1.0, -2.0, 0.5), 12.5, sonar, laser)
    assert len(record) % 8 == 0
    number, _, disc_count, beam_count, stamp, *pose = HEADER.unpack_from(record)
    assert (number, disc_count, beam_count, stamp) == (3, discs, beams, 12.5)
    assert pose == pytest.approx([1.0, -2.0, 0.5, 0.25, -0.5])
    assert struct.unpack_from(f"<{discs + beams}H", record, HEADER.size) == (*sonar, *laser)


def test_what_was_not_measured_is_nothing() -> None:
    assert ranges_mm([1.5, inf, nan, 0.0, -1.0, 70.0]).tolist() == [1500, *[NOTHING] * 5]


def test_cells_are_those_that_the_laser_hit_each_once() -> None:
    seen = SeenCells(0.05, 100)
    for _ in range(2):
        seen.add(scan(inf, 1.02, 8.0), Pose2D(1.0, 2.0, pi / 2), Pose2D(0.2, 0.0, 0.0))
    assert seen.cells.tolist() == [[20, 64]]  # straight ahead, which is +y: x 1.0, y 2.0 + 0.2 + 1.02


def test_no_more_cells_are_kept_than_allowed() -> None:
    seen = SeenCells(0.05, 2)
    seen.add(scan(1.0, 2.0, 3.0), Pose2D(), Pose2D())
    seen.add(scan(4.0, 5.0, 6.0), Pose2D(), Pose2D())
    assert len(seen.cells) == 2


def test_a_goal_on_the_map_is_given_in_the_frame_of_the_robot() -> None:
    assert encoded_goal(Pose2D(2.0, 1.0, pi / 2), 2.0, 4.0, pi) == {"x": 3.0, "y": 0.0, "heading": 1.5708}
    assert encoded_goal(None, 2.0, 4.0, None) == {"x": 2.0, "y": 4.0}


HOSTILE = {"geometry": {"sonar": [{"number": "1"}, {"number": 2, "x": nan}, 5], "width": "wide"}, "elements": "none"}


def test_a_description_that_makes_no_sense_is_drawn_with_usual_values() -> None:
    layout = robot_layout(WatchedRobot("odd", description=HOSTILE), None, ("ok", "ready"))
    assert (layout["width"], layout["is_placed"]) == (0.4, False)
    assert layout["sonar"] == [None, None, [0.0, 0.0, 0.0, 0.26]]


def test_a_goal_is_drawn_while_the_mission_is_active() -> None:
    told = {
        "goal": {"x": 1.0, "y": 2.0, "heading": None},
        "state": "active",
        "doors": [{"x": 1.0}, 7],
        "route": [[0, 0]],
    }
    assert mission_layout(told)["goal"] == [1.0, 2.0, None]
    assert mission_layout({**told, "state": "done", "route": []})["goal"] is None
    assert mission_layout({"goal": "x"})["doors"] == []

"""What the map is drawn from, in the form in which the browser gets it (`map.js`). No bus, no clock.

An update has one record for each robot whose pose is known: a header, then the ranges of its sonar discs, then those of
its laser. Ranges are in mm, `NOTHING` where nothing was measured. All numbers are little-endian.
"""

import struct
from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from apps.console.robots import WatchedRobot
from bus.messages import heading
from geometry import Pose2D

HEADER = struct.Struct("<HHHHd5f4x")
"""Number of the robot, flags, number of discs, number of beams, stamp of the pose in s since 1970, x, y, heading, speed
ahead and turning speed."""
NOTHING = 0xFFFF
_FARTHEST = 65.0  # m
_SWEEP = 1.0  # s for which the range of a disc is shown
_LARGEST = 32_000  # cells from the origin of a frame, as 16 bits hold them
_OF_DOORS = ("x", "y", "width", "normal")
_PIVOT = np.uint64(1 << 20)


def robot_record(number: int, odom: Any, stamp: float, sonar: NDArray[np.uint16], beams: NDArray[np.uint16]) -> bytes:
    """Return the record of one robot.

    Args:
        number: Of the robot in the layout.
        odom: Its newest Odometry.
        stamp: Of that, s since 1970.
        sonar: Ranges by disc, mm.
        beams: Ranges of its laser, mm.
    """
    pose, twist = odom.pose.pose, odom.twist.twist
    head = HEADER.pack(
        number,
        0,
        len(sonar),
        len(beams),
        stamp,
        pose.position.x,
        pose.position.y,
        heading(pose.orientation),
        twist.linear.x,
        twist.angular.z,
    )
    body = sonar.astype("<u2").tobytes() + beams.astype("<u2").tobytes()
    return head + body + bytes(-len(body) % 8)


def ranges_mm(ranges: Iterable[float]) -> NDArray[np.uint16]:
    """Return ranges, m, as the browser gets them; what is not finite or too far is `NOTHING`."""
    metres = np.asarray(ranges, np.float64)
    with np.errstate(invalid="ignore"):  # NaN is no measurement
        is_measured = np.isfinite(metres) & (metres > 0.0) & (metres < _FARTHEST)
    return np.where(is_measured, np.where(is_measured, metres, 0.0) * 1000.0, NOTHING).astype(np.uint16)


class SonarPicture:
    """The newest range of each disc of a robot; a message has those that are fresh."""

    def __init__(self, discs: int) -> None:
        """Begin without ranges."""
        self._ranges = np.full(discs, NOTHING, np.uint16)
        self._heard = np.full(discs, -np.inf)

    def hear(self, message: Any, now: float) -> None:
        """Take a RangeArray at a time, s."""
        for reading in message.ranges:
            _, _, number = reading.header.frame_id.rpartition("_")
            if number.isdecimal() and int(number) < len(self._ranges):
                self._ranges[int(number)] = ranges_mm([reading.range])[0]
                self._heard[int(number)] = now

    def ranges(self, now: float) -> NDArray[np.uint16]:
        """Return the ranges by disc, mm, without old ones."""
        return np.where(now - self._heard <= _SWEEP, self._ranges, NOTHING).astype(np.uint16)


class SeenCells:
    """The cells of a robot's frame odom in which its laser has seen something. cells: all of them, in their order."""

    def __init__(self, edge: float, most: int) -> None:
        """Begin empty.

        Args:
            edge: Of a cell, m.
            most: Cells that are kept; further ones are left out.
        """
        self.cells: NDArray[np.int16] = np.zeros((0, 2), np.int16)
        self._known: NDArray[np.uint64] = np.zeros(0, np.uint64)  # sorted
        self._edge, self._most = edge, most

    def add(self, scan: Any, pose: Pose2D, mount: Pose2D) -> None:
        """Take a LaserScan.

        Args:
            scan: The scan.
            pose: Of the robot in odom.
            mount: Of the laser on the robot.
        """
        ranges = np.asarray(scan.ranges, np.float64)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        with np.errstate(invalid="ignore"):  # NaN is no hit
            is_hit = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges < scan.range_max)
        laser = pose.compose(mount)
        directions, far = angles[is_hit] + laser.heading, ranges[is_hit]
        places = np.stack((laser.x + far * np.cos(directions), laser.y + far * np.sin(directions)), axis=1)
        cells = np.floor(places / self._edge)
        cells = cells[(np.abs(cells) < _LARGEST).all(axis=1)].astype(np.int64)
        keys = ((cells[:, 0] + (1 << 19)).astype(np.uint64) * _PIVOT) + (cells[:, 1] + (1 << 19)).astype(np.uint64)
        keys, first = np.unique(keys, return_index=True)
        is_new = ~np.isin(keys, self._known, assume_unique=True)
        is_new[np.flatnonzero(is_new)[max(0, self._most - len(self.cells)) :]] = False
        if is_new.any():
            self._known = np.union1d(self._known, keys[is_new])
            self.cells = np.concatenate((self.cells, cells[first[is_new]].astype(np.int16)))


def robot_layout(robot: WatchedRobot, place: Pose2D | None, standing: tuple[str, str]) -> dict[str, Any]:
    """Return what is drawn of a robot besides its readings; m and rad.

    Args:
        robot: Which.
        place: Of its frame odom on the map; None if it is not known.
        standing: Its state, and in words.
    """
    geometry = robot.description.get("geometry")
    shape = geometry if isinstance(geometry, Mapping) else {}
    laser = robot.elements.get("laser", {})
    mount = laser.get("geometry") if isinstance(laser.get("geometry"), Mapping) else {}
    return {
        "name": robot.name,
        "is_there": robot.is_there,
        "is_placed": place is not None,
        "place": [place.x, place.y, place.heading] if place is not None else [0.0, 0.0, 0.0],
        "level": standing[0],
        "words": standing[1],
        "front": _number(shape, "length_front", 0.2),
        "rear": _number(shape, "length_rear", 0.2),
        "width": _number(shape, "width", 0.4),
        "sonar": _discs(shape),
        "laser": {
            "x": _number(mount, "x", 0.0),
            "y": _number(mount, "y", 0.0),
            "heading": _number(mount, "heading", 0.0),
            "first": _number(laser, "angle_min", 0.0),
            "step": _number(laser, "angle_increment", 0.0),
        },
    }


def mission_layout(told: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is drawn of a robot's navigation, by the answer of its path planning; m and rad in odom."""
    goal = told.get("goal")
    has_goal = isinstance(goal, Mapping) and is_number(goal.get("x")) and is_number(goal.get("y"))
    is_active = told.get("state") == "active" or bool(told.get("route"))
    return {
        "goal": [goal["x"], goal["y"], goal.get("heading")] if has_goal and is_active and goal is not None else None,
        "target": told.get("sub_target") if is_active else None,
        "route": told.get("route") or [],
        "doors": doors_layout(told.get("doors") or ()),
        "state": str(told.get("state", "")),
        "why": str(told.get("why") or "")[:300],
        "mission": str(told.get("mission", "")),
    }


def doors_layout(told: Iterable[Any]) -> list[list[float]]:
    """Return x, y, width, normal and confidence of each door, m and rad; what is none is left out."""
    return [
        [door["x"], door["y"], door["width"], door["normal"], door.get("confidence", 1.0)]
        for door in told
        if isinstance(door, Mapping)
        and all(is_number(door.get(key)) for key in _OF_DOORS)
        and is_number(door.get("confidence", 1.0))
    ]


def laser_mount(robot: WatchedRobot) -> Pose2D | None:
    """Return where a robot's laser is on it; None without a laser."""
    laser = robot.elements.get("laser")
    if laser is None:
        return None
    mount = laser.get("geometry")
    shape = mount if isinstance(mount, Mapping) else {}
    return Pose2D(_number(shape, "x", 0.0), _number(shape, "y", 0.0), _number(shape, "heading", 0.0))


def disc_count(robot: WatchedRobot) -> int:
    """Return the number of a robot's sonar discs, as their numbers go."""
    geometry = robot.description.get("geometry")
    return len(_discs(geometry if isinstance(geometry, Mapping) else {}))


def _discs(shape: Mapping[str, Any]) -> list[list[float] | None]:
    """Return x, y, heading and field of view of each disc, by its number; None where there is none."""
    rows = [row for row in shape.get("sonar") or () if isinstance(row, Mapping) and isinstance(row.get("number"), int)]
    found = {
        row["number"]: [
            _number(row, "x", 0.0),
            _number(row, "y", 0.0),
            _number(row, "heading", 0.0),
            _number(row, "field_of_view", 0.26),
        ]
        for row in rows
        if 0 <= row["number"] < 64
    }
    return [found.get(number) for number in range(max(found, default=-1) + 1)]


def _number(table: Any, key: str, otherwise: float) -> float:
    value = table.get(key) if isinstance(table, Mapping) else None
    return float(value) if value is not None and is_number(value) else otherwise


def is_number(value: Any) -> bool:
    """Return whether a value that a program has sent is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)

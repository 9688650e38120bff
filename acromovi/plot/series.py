"""What the pictures of a recording show: curves of each robot, read from its samples."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bus import keys
from bus.errors import MessageError
from bus.messages import NS_PER_S, heading
from geometry import Pose2D
from recorder.recording import Recorded

GRID_TYPE = "nav_msgs/msg/OccupancyGrid"
LASER_PERIOD = 0.5  # s between two scans that are drawn
LASER_BEAMS = 60  # of each of them
MAP_FRAME = "map"
Curve = list[tuple[float, float]]
"""Times in s since the start of the recording, and values."""


@dataclass(slots=True)
class RobotSeries:
    """The curves of one robot.

    path: poses in its odometry frame: time in s, pose. in_map: that frame in the map; None unless a transform says it.
    commanded, actual: forward m/s; commanded_turn, actual_turn: rad/s. laser, sonar: nearest range of each reading, m.
    battery: V. latency: s from the stamp of a message to its arrival, by the clocks of both machines.
    seen: points of the laser in the odometry frame, m.
    """

    name: str
    path: list[tuple[float, Pose2D]] = field(default_factory=list)
    in_map: Pose2D | None = None
    commanded: Curve = field(default_factory=list)
    actual: Curve = field(default_factory=list)
    commanded_turn: Curve = field(default_factory=list)
    actual_turn: Curve = field(default_factory=list)
    laser: Curve = field(default_factory=list)
    sonar: Curve = field(default_factory=list)
    battery: Curve = field(default_factory=list)
    latency: Curve = field(default_factory=list)
    seen: list[tuple[float, float]] = field(default_factory=list)


def is_drawn(key: str) -> bool:
    """Return whether samples on a key are drawn."""
    return keys.topic_of(key) in _TAKERS


def read_series(samples: Iterable[Recorded], start_ns: int) -> tuple[list[RobotSeries], int]:
    """Read the curves of all robots.

    Args:
        samples: In the order of their times; other keys are passed over.
        start_ns: Time 0 of the curves.
    Returns:
        The robots that have odometry, by name, and how many samples could not be decoded.
    """
    robots: dict[str, RobotSeries] = {}
    damaged = 0
    for recorded in samples:
        topic = keys.topic_of(recorded.sample.key)
        if topic is None or topic not in _TAKERS:
            continue
        name, _ = keys.split(recorded.sample.key)
        robot = robots.setdefault(name, RobotSeries(name))
        time = (recorded.time_ns - start_ns) / NS_PER_S
        if recorded.published_ns != recorded.time_ns:
            robot.latency.append((time, (recorded.time_ns - recorded.published_ns) / NS_PER_S))
        try:
            _TAKERS[topic](robot, time, recorded.sample.decoded())
        except (MessageError, AttributeError):  # garbage, or another type than the key's
            damaged += 1
    return [robots[name] for name in sorted(robots) if robots[name].path], damaged


def _take_odometry(robot: RobotSeries, time: float, message: Any) -> None:
    pose, moving = message.pose.pose, message.twist.twist
    place = Pose2D(pose.position.x, pose.position.y, heading(pose.orientation))
    if all(map(math.isfinite, (place.x, place.y, place.heading))):
        robot.path.append((time, place))
    robot.actual.append((time, moving.linear.x))
    robot.actual_turn.append((time, moving.angular.z))


def _take_command(robot: RobotSeries, time: float, message: Any) -> None:
    told = getattr(message, "twist", message)
    robot.commanded.append((time, told.linear.x))
    robot.commanded_turn.append((time, told.angular.z))


def _take_sonar(robot: RobotSeries, time: float, message: Any) -> None:
    ranges = [each.range for each in message.ranges if math.isfinite(each.range)]
    if ranges:
        robot.sonar.append((time, min(ranges)))


def _take_battery(robot: RobotSeries, time: float, message: Any) -> None:
    robot.battery.append((time, message.voltage))


def _take_transforms(robot: RobotSeries, time: float, message: Any) -> None:
    for each in message.transforms:
        if each.header.frame_id == MAP_FRAME and each.child_frame_id == keys.frame(robot.name, "odom"):
            moved = each.transform
            robot.in_map = Pose2D(moved.translation.x, moved.translation.y, heading(moved.rotation))


def _take_scan(robot: RobotSeries, time: float, scan: Any) -> None:
    ranges = np.asarray(scan.ranges, np.float64)
    low, high = scan.range_min, scan.range_max
    good = np.isfinite(ranges) & (ranges >= low) & (ranges <= high)
    if not good.any():
        return
    is_due = not robot.laser or int(time / LASER_PERIOD) != int(robot.laser[-1][0] / LASER_PERIOD)
    robot.laser.append((time, float(ranges[good].min())))
    if is_due and robot.path:
        place = robot.path[-1][1]
        step = max(1, len(ranges) // LASER_BEAMS)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        for angle, distance in zip(angles[good][::step], ranges[good][::step], strict=True):
            robot.seen.append(place.transform(distance * math.cos(angle), distance * math.sin(angle)))


_TAKERS: dict[keys.Topic, Callable[[RobotSeries, float, Any], None]] = {
    keys.ODOM: _take_odometry,
    keys.CMD_VEL: _take_command,
    keys.CMD_VEL_STAMPED: _take_command,
    keys.SCAN: _take_scan,
    keys.SONAR: _take_sonar,
    keys.BATTERY: _take_battery,
    keys.TF: _take_transforms,
}


def worst_each_second(curve: Curve) -> Iterator[tuple[float, float]]:
    """Yield the largest value of each second of a curve."""
    second, worst = None, -math.inf
    for time, value in curve:
        if second is not None and int(time) != second:
            yield float(second), worst
            worst = -math.inf
        second, worst = int(time), max(worst, value)
    if second is not None:
        yield float(second), worst

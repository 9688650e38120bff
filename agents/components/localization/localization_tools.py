"""What localizes a robot, in the thread of its agent: the map, the localizer, and readings decoded for it."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import sqrt
from typing import Any
from zlib import compress

import numpy as np
from numpy.typing import NDArray

from bus import MessageError, Refused, Sample, keys
from bus.keys import frame
from bus.messages import (
    NS_PER_S,
    LaserScan,
    Odometry,
    Point,
    Pose,
    RangeArray,
    TFMessage,
    decode,
    header,
    heading,
    placed,
    quaternion,
    stamp_ns,
)
from bus.ros_msgs import MapMetaData, OccupancyGridMessage, PoseWithCovariance, PoseWithCovarianceStamped
from geometry import MapError, Pose2D, wrap_angle
from maps.building_map import BuildingMap
from maps.localization.localizer import LocalizationEstimate, LocalizationState, Localizer
from maps.localization.settings import LocalizationSettings
from maps.map_files import read_building_map
from maps.rasterization import forbidden_cells, grid_of

MAP_FRAME = "map"
HOME, UNKNOWN = "home", "unknown"
"""Where a localization may begin, beside a pose."""
CLEARANCE = 0.25
"""m between a goal and the nearest wall, at least: about the radius of the smallest robot."""
_REASONS: Mapping[LocalizationState, str | None] = {
    LocalizationState.LOCALIZED: None,
    LocalizationState.CHECKING: "the readings do not fit the given pose yet; let the robot turn once, or drive it on",
    LocalizationState.SEARCHING: "the readings fit no place, or several; drive on",
    LocalizationState.WRONG_MAP: "no place of the map explains the readings: it is the wrong map, or far out of date",
}


@dataclass(frozen=True, slots=True)
class SensorPlaces:
    """Where the sensors are on the robot.

    laser: in `base_link`; None without a laser. discs: of the sonar by their numbers.
    """

    laser: Pose2D | None
    discs: Mapping[int, Pose2D]

    @classmethod
    def of(cls, properties: Mapping[str, Any]) -> "SensorPlaces":
        """Read them from the properties of the agent."""
        laser = properties.get("laser")
        discs = {int(disc["number"]): _pose(disc) for disc in properties.get("discs") or []}
        return cls(None if laser is None else _pose(laser), discs)


def _pose(row: Mapping[str, Any]) -> Pose2D:
    return Pose2D(row.get("x", 0.0), row.get("y", 0.0), row.get("heading", 0.0))


class LocalizationTools:
    """A localization that is under way. Only the thread of the agent calls it."""

    def __init__(
        self,
        robot: str,
        file: str,
        start: str | Sequence[float],
        places: SensorPlaces,
        settings_file: str,
        seed: int = 0,
    ) -> None:
        """Read the map, and begin.

        Args:
            robot: Its name on the bus.
            file: Of the map.
            start: `home`, `unknown`, or x, y (m) and heading (rad) in the map.
            places: Of the sensors.
            settings_file: Changes of the settings; none if empty.
            seed: Of the particles.
        Raises:
            Refused: The map cannot be used, or it has no `RobotHome`.
        """
        try:
            self.map: BuildingMap = read_building_map(file)
            self._settings: LocalizationSettings = LocalizationSettings.load(settings_file or None)
            self._localizer = Localizer(self.map, self._settings, seed)
        except (MapError, ValueError) as err:  # ConfigError is a ValueError
            raise Refused(str(err)) from err
        self.file = file
        self._robot = robot
        self._places = places
        if start == UNKNOWN:
            self._localizer.start_unknown()
        elif start == HOME:
            if self.map.home is None:
                raise Refused(f"{file} has no RobotHome; give a pose, or start with pose={UNKNOWN}")
            self._localizer.start_at(self.map.home)
        else:
            self.set_pose(Pose2D(*map(float, start)))

    def set_pose(self, pose: Pose2D) -> None:
        """Begin again at a pose in the map.

        Raises:
            Refused: It is outside the map.
        """
        x_min, y_min, x_max, y_max = self.map.bounds
        if not (x_min <= pose.x <= x_max and y_min <= pose.y <= y_max):
            raise Refused(
                f"({pose.x:.2f}, {pose.y:.2f}) is outside the map, which reaches from ({x_min:.2f}, {y_min:.2f}) to"
                f" ({x_max:.2f}, {y_max:.2f}) m"
            )
        self._localizer.start_at(Pose2D(pose.x, pose.y, wrap_angle(pose.heading)))

    def take(self, samples: Iterable[Sample]) -> LocalizationEstimate:
        """Use messages of odometry, laser and sonar in the order of their arrival; others are left out."""
        for sample in samples:
            with suppress(MessageError, AttributeError, KeyError):  # what cannot be read is missing only
                self._take(sample.type_name, decode(sample.type_name, sample.payload))
        while self._localizer.advance():
            pass
        return self._localizer.estimate

    def _take(self, type_name: str, message: Any) -> None:
        time = stamp_ns(message.header) / NS_PER_S
        if type_name == keys.ODOM.type_name:
            self._take_odometry(time, message)
        elif type_name == keys.SCAN.type_name:
            if self._places.laser is not None:
                self._localizer.add_scan(time, scan_ends(message, self._places.laser, self._settings.field.laser_range))
                self._localizer.advance()
        elif type_name == keys.SONAR.type_name:
            self._localizer.add_sonar(time, sonar_ends(message, self._places.discs, self._settings))

    def _take_odometry(self, time: float, message: Odometry) -> None:
        at = message.pose.pose
        self._localizer.add_odometry(time, Pose2D(at.position.x, at.position.y, heading(at.orientation)))
        self._localizer.advance()

    def result(self, estimate: LocalizationEstimate) -> dict[str, Any]:
        """What the agent publishes of an estimate."""
        pose, errors = estimate.pose, estimate.errors
        reason = _REASONS[estimate.state]
        if estimate.silence > self._settings.trust.silence:
            reason = f"no range reading for {estimate.silence:.0f} s; the pose is that of odometry"
        return {
            "stamp": estimate.time,
            "state": str(estimate.state),
            "pose": None if pose is None else _rounded(pose),
            "deviations": [round(sqrt(max(0.0, each)), 4) for each in np.diag(estimate.covariance).tolist()],
            "score": round(estimate.score, 3),
            "particles": estimate.particles,
            "odom_in_map": None if estimate.map_to_odom is None else _rounded(estimate.map_to_odom),
            "odometry": {
                "distance": round(errors.distance, 4),
                "turn": round(errors.turn, 4),
                "drift": round(errors.drift, 4),
            },
            "silence": round(estimate.silence, 2),
            "map": self.file,
            "reason": reason,
        }

    def pose_message(self, estimate: LocalizationEstimate) -> PoseWithCovarianceStamped:
        """The pose in `map`; the estimate has one."""
        assert estimate.pose is not None
        covariance = np.zeros((6, 6))
        covariance[np.ix_((0, 1, 5), (0, 1, 5))] = estimate.covariance
        pose = PoseWithCovariance(pose=_pose_message(estimate.pose), covariance=covariance.reshape(-1))
        return PoseWithCovarianceStamped(header=header(round(estimate.time * NS_PER_S), MAP_FRAME), pose=pose)

    def transform(self, estimate: LocalizationEstimate) -> TFMessage:
        """Where `odom` is in `map`; the estimate has it."""
        origin = estimate.map_to_odom
        assert origin is not None
        parent = header(round(estimate.time * NS_PER_S), MAP_FRAME)
        return TFMessage(transforms=[placed(parent, frame(self._robot, "odom"), origin.x, origin.y, origin.heading)])

    def map_message(self, stamp: int) -> OccupancyGridMessage:
        """The map as a grid."""
        grid = grid_of(self.map)
        about = header(stamp, MAP_FRAME)
        rows, columns = grid.cells.shape
        info = MapMetaData(
            map_load_time=about.stamp,
            resolution=grid.resolution,
            width=columns,
            height=rows,
            origin=_pose_message(grid.origin),
        )
        return OccupancyGridMessage(header=about, info=info, data=grid.cells.reshape(-1))

    def floor(self) -> dict[str, Any]:
        """The map for planning: an upright grid of cells as in OccupancyGrid, and those that are forbidden.

        `cells` (int8) and `forbidden` (uint8, 0 or 1) are row by row from the lowest y, compressed by zlib, in base64.
        """
        grid = grid_of(self.map)
        rows, columns = grid.cells.shape
        return {
            "x": grid.origin.x,
            "y": grid.origin.y,
            "resolution": grid.resolution,
            "rows": rows,
            "columns": columns,
            "cells": _packed(grid.cells),
            "forbidden": _packed(forbidden_cells(self.map, grid)),
        }

    def goal(self, name: str, x: float | None, y: float | None, heading_: float | None) -> dict[str, Any]:
        """A goal in `odom`, for the present estimate.

        Args:
            name: Of a goal of the map; empty for a pose.
            x, y, heading_: In the map, m and rad; heading None for any.
        Raises:
            Refused: The robot is not localized, the map has no such goal, or no robot can stand there.
        """
        estimate = self._localizer.estimate
        if estimate.state is not LocalizationState.LOCALIZED or estimate.map_to_odom is None:
            raise Refused(f"{self._robot} is not localized: {_REASONS[estimate.state] or 'it has no pose yet'}")
        if name:
            try:
                place = self.map.goal(name)
            except KeyError as err:
                raise Refused(f"{self.file}: {err.args[0]}") from err
            name, is_turned = place.name, place.kind != "Goal" or heading_ is not None
            target = Pose2D(
                place.pose.x, place.pose.y, place.pose.heading if heading_ is None else wrap_angle(heading_)
            )
        else:
            if x is None or y is None:
                raise Refused("a goal needs a name, or x and y")
            target, is_turned = Pose2D(x, y, wrap_angle(heading_ or 0.0)), heading_ is not None
        self._check(target, name)
        there = target.relative_to(estimate.map_to_odom)
        return {
            "name": name,
            "map": _rounded(target),
            "x": round(there.x, 4),
            "y": round(there.y, 4),
            "heading": round(there.heading, 4) if is_turned else None,
        }

    def _check(self, target: Pose2D, name: str) -> None:
        called = f'"{name}"' if name else f"({target.x:.2f}, {target.y:.2f})"
        if self.map.is_forbidden(target.x, target.y):
            raise Refused(f"{called} is in a forbidden area of the map")
        x_min, y_min, x_max, y_max = self.map.bounds
        if not (x_min <= target.x <= x_max and y_min <= target.y <= y_max):
            raise Refused(f"{called} is outside the map")
        away = float(self._localizer.likelihoods.distances_at(np.array([[target.x, target.y]]))[0])
        if away < CLEARANCE:
            raise Refused(f"{called} is {away:.2f} m from a wall of the map; a robot needs {CLEARANCE:g} m at least")


def scan_ends(message: LaserScan, laser: Pose2D, longest: float) -> NDArray[np.float64]:
    """Ends of the ranges of a scan in `base_link`, m, shape (n, 2); without those beyond `longest` m or missing."""
    ranges = np.asarray(message.ranges, np.float64)
    is_used = np.isfinite(ranges) & (ranges > message.range_min) & (ranges < min(longest, message.range_max))
    angles = laser.heading + message.angle_min + np.flatnonzero(is_used) * message.angle_increment
    used = ranges[is_used]
    return np.stack((laser.x + used * np.cos(angles), laser.y + used * np.sin(angles)), axis=1)


def sonar_ends(message: RangeArray, discs: Mapping[int, Pose2D], settings: LocalizationSettings) -> NDArray[np.float64]:
    """Places on the arcs of sonar echoes in `base_link`, m, shape (echoes, places, 2)."""
    field = settings.field
    spread = np.linspace(-field.sonar_half_angle, field.sonar_half_angle, field.arc_points)
    arcs = []
    for each in message.ranges:
        disc = discs.get(int(each.header.frame_id.rpartition("_")[2]))
        if disc is not None and each.min_range <= each.range < min(field.sonar_range, each.max_range):
            angles = disc.heading + spread
            arcs.append(np.stack((disc.x + each.range * np.cos(angles), disc.y + each.range * np.sin(angles)), axis=1))
    return np.array(arcs, np.float64).reshape(-1, field.arc_points, 2)


def _packed(cells: NDArray[Any]) -> str:
    return b64encode(compress(cells.tobytes())).decode()


def _rounded(pose: Pose2D) -> list[float]:
    return [round(pose.x, 4), round(pose.y, 4), round(pose.heading, 4)]


def _pose_message(pose: Pose2D) -> Pose:
    return Pose(position=Point(x=pose.x, y=pose.y, z=0.0), orientation=quaternion(pose.heading))

"""The work of the mapping agent, in its thread: messages in, map and figures out."""

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.components.mapping.settings import MappingAgentSettings
from bus import MessageError, Sample
from bus.messages import (
    NS_PER_S,
    Header,
    LaserScan,
    Odometry,
    Pose,
    RangeArray,
    Time,
    decode,
    header,
    heading,
    quaternion,
    stamp_ns,
)
from bus.ros_msgs import MapMetaData, OccupancyGridMessage, Point
from geometry import Pose2D
from maps.building.building import evidence_of, grid_of_evidence, map_of
from maps.building.evidence import EvidenceGatherer
from maps.building.laser_builder import KeyScan, LaserMapBuilder
from maps.building.readings import Mount, OdometryTrack, ScanReading, laser_view
from maps.building.sonar import MATCHING, DiscReading, SonarViews, echo_normals
from maps.building.surfaces import surface_points
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid

MAP_FRAME = "map"


@dataclass(frozen=True, slots=True)
class Sensors:
    """Where the laser and the sonar discs are on the robot; no laser, or no discs, where there are none."""

    laser: Mount | None
    discs: Mapping[int, Mount]


class MapWork:
    """A map that is being built from the messages of one robot.

    unread: Messages that could not be decoded.
    """

    def __init__(
        self,
        sensors: Sensors,
        settings: MappingAgentSettings,
        base: BuildingMap | None = None,
        start: Pose2D | None = None,
    ) -> None:
        """Begin.

        Args:
            sensors: Of the robot; the laser is used where there is one.
            settings: Of the agent.
            base: The map that is extended.
            start: Where the robot is, in `map`; by default the home of the base, or its origin.
        """
        self.unread = 0
        self.scans = 0
        self._mount = sensors.laser
        self._sonar = SonarViews(sensors.discs, settings.sonar) if sensors.laser is None else None
        self._settings = settings
        self._base = base
        self._track = OdometryTrack()
        origin = start or (base.home if base is not None else None) or Pose2D()
        surfaces = None if base is None else surface_points(base)
        self._builder = (
            LaserMapBuilder(settings.laser, origin, surfaces)
            if self._sonar is None
            else LaserMapBuilder(MATCHING, origin, surfaces, echo_normals)
        )
        self._gatherer = EvidenceGatherer(settings.output.resolution_m)
        self._waiting: deque[ScanReading | DiscReading] = deque()  # for the odometry after them

    def take(self, samples: Iterable[Sample]) -> bool:
        """Take messages of odometry and laser in their order.

        Returns:
            Whether the map has changed.
        Raises:
            NotPlaced: The first scan does not fit the map that is extended.
        """
        changed = False
        for sample in samples:
            try:
                message = decode(sample.type_name, sample.payload)
            except MessageError:
                self.unread += 1
                continue
            changed |= self.read(message)
        return changed

    def read(self, message: object) -> bool:
        """Take one message; return whether the map has changed."""
        if isinstance(message, Odometry):
            place = message.pose.pose
            pose = Pose2D(place.position.x, place.position.y, heading(place.orientation))
            self._track.add(stamp_ns(message.header) / NS_PER_S, pose)
        elif isinstance(message, RangeArray) and self._sonar is not None:
            for each in message.ranges:
                disc = each.header.frame_id.rpartition("_")[2]
                if disc.isdecimal():
                    self._waiting.append(DiscReading(stamp_ns(each.header) / NS_PER_S, int(disc), float(each.range)))
        elif isinstance(message, LaserScan) and self._sonar is None:
            self._waiting.append(
                ScanReading(
                    stamp_ns(message.header) / NS_PER_S,
                    message.angle_min,
                    message.angle_increment,
                    message.time_increment,
                    np.asarray(message.ranges, np.float64),
                )
            )
        return self._read_waiting()

    def _read_waiting(self) -> bool:
        """Take the readings for which odometry has come."""
        changed = False
        while self._waiting and self._waiting[0].stamp < self._track.newest:
            reading = self._waiting.popleft()
            if isinstance(reading, DiscReading):
                assert self._sonar is not None  # it was read for it
                view = self._sonar.add(reading, self._track)
            else:
                assert self._mount is not None  # likewise
                view = laser_view(reading, self._mount, self._track)
                self.scans += 1
            if view is not None:
                self.scans += self._sonar is not None
                changed |= self._builder.add(view)
        return changed

    @property
    def has_laser(self) -> bool:
        """Whether it is a laser that sees the map, and not sonar."""
        return self._sonar is None

    @property
    def publish_period(self) -> float:
        """Seconds between two maps on the bus."""
        return self._settings.output.publish_period_s

    @property
    def keys(self) -> list[KeyScan]:
        """The scans that make up the map."""
        return self._builder.keys

    @property
    def is_empty(self) -> bool:
        """Whether nothing has been seen yet."""
        return not self._builder.keys

    def progress(self) -> dict[str, Any]:
        """Return figures for people and programs."""
        builder = self._builder
        return {
            "scans": self.scans,
            "key_scans": len(builder.keys),
            "loops": builder.loops,
            "driven": round(builder.driven, 2),
            "pose": _as_list(builder.pose),
            "odom": _as_list(builder.correction),
        }

    def refine(self) -> None:
        """Improve all poses; takes some seconds for a large map."""
        self._builder.refine()

    def grid(self) -> OccupancyGrid:
        """Return the grid so far.

        Raises:
            ValueError: Nothing has been seen yet.
        """
        return grid_of_evidence(evidence_of(self._builder.keys, self._gatherer))

    def map(self) -> BuildingMap:
        """Return the map so far, with lines.

        Raises:
            ValueError: Nothing has been seen yet.
        """
        if self.is_empty:
            raise ValueError("nothing has been seen yet; drive the robot, and see whether its sensors publish")
        return map_of(self._builder.keys, self._base, self._gatherer, with_lines=self._sonar is None)


def grid_message(grid: OccupancyGrid, stamp: int) -> OccupancyGridMessage:
    """Return a grid as a message; stamp in ns since 1970."""
    rows, columns = grid.cells.shape
    origin = Pose(position=Point(x=grid.origin.x, y=grid.origin.y, z=0.0), orientation=quaternion(grid.origin.heading))
    head: Header = header(stamp, MAP_FRAME)
    loaded: Time = head.stamp
    info = MapMetaData(map_load_time=loaded, resolution=grid.resolution, width=columns, height=rows, origin=origin)
    return OccupancyGridMessage(header=head, info=info, data=np.ascontiguousarray(grid.cells).reshape(-1))


def sensors_of(description: Mapping[str, Any]) -> Sensors:
    """Return where the sensors are, from a robot's description.

    Raises:
        ValueError: It has neither laser nor sonar, or they are not described.
    """
    try:
        rows = {row["name"]: row for row in description["elements"]}
        discs = description.get("geometry", {}).get("sonar", ()) if "sonar" in rows else ()
        found = Sensors(
            _mount(rows["laser"]["geometry"]) if "laser" in rows else None,
            {int(disc["number"]): _mount(disc) for disc in discs},
        )
    except (LookupError, TypeError) as err:
        raise ValueError(f"what {description.get('name')} says of its sensors makes no sense: {err!r}") from err
    if found.laser is None and not found.discs:
        raise ValueError(f"{description.get('name')} has neither a laser nor sonar that could see a map")
    return found


def _mount(place: Mapping[str, Any]) -> Mount:
    return Mount(float(place["x"]), float(place["y"]), float(place["heading"]))


def _as_list(pose: Pose2D) -> list[float]:
    return [round(float(pose.x), 4), round(float(pose.y), 4), round(float(pose.heading), 5)]

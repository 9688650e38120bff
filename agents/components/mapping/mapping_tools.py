"""The work of the mapping agent, in its thread: messages in, map and figures out."""

from collections.abc import Iterable, Mapping
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
from maps.building.surfaces import surface_points
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid

MAP_FRAME = "map"


class MapWork:
    """A map that is being built from the messages of one robot.

    unread: Messages that could not be decoded.
    """

    def __init__(
        self,
        mount: Mount,
        settings: MappingAgentSettings,
        base: BuildingMap | None = None,
        start: Pose2D | None = None,
    ) -> None:
        """Begin.

        Args:
            mount: Of the laser.
            settings: Of the agent.
            base: The map that is extended.
            start: Where the robot is, in `map`; by default the home of the base, or its origin.
        """
        self.unread = 0
        self.scans = 0
        self._mount = mount
        self._settings = settings
        self._base = base
        self._track = OdometryTrack()
        origin = start or (base.home if base is not None else None) or Pose2D()
        surfaces = None if base is None else surface_points(base)
        self._builder = LaserMapBuilder(settings.laser, origin, surfaces)
        self._gatherer = EvidenceGatherer(settings.output.resolution_m)
        self._waiting: list[ScanReading] = []  # for the odometry after them

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
        elif isinstance(message, LaserScan):
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
        """Take the scans for which odometry has come; a newer one takes the place of one that waits in vain."""
        changed = False
        while self._waiting:
            view = laser_view(self._waiting[0], self._mount, self._track)
            if view is None and len(self._waiting) == 1:
                break
            self._waiting.pop(0)
            if view is not None:
                self.scans += 1
                changed |= self._builder.add(view)
        return changed

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
        return map_of(self._builder.keys, self._base, self._gatherer)


def grid_message(grid: OccupancyGrid, stamp: int) -> OccupancyGridMessage:
    """Return a grid as a message; stamp in ns since 1970."""
    rows, columns = grid.cells.shape
    origin = Pose(position=Point(x=grid.origin.x, y=grid.origin.y, z=0.0), orientation=quaternion(grid.origin.heading))
    head: Header = header(stamp, MAP_FRAME)
    loaded: Time = head.stamp
    info = MapMetaData(map_load_time=loaded, resolution=grid.resolution, width=columns, height=rows, origin=origin)
    return OccupancyGridMessage(header=head, info=info, data=np.ascontiguousarray(grid.cells).reshape(-1))


def laser_mount(description: Mapping[str, Any]) -> Mount | None:
    """Return where the laser is, from a robot's description; None without one."""
    for element in description.get("elements", ()):
        if isinstance(element, Mapping) and element.get("name") == "laser":
            place = element["geometry"]
            return Mount(float(place["x"]), float(place["y"]), float(place["heading"]))
    return None


def _as_list(pose: Pose2D) -> list[float]:
    return [round(pose.x, 4), round(pose.y, 4), round(pose.heading, 5)]

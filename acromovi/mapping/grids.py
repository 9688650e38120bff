"""The maps that robots build, as they come on the bus."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from threading import Lock
from typing import Any

import numpy as np

from bus import MessageError, Sample, keys
from bus.bus import Bus, Closeable
from bus.messages import decode, heading
from geometry import Pose2D
from maps.occupancy import OccupancyGrid


class LiveGrids(Closeable):
    """The newest grid of each robot, and where the robot is in it."""

    def __init__(self, bus: Bus, robots: Sequence[str]) -> None:
        self.robots = tuple(robots)
        self.poses: dict[str, Pose2D] = {}
        self.odometry: dict[str, Pose2D] = {}  # frame odom in map
        self._grids: dict[str, OccupancyGrid] = {}
        self._lock = Lock()
        self._open = [bus.subscribe(keys.MAP.key(robot), self._take) for robot in robots]

    def close(self) -> None:
        """End the subscriptions."""
        while self._open:
            self._open.pop().close()

    def note(self, robot: str, state: Mapping[str, Any]) -> None:
        """Take what the mapping agent says of a robot's pose."""
        if state.get("pose") is not None:
            self.poses[robot] = Pose2D(*state["pose"])
            self.odometry[robot] = Pose2D(*state["odom"])

    def grid(self, robot: str) -> OccupancyGrid | None:
        """Return the newest grid; None before the first."""
        with self._lock:
            return self._grids.get(robot)

    def first(self) -> tuple[str, OccupancyGrid | None, dict[str, Pose2D]]:
        """Return the first robot, its grid, and where it is."""
        robot = self.robots[0]
        return robot, self.grid(robot), {robot: self.poses[robot]} if robot in self.poses else {}

    def _take(self, sample: Sample) -> None:
        with suppress(MessageError, ValueError):  # one that cannot be read is missing only
            grid = grid_of_message(decode(sample.type_name, sample.payload))
            with self._lock:
                self._grids[keys.split(sample.key)[0]] = grid


def grid_of_message(message: Any) -> OccupancyGrid:
    """Return the grid of a message.

    Raises:
        ValueError: Its size does not fit its cells.
    """
    info = message.info
    place = info.origin
    cells = np.asarray(message.data, np.int8).reshape(info.height, info.width)
    origin = Pose2D(place.position.x, place.position.y, heading(place.orientation))
    return OccupancyGrid(cells, float(info.resolution), origin)

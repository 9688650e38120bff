"""Where the maps of several robots lie in one frame: found as soon as they show the same rooms."""

from collections.abc import Mapping
from contextlib import suppress

from geometry import Pose2D
from maps.building.merging import NoOverlap, placed
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid

PERIOD = 15.0
"""s between two attempts."""


class CommonFrame:
    """Places maps of robots in the frame of one of them.

    poses: of the maps that have been placed, by robot.
    """

    def __init__(self, first: str) -> None:
        """Begin with the map of one robot."""
        self.poses: dict[str, Pose2D] = {first: Pose2D()}
        self._first = first
        self._looked_at = float("-inf")

    def look(self, now: float, grids: Mapping[str, OccupancyGrid]) -> None:
        """Try to place maps that have not been placed, if the last attempt is long enough ago.

        Args:
            now: s, of any clock.
            grids: Of the robots that have one, that of the first among them.
        """
        others = [robot for robot in grids if robot not in self.poses]
        if not others or now - self._looked_at < PERIOD:
            return
        self._looked_at = now
        base = BuildingMap(grid=grids[self._first])
        for robot in others:
            with suppress(NoOverlap):  # not yet; it is tried again after the next period
                self.poses[robot] = placed(base, BuildingMap(grid=grids[robot])).pose

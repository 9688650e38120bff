"""The map of a building: walls as lines, scanned points, an occupancy grid, and named places."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from configs.suggestion import hint
from geometry.map_file import Cairn, MapFile
from geometry.pose import Pose2D
from geometry.segments import Polygon, Segment
from maps.occupancy import OccupancyGrid

GOAL_KINDS = ("Goal", "GoalWithHeading", "Dock", "RobotHome")
"""Kinds of places that a robot can be sent to; kinds of docks for one model begin with `Dock`."""
FORBIDDEN_LINE, FORBIDDEN_AREA = "ForbiddenLine", "ForbiddenArea"


def _no_points() -> NDArray[np.float64]:
    return np.empty((0, 2))


@dataclass(frozen=True, eq=False)
class BuildingMap:
    """What is known of a floor, in the frame `map`.

    lines: walls, m.
    points: what a laser saw, m, shape (n, 2).
    grid: occupancy grid, or None for a map that consists of lines and points.
    places: goals, docks, homes, forbidden lines and areas; the `Cairn` of ARIA maps.
    info: definitions of kinds of places, as ARIA files have them after `MapInfo:`; kept when a map is written again.
    """

    lines: tuple[Segment, ...] = ()
    points: NDArray[np.float64] = field(default_factory=_no_points, repr=False)
    grid: OccupancyGrid | None = None
    places: tuple[Cairn, ...] = ()
    info: tuple[str, ...] = field(default=(), repr=False)

    @classmethod
    def of_file(cls, file: MapFile, info: tuple[str, ...] = ()) -> "BuildingMap":
        """The map that an ARIA file describes."""
        points = np.array(file.points, np.float64).reshape(-1, 2)
        return cls(file.lines, points, None, file.cairns, info)

    def with_places(self, *places: Cairn) -> "BuildingMap":
        """The same map with more places."""
        return replace(self, places=self.places + places)

    @property
    def home(self) -> Pose2D | None:
        """Where a robot starts: the first `RobotHome`, or None."""
        return next((place.pose for place in self.places if place.kind == "RobotHome"), None)

    @property
    def goals(self) -> tuple[Cairn, ...]:
        """The places that a robot can be sent to by their name, in the order of the file."""
        return tuple(each for each in self.places if each.extent is None and each.name and _is_goal(each.kind))

    def goal(self, name: str) -> Cairn:
        """The goal of that name; upper and lower case are the same where that is unambiguous.

        Raises:
            KeyError: no goal has the name; the message suggests one.
        """
        alike = [goal for goal in self.goals if goal.name.casefold() == name.casefold()]
        found = [goal for goal in alike if goal.name == name] or alike
        if len(found) == 1:
            return found[0]
        names = sorted({goal.name for goal in self.goals})
        if found:
            raise KeyError(f'the map has {len(found)} goals named "{name}"; give the pose instead')
        known = ", ".join(names[:12]) + (" ..." if len(names) > 12 else "")
        raise KeyError(f'the map has no goal "{name}"{hint(name, names) or (f"; it has {known}" if known else "")}')

    @property
    def forbidden_lines(self) -> tuple[Segment, ...]:
        """Lines that no robot may cross, m; the edges of forbidden areas are not among them."""
        return tuple(each.extent for each in self.places if each.kind == FORBIDDEN_LINE and each.extent is not None)

    @property
    def forbidden_areas(self) -> tuple[Polygon, ...]:
        """Corners of areas that no robot may enter, m."""
        return tuple(self._areas())

    def _areas(self) -> Iterator[Polygon]:
        for each in self.places:
            if each.kind == FORBIDDEN_AREA and each.extent is not None:
                x1, y1, x2, y2 = each.extent
                turned = Pose2D(0.0, 0.0, each.pose.heading)  # corners are given before a turn about the map's origin
                yield tuple(turned.transform(x, y) for x, y in ((x1, y1), (x2, y1), (x2, y2), (x1, y2)))

    def is_forbidden(self, x: float, y: float) -> bool:
        """Whether a point (m) is in a forbidden area."""
        return any(_contains(area, x, y) for area in self.forbidden_areas)

    @property
    def bounds(self) -> Segment:
        """The least and the greatest x and y of lines, points and grid: (x_min, y_min, x_max, y_max), m.

        Raises:
            ValueError: the map has neither lines nor points nor a grid.
        """
        ends = [np.array(self.lines, np.float64).reshape(-1, 2), self.points]
        if self.grid is not None:
            width, height = self.grid.width, self.grid.height
            corners = (self.grid.origin.transform(x, y) for x in (0.0, width) for y in (0.0, height))
            ends.append(np.array(list(corners)))
        every = np.concatenate(ends)
        if not len(every):
            raise ValueError("the map is empty: it has neither lines nor points nor a grid")
        return Segment(*every.min(axis=0).tolist(), *every.max(axis=0).tolist())


def _is_goal(kind: str) -> bool:
    return kind in GOAL_KINDS or kind.startswith("Dock")


def _contains(corners: Polygon, x: float, y: float) -> bool:
    """Whether a convex polygon contains a point: it is on one side of all edges."""
    sides = [
        (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)
        for (x1, y1), (x2, y2) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    return all(side >= 0.0 for side in sides) or all(side <= 0.0 for side in sides)

"""Finding how two maps of one building lie, and making one of them.

All turns are tried, each with all shifts at once by a Fourier transform; the best few are then fitted exactly, and
judged by what agrees and by what contradicts: walls of one map where the other has seen free floor.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D
from maps.building.readings import Floats, moved, turned
from maps.building.scan_matching import SurfaceField
from maps.building.surfaces import joined, map_at, surface_points
from maps.building_map import BuildingMap
from maps.distance import distance_transform
from maps.occupancy import OccupancyGrid
from maps.rasterization import grid_of

CELL = 0.12
"""m, of the search."""
TURNS = 180
"""Tried over a full turn."""
TRIED = 12
"""Of the best turns and shifts, fitted exactly."""
LEAST_OVERLAP = 0.25
"""Share of the smaller map that must agree."""
MOST_AGAINST = 0.08
"""Share of walls of one map that may lie where the other has seen free floor."""
ROOM = 0.15
"""m from walls, from where on floor that was seen to be free contradicts a wall."""
PERIOD = 15.0
"""s between two attempts to place the maps of robots that explore."""
UNIQUE = 0.9
"""Score of the next best place, as a share of the best one's, from which on it is not known which is right."""


class NoOverlap(ValueError):
    """Two maps cannot be joined; the message says why."""


@dataclass(frozen=True, slots=True)
class Placement:
    """How the second map lies in the frame of the first.

    agrees: share of its walls that lie on walls of the first. against: share that lies on floor that is free there.
    """

    pose: Pose2D
    agrees: float
    against: float

    @property
    def score(self) -> float:
        """The higher, the better."""
        return self.agrees - 2.0 * self.against


def merged(first: BuildingMap, second: BuildingMap) -> tuple[BuildingMap, Placement]:
    """Make one map of two, in the frame of the first.

    Raises:
        NoOverlap: They do not show the same rooms, or fit in several ways.
    """
    placement = placed(first, second)
    return joined(first, map_at(second, placement.pose)), placement


def placed(first: BuildingMap, second: BuildingMap) -> Placement:
    """Find how the second map lies in the frame of the first.

    Raises:
        NoOverlap: They do not show the same rooms, or fit in several ways.
    """
    points, normals = _known(first)
    theirs, facing = _known(second)
    if min(len(points), len(theirs)) < 50:
        raise NoOverlap("a map with hardly any walls cannot be placed; build it further")
    field = SurfaceField(points, normals, one_sided=False)
    judge = _Judge(first, second, theirs)
    found = []
    for guess in _guesses(points, theirs):
        match = field.align(theirs, facing, guess, coarsest=0.2)
        if match is not None:
            found.append(judge.placement(match.pose, field))
    found.sort(key=lambda each: -each.score)
    if not found or found[0].agrees < LEAST_OVERLAP or found[0].against > MOST_AGAINST:
        share = f"; at best {found[0].agrees:.0%} of the walls agree" if found else ""
        raise NoOverlap(f"the maps do not show the same rooms{share}; let both robots see one room in common")
    others = [each for each in found[1:] if _differ(each.pose, found[0].pose)]
    if others and others[0].score > UNIQUE * found[0].score and others[0].against <= MOST_AGAINST:
        raise NoOverlap("the maps fit in several ways; extend them until they share a room that looks like no other")
    return found[0]


class _Judge:
    """Counts what agrees and what contradicts."""

    def __init__(self, first: BuildingMap, second: BuildingMap, theirs: Floats) -> None:
        self._grids = _open_floor(grid_of(first)), _open_floor(grid_of(second))
        self._theirs = theirs
        self._ours = _known(first)[0]

    def placement(self, pose: Pose2D, field: SurfaceField) -> Placement:
        at = moved(self._theirs, pose)
        nearest = field.nearest(at)
        near = (nearest >= 0) & (np.hypot(*(field.points[nearest] - at).T) < 0.08)
        back = Pose2D().relative_to(pose)
        against = max(
            _on_free(self._grids[0].values_at(at[~near]), len(at)),
            _on_free(self._grids[1].values_at(moved(self._ours, back)), len(self._ours)),
        )
        return Placement(pose, float(near.mean()), against)


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


def _on_free(values: NDArray[np.int8], count: int) -> float:
    return float(np.count_nonzero(values > 0)) / max(1, count)


def _open_floor(grid: OccupancyGrid) -> OccupancyGrid:
    """The free floor that is not beside a wall or an unknown cell, as 100, and all else as 0."""
    free = (grid.cells >= 0) & (grid.cells < 20)
    is_open = distance_transform(~free, grid.resolution, 2.0 * ROOM) > ROOM
    return replace(grid, cells=np.where(is_open, 100, 0).astype(np.int8))


def _known(map_: BuildingMap) -> tuple[Floats, Floats]:
    points, normals = surface_points(map_)
    known = np.isfinite(normals[:, 0])
    return points[known], normals[known]


def _guesses(points: Floats, theirs: Floats) -> list[Pose2D]:
    """Turns and shifts at which most walls lie on each other, best first."""
    middle = (theirs.min(axis=0) + theirs.max(axis=0)) / 2.0
    size = float(np.hypot(*(theirs - middle).T).max())
    low = points.min(axis=0) - size
    columns, rows = (np.ceil((points.max(axis=0) + size - low) / CELL)).astype(np.int64) + 1
    target = np.fft.rfft2(_blurred(_drawn(points, low, (int(rows), int(columns)))))
    found: list[tuple[float, Pose2D]] = []
    for angle in np.arange(TURNS) * 2.0 * np.pi / TURNS:
        about = turned(theirs - middle, angle) + low
        image = _drawn(about, low, (int(rows), int(columns)))  # wraps round, as the transform does
        scores = np.fft.irfft2(target * np.conj(np.fft.rfft2(image)), s=(int(rows), int(columns)))
        for _ in range(2):
            row, column = np.unravel_index(int(np.argmax(scores)), scores.shape)
            shift = low + CELL * np.array([column, row])
            origin = shift - turned(middle[None], angle)[0]
            found.append((float(scores[row, column]), Pose2D(float(origin[0]), float(origin[1]), float(angle))))
            near = np.ix_(np.arange(row - 4, row + 5) % rows, np.arange(column - 4, column + 5) % columns)
            scores[near] = -1.0
    found.sort(key=lambda each: -each[0])
    chosen: list[Pose2D] = []
    for _, pose in found:
        if all(_differ(pose, other) for other in chosen):
            chosen.append(pose)
        if len(chosen) == TRIED:
            break
    return chosen


def _drawn(points: Floats, low: Floats, shape: tuple[int, int]) -> NDArray[np.float64]:
    image = np.zeros(shape)
    at = np.round((points - low) / CELL).astype(np.int64)
    image[at[:, 1] % shape[0], at[:, 0] % shape[1]] = 1.0
    return image


def _blurred(image: NDArray[np.float64]) -> NDArray[np.float64]:
    for axis in (0, 1):
        image = np.maximum(image, 0.6 * np.maximum(np.roll(image, 1, axis), np.roll(image, -1, axis)))
    return image


def _differ(pose: Pose2D, other: Pose2D) -> bool:
    moved_by = pose.relative_to(other)
    return bool(np.hypot(moved_by.x, moved_by.y) > 0.4 or abs(moved_by.heading) > 0.15)

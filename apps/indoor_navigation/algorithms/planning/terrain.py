"""What it costs to go where: dear near obstacles, a little in the unknown, and more where a wall may be expected."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.planning.area import Area, Flags
from apps.indoor_navigation.data import Floats, Place

BARRED = 1e6  # cost of a cell where the robot does not fit
STUCK = 20.0  # likewise, but right where the robot is, so that it finds out
ONTO = 0.15  # m around the robot, beside its own size, where it may be stuck
SAMPLES = 2.0  # to each cell along a line


@dataclass(frozen=True, slots=True)
class CostParameters:
    """Costs are of a metre; 1 on known free floor.

    margin: m that must be left beside the robot. comfort: m beside that where nearness to an obstacle costs something.
    tight: cost added at the margin itself. squeeze: cost added nearer than the margin, as far as cells are too coarse
    to tell whether the robot fits; only where it surely does not, it is barred. unknown: cost where nothing is known.
    off_ways: likewise, once ways are remembered, which are known to lead somewhere. wall: in the unknown beside a door,
    since doors are in walls. hope: where an obstacle is that was not always there, in a search that hopes it will go.
    detour: added where the robot has come no farther lately.
    """

    margin: float
    comfort: float
    tight: float
    squeeze: float
    unknown: float
    off_ways: float
    wall: float
    hope: float
    detour: float


class Strip(NamedTuple):
    """A straight strip of floor, from one place to another, so many m wide to each side."""

    start: Place
    end: Place
    half_width: float


@dataclass(frozen=True, slots=True)
class Hints:
    """What is known beside what was seen: ways that were gone before, where walls must be, where it went on no more."""

    ways: tuple[Strip, ...] = ()
    walls: tuple[Strip, ...] = ()
    avoided: tuple[Strip, ...] = ()


NO_HINTS = Hints()


class Terrain(NamedTuple):
    """Cost of a metre in each cell of an area, BARRED where the robot does not fit."""

    area: Area
    cost: Floats

    def is_barred(self, x: float, y: float) -> bool:
        """Whether the robot cannot be there."""
        row, column = self.area.cell(x, y)
        height, width = self.cost.shape
        return 0 <= row < height and 0 <= column < width and bool(self.cost[row, column] >= BARRED)

    def cost_of(self, *points: Place) -> float:
        """Of a line of points; BARRED or more where it leads through what is barred."""
        return float(self.costs_of_pieces(points).sum())

    def cost_between(self, start: Place, end: Place) -> float:
        """Of a straight line within the area; BARRED or more where it leads through what is barred."""
        x, y, resolution = self.area.x, self.area.y, self.area.resolution
        dx, dy = end[0] - start[0], end[1] - start[1]
        whole = hypot(dx, dy)
        count = max(1, ceil(whole * SAMPLES / resolution))
        parts = (np.arange(count) + 0.5) * (1.0 / (count * resolution))
        columns = ((start[0] - x) / resolution + dx * parts).astype(np.intp)
        rows = ((start[1] - y) / resolution + dy * parts).astype(np.intp)
        costs = self.cost[rows, columns]
        return float(costs.sum()) * whole / count if costs.max() < BARRED else BARRED

    def costs_of_pieces(self, points: Sequence[Place]) -> Floats:
        """Of each straight piece of a line of points; BARRED or more for one that leads through what is barred."""
        line = _sampled(np.asarray(points, np.float64), self.area.resolution)
        costs = self._costs(line.places)
        pieces: Floats = np.bincount(line.pieces, line.lengths * costs, len(points) - 1).astype(np.float64)
        barred = np.bincount(line.pieces, costs >= BARRED, len(points) - 1) > 0.0
        return pieces + np.where(barred, BARRED, 0.0)

    def first_barred(self, points: Sequence[Place]) -> float | None:
        """How far along a line it is barred, m; None where it is not."""
        line = _sampled(np.asarray(points, np.float64), self.area.resolution)
        barred = np.flatnonzero(self._costs(line.places) >= BARRED)
        return float(line.lengths[: barred[0]].sum()) if len(barred) else None

    def _costs(self, places: Floats) -> Floats:
        columns = np.floor((places[:, 0] - self.area.x) / self.area.resolution).astype(np.intp)
        rows = np.floor((places[:, 1] - self.area.y) / self.area.resolution).astype(np.intp)
        height, width = self.cost.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        costs = np.ones(len(places))
        costs[inside] = self.cost[rows[inside], columns[inside]]
        return costs


def terrain(
    area: Area,
    half_width: float,
    parameters: CostParameters,
    *,
    hints: Hints = NO_HINTS,
    robot: Place | None = None,
    hopes: float | None = None,
) -> Terrain:
    """Judge an area.

    Args:
        area: What was seen.
        half_width: Of the robot, m.
        parameters: What is how dear.
        hints: What is known beside.
        robot: Where it is: however near obstacles seem, it can leave that place.
        hopes: Bar only walls; something else that is in the way may go, and costs so much.
    """
    occupied = area.occupied
    standing = occupied if hopes is None else area.walls
    narrow = half_width + parameters.margin
    cost = np.where(area.unknown, parameters.off_ways if hints.ways else parameters.unknown, 1.0)
    for way in hints.ways:
        _lay(cost, area, way, area.unknown, 1.0)
    for wall in hints.walls:
        _lay(cost, area, wall, area.unknown, parameters.wall)
    for avoided in hints.avoided:
        _lay(cost, area, avoided, None, parameters.detour)
    cost += _nearness(standing, narrow, parameters, area.resolution)
    if hopes is not None:
        barred = _squared(narrow - area.resolution, area.resolution)
        in_the_way = clearance_squared(occupied, narrow, area.resolution) <= barred
        cost[in_the_way] += hopes
    if robot is not None:
        _let_out(cost, area, robot, narrow + ONTO)
    np.minimum(cost, BARRED, out=cost)
    return Terrain(area, cost)


def covered(area: Area, strips: Iterable[Strip]) -> Flags:
    """The cells of some strips."""
    onto = np.zeros(area.evidence.shape)
    for strip in strips:
        _lay(onto, area, strip, None, 1.0)
    return np.asarray(onto > 0.0)


def clearance_squared(occupied: Flags, farthest: float, resolution: float) -> NDArray[np.int16]:
    """For each cell, squared distance to the nearest occupied one, in cells, exact up to `farthest` m, and more beyond.

    First the distance within each row, by what was occupied last from either side; then the nearest over the rows.
    """
    reach = ceil(farthest / resolution) + 1
    width = occupied.shape[1]
    columns = np.arange(width)
    last = np.maximum.accumulate(np.where(occupied, columns, -2 * reach), axis=1)
    following = np.minimum.accumulate(np.where(occupied, columns, width + 2 * reach)[:, ::-1], axis=1)[:, ::-1]
    in_row = np.minimum(np.minimum(columns - last, following - columns), reach).astype(np.int16) ** 2
    nearest = in_row.copy()
    for away in range(1, min(reach, len(in_row) - 1) + 1):
        np.minimum(nearest[away:], in_row[:-away] + np.int16(away**2), out=nearest[away:])
        np.minimum(nearest[:-away], in_row[away:] + np.int16(away**2), out=nearest[:-away])
    return nearest


def _nearness(standing: Flags, narrow: float, parameters: CostParameters, resolution: float) -> Floats:
    """Cost for being near to obstacles."""
    wide = narrow + parameters.comfort
    squared = clearance_squared(standing, wide, resolution)
    distance = np.sqrt(np.arange(int(squared.max(initial=0)) + 1)) * resolution
    lacking = np.clip((wide - distance) / parameters.comfort, 0.0, 1.0)
    table = parameters.tight * lacking**2
    table[: _squared(narrow, resolution) + 1] += parameters.squeeze
    table[: _squared(narrow - resolution, resolution) + 1] = BARRED
    return np.asarray(table[squared])


def _squared(distance: float, resolution: float) -> int:
    """Squared cells within a distance, m."""
    return int((max(distance, 0.0) / resolution) ** 2 + 1e-9)


def _lay(cost: Floats, area: Area, strip: Strip, where: Flags | None, value: float) -> None:
    """Give the cells of a strip a cost where they are flagged; add it where there are no flags."""
    part = area.around(strip.start, strip.end, margin=strip.half_width)
    height, width = part.evidence.shape
    if not height or not width:
        return
    row, column = area.cell(*part.place(0, 0))
    here = slice(row, row + height), slice(column, column + width)
    x = part.x + (np.arange(width, dtype=np.float64) + 0.5) * part.resolution
    y = (part.y + (np.arange(height, dtype=np.float64) + 0.5) * part.resolution)[:, None]
    within = _distance(x, y, strip) <= strip.half_width
    if where is None:
        cost[here][within] += value
    else:
        cost[here][within & where[here]] = value


def _distance(x: Floats, y: Floats, strip: Strip) -> Floats:
    """From a strip's middle line, m."""
    (start_x, start_y), (end_x, end_y) = strip.start, strip.end
    dx, dy = end_x - start_x, end_y - start_y
    length = hypot(dx, dy)
    if length == 0.0:
        return np.hypot(x - start_x, y - start_y)
    along = np.clip(((x - start_x) * dx + (y - start_y) * dy) / length**2, 0.0, 1.0)
    return np.hypot(x - start_x - along * dx, y - start_y - along * dy)


def _let_out(cost: Floats, area: Area, robot: Place, radius: float) -> None:
    """Where the robot is, it cannot be barred."""
    cost[covered(area, [Strip(robot, robot, radius)]) & (cost >= BARRED)] = STUCK


class _Samples(NamedTuple):
    """Short bits of a line: their middles, their lengths, m, and of which straight piece they are."""

    places: Floats
    lengths: Floats
    pieces: NDArray[np.intp]


def _sampled(points: Floats, resolution: float) -> _Samples:
    starts, ways = points[:-1], np.diff(points, axis=0)
    lengths = np.hypot(ways[:, 0], ways[:, 1])
    counts = np.maximum(np.ceil(lengths * SAMPLES / resolution), 1.0).astype(np.intp)
    pieces = np.repeat(np.arange(len(counts)), counts)
    indices = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)
    parts = (indices + 0.5) / counts[pieces]
    return _Samples(starts[pieces] + parts[:, None] * ways[pieces], (lengths / counts)[pieces], pieces)

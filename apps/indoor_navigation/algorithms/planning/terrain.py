"""Costs of the floor: high near obstacles, a little above 1 in the unknown, and higher where a wall is expected."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, hypot
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import Area, Singles
from apps.indoor_navigation.data import Bools, Floats, Ints, Place

BARRED = 1e6  # cost of a metre where the robot does not fit; no way that is free costs as much
START_COST = 20.0  # likewise, but at the robot's place, so that a way out can be found
START_MARGIN = 0.15  # m around the robot where this cost applies, beside the half width; grid cells are coarse
ROUNDING = 1e-6  # m, of distances
SAMPLES = 2.0  # of a line per cell, so that it does not miss a corner of a cell


@dataclass(frozen=True, slots=True)
class CostParameters:
    """Costs of a metre; known free floor costs 1.

    comfort: m beside the robot within which an obstacle adds cost. tight: cost added where the robot touches it.
    narrow: m beside the robot, within which `squeeze` is added besides, less with more room, because there the robot
    must drive slowly and exactly. unknown: cost of unknown floor. off_ways: likewise, once ways are remembered, because
    these are known to lead somewhere. wall: cost of unknown floor beside a door, because doors are in walls. hope: cost
    added at an obstacle that may go away. person: likewise, at what may be a person far away. detour: likewise, where
    the robot was stuck lately.
    """

    comfort: float
    tight: float
    narrow: float
    squeeze: float
    unknown: float
    off_ways: float
    wall: float
    hope: float
    person: float
    detour: float


class Strip(NamedTuple):
    """A straight strip of floor from one place to another. half_width: m to each side."""

    start: Place
    end: Place
    half_width: float


@dataclass(frozen=True, slots=True)
class Hints:
    """Knowledge beside the grid: ways of earlier missions, expected walls, and places where the robot was stuck."""

    ways: tuple[Strip, ...] = ()
    walls: tuple[Strip, ...] = ()
    avoided: tuple[Strip, ...] = ()


NO_HINTS = Hints()


class Terrain(NamedTuple):
    """The cost of a metre in each cell of an area; BARRED where the robot does not fit."""

    area: Area
    cost: Floats

    def is_barred(self, x: float, y: float) -> bool:
        """Return whether the robot does not fit at a place."""
        row, column = self.area.cell(x, y)
        height, width = self.cost.shape
        return 0 <= row < height and 0 <= column < width and bool(self.cost[row, column] >= BARRED)

    def cost_of(self, *points: Place) -> float:
        """Return the cost of a polyline; BARRED or more where a cell is barred."""
        return float(self.costs_of_pieces(points).sum())

    def cost_between(self, start: Place, end: Place) -> float:
        """Return the cost of a straight line within the area; BARRED or more where a cell is barred."""
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
        """Return the cost of each piece of a polyline; BARRED or more for a piece with a barred cell."""
        line = _sampled(np.asarray(points, np.float64), self.area.resolution)
        costs = self._costs(line.places)
        pieces: Floats = np.bincount(line.pieces, line.lengths * costs, len(points) - 1).astype(np.float64)
        barred = np.bincount(line.pieces, costs >= BARRED, len(points) - 1) > 0.0
        return pieces + np.where(barred, BARRED, 0.0)

    def first_barred(self, points: Sequence[Place]) -> float | None:
        """Return the distance along a polyline to the first barred cell, m; None where there is none."""
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


def terrain(area: Area, half_width: float, parameters: CostParameters, *, robot: Place | None = None) -> Terrain:
    """Return the costs of an area for a robot of any heading: those for the room to either side of it.

    Args:
        area: The grid.
        half_width: Of the robot, m.
        parameters: The costs.
        robot: Its place, which is never barred, however near obstacles seem.
    """
    room = distances(area.occupied, half_width + parameters.comfort, area.resolution) - half_width
    cost = floor_costs(area, parameters) + nearness(room, parameters, area.resolution)
    cost[area.occupied] = BARRED
    if robot is not None:
        near = covered(area, [Strip(robot, robot, half_width + START_MARGIN)])
        cost[near & (cost >= BARRED)] = START_COST
    return Terrain(area, cost)


def floor_costs(area: Area, parameters: CostParameters, hints: Hints = NO_HINTS) -> Floats:
    """Return the costs of an area without those of nearness to obstacles."""
    cost = np.where(area.unknown, parameters.off_ways if hints.ways else parameters.unknown, 1.0)
    for way in hints.ways:
        _lay(cost, area, way, area.unknown, 1.0)
    for wall in hints.walls:
        _lay(cost, area, wall, area.unknown, parameters.wall)
    for avoided in hints.avoided:
        _lay(cost, area, avoided, None, parameters.detour)
    return cost


def nearness(room: Floats, parameters: CostParameters, inaccuracy: float | Floats) -> Floats:
    """Return the cost added for the room between the robot and the nearest obstacle.

    Args:
        room: m; negative where the robot would be in the obstacle.
        parameters: The costs.
        inaccuracy: m of negative room that may come from the cells of the grid; no more room is barred.
    """
    cost = parameters.tight * np.maximum(1.0 - room / parameters.comfort, 0.0) ** 2
    cost += parameters.squeeze * np.maximum(1.0 - room / parameters.narrow, 0.0)
    return np.asarray(np.where(room < ROUNDING - inaccuracy, BARRED, cost))


def covered(area: Area, strips: Iterable[Strip]) -> Bools:
    """Return the cells of some strips."""
    onto = np.zeros(area.evidence.shape)
    for strip in strips:
        _lay(onto, area, strip, None, 1.0)
    return np.asarray(onto > 0.0)


def distances(
    occupied: Bools, farthest: float, resolution: float, surfaces: tuple[Singles, Singles] | None = None
) -> Floats:
    """Return the distance of the middle of each cell from the nearest occupied cell, m; exact to `farthest`.

    First the distance within each row, from the last occupied cell on either side; then the minimum over the rows.

    Args:
        occupied: Flags of the cells, in rows.
        farthest: m; cells that are farther away have any greater distance.
        resolution: Edge of a cell, m.
        surfaces: x and y from the middle of each cell to what is in it, m; by default the middle itself.
    """
    reach = ceil(farthest / resolution) + 1
    width = occupied.shape[1]
    columns = np.arange(width)
    left = columns - np.maximum.accumulate(np.where(occupied, columns, -2 * reach), axis=1)
    right = np.minimum.accumulate(np.where(occupied, columns, width + 2 * reach)[:, ::-1], axis=1)[:, ::-1] - columns
    squared = np.minimum(np.minimum(left, right), reach).astype(np.int32) ** 2
    if surfaces is None:
        nearest = _least_over_rows(squared.astype(np.min_scalar_type(-2 * reach**2 - 1)), reach, 1, 0)
        return np.asarray(np.sqrt(np.arange(int(nearest.max(initial=0)) + 1)) * resolution)[nearest]
    # The rows and columns to the nearest cell, each up to `reach` in either sense, are kept as two low digits of its
    # squared distance, in numbers that are wide enough.
    base = 2 * reach + 1
    aside = np.clip(np.where(left <= right, -left, right), -reach, reach)
    numbers = squared.astype(np.min_scalar_type(-(2 * reach**2 + 1) * base**2)) * base**2
    numbers += (aside + (base + 1) * reach).astype(numbers.dtype)
    nearest = _least_over_rows(numbers, reach, base**2, base)
    away = np.full(occupied.shape, reach * resolution)
    row, column = np.nonzero(nearest < reach**2 * base**2)
    found = nearest[row, column] % base**2
    up, right = found // base - reach, found % base - reach
    at = row + up, column + right
    away[row, column] = np.hypot(right * resolution + surfaces[0][at], up * resolution + surfaces[1][at])
    return away


def _least_over_rows(in_row: Ints, reach: int, square: int, row: int) -> Ints:
    """Return the least sum of a value of some row and the square of the rows up to there, in these units."""
    nearest = in_row.copy()
    for away in range(1, min(reach, len(in_row) - 1) + 1):
        further = away**2 * square
        np.minimum(nearest[away:], in_row[:-away] + in_row.dtype.type(further - away * row), out=nearest[away:])
        np.minimum(nearest[:-away], in_row[away:] + in_row.dtype.type(further + away * row), out=nearest[:-away])
    return nearest


def _lay(cost: Floats, area: Area, strip: Strip, where: Bools | None, value: float) -> None:
    """Set the cost of the flagged cells of a strip; without flags, add it to all its cells."""
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
    """Return the distance from the middle line of a strip, m."""
    (start_x, start_y), (end_x, end_y) = strip.start, strip.end
    dx, dy = end_x - start_x, end_y - start_y
    length = hypot(dx, dy)
    if length == 0.0:
        return np.hypot(x - start_x, y - start_y)
    along = np.clip(((x - start_x) * dx + (y - start_y) * dy) / length**2, 0.0, 1.0)
    return np.hypot(x - start_x - along * dx, y - start_y - along * dy)


class _Samples(NamedTuple):
    """Samples of a polyline: their middles, lengths in m, and the indices of their pieces."""

    places: Floats
    lengths: Floats
    pieces: Ints


def _sampled(points: Floats, resolution: float) -> _Samples:
    starts, ways = points[:-1], np.diff(points, axis=0)
    lengths = np.hypot(ways[:, 0], ways[:, 1])
    counts = np.maximum(np.ceil(lengths * SAMPLES / resolution), 1.0).astype(np.intp)
    pieces = np.repeat(np.arange(len(counts)), counts)
    indices = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)
    parts = (indices + 0.5) / counts[pieces]
    return _Samples(starts[pieces] + parts[:, None] * ways[pieces], (lengths / counts)[pieces], pieces)

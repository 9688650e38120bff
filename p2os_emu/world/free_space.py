"""The floor that is left to a disc of some radius: which places it can stand on, and which straight ways it can go.

What stands still is a box, or a cylinder, which is a box of no size; a disc passes it when its middle stays as far from
the box as both their radii together.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import cos, inf, pi, sin

import numpy as np
from numpy.typing import NDArray

from geometry import Point, Pose2D
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.moving_doors import LEAF_THICKNESS, MovingDoor
from p2os_emu.world.spec import Block, WorldSpec

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

TURNS = 3
"""Vertices of the line that goes round a corner of 90 degrees: at 0.4 m, it is 1.5 cm longer than the true arc."""
_ROUNDING = 1e-6  # m
_UNKNOWN = -1


class FreeSpace:
    """Free space for a disc."""

    def __init__(self, spec: WorldSpec, radius: float, shut: Iterable[str] = (), *, height: float = inf) -> None:
        """Prepare a world as it begins, without people.

        Args:
            spec: Walls, furniture, drops and objects are in the way; of moving doors only the ones that are shut.
            radius: Of the disc, m.
            shut: Names of moving doors.
            height: Of the robot that the disc stands for, m; it passes below blocks that begin higher. Without it, all
                blocks are in the way.
        """
        boxes = [_box(block) for block in _uncovered([*spec.walls, *spec.furniture, *spec.drops], height)]
        boxes += [_object_box(movable) for movable in spec.objects]
        shut = set(shut)
        boxes += [_leaf_box(door) for door in spec.moving_doors if door.name in shut]
        table = np.array(boxes, np.float64).reshape(-1, 6)
        self._middles, self._halves = table[:, :2], table[:, 3:5]
        self._margins = table[:, 5] + radius
        self._reaches = np.hypot(*self._halves.T) + self._margins
        self._cosines, self._sines = np.cos(table[:, 2]), np.sin(table[:, 2])
        self._known: dict[int, NDArray[np.int8]] = {}
        self.corners = self._free_corners()
        """Where shortest ways turn: round the corners of everything, m, shape (n, 2)."""

    def is_free(self, place: Point) -> bool:
        """Return whether the disc can stand with its middle at a place, m."""
        return bool(self.are_free(np.array([place]))[0])

    def are_free(self, places: Floats) -> Bools:
        """Likewise for many places, shape (n, 2)."""
        along, across = self._local(places)
        out = np.hypot(_beyond(along, self._halves[:, 0]), _beyond(across, self._halves[:, 1]))
        free: Bools = np.all(out >= self._margins - _ROUNDING, axis=1)
        return free

    def reachable(self, start: Point, ends: Floats) -> Bools:
        """Tell to which of many places the disc can go straight from a start where it is free."""
        ways, boxes = self._near_ways(start, ends)
        ax, ay = self._local(np.array([start]))
        x, y = (ends[ways] - self._middles[boxes]).T
        cosines, sines = self._cosines[boxes], self._sines[boxes]
        bx, by = cosines * x + sines * y, cosines * y - sines * x
        distances = _distances(ax[0, boxes], ay[0, boxes], bx, by, self._halves[boxes])
        free = np.ones(len(ends), np.bool_)
        free[ways[distances < self._margins[boxes] - _ROUNDING]] = False
        return free

    def _near_ways(self, start: Point, ends: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Straight ways and boxes that may meet: pairs of indices."""
        steps = ends - start
        lengths = np.maximum(np.hypot(*steps.T), 1e-12)
        steps = steps / lengths[:, np.newaxis]
        to_boxes = self._middles - start
        reaches = self._reaches + _ROUNDING
        along = steps @ to_boxes.T
        beside = np.abs(steps @ np.stack((to_boxes[:, 1], -to_boxes[:, 0])))
        near = (beside < reaches) & (along > -reaches) & (along < lengths[:, np.newaxis] + reaches)
        ways, boxes = np.nonzero(near)
        return ways, boxes

    def reachable_corners(self, corner: int, others: NDArray[np.int64]) -> Bools:
        """Tell which of many corners the disc can reach straight from a corner; remembered."""
        known = self._known.setdefault(corner, np.full(len(self.corners), _UNKNOWN, np.int8))
        unknown = others[known[others] == _UNKNOWN]
        if len(unknown):
            x, y = self.corners[corner]
            known[unknown] = self.reachable((x, y), self.corners[unknown])
        free: Bools = known[others] == 1
        return free

    def has_way(self, points: Sequence[Point]) -> bool:
        """Return whether the disc can go straight from each place to the next."""
        return all(self.reachable(a, np.array([b]))[0] for a, b in pairwise(points))

    def _local(self, places: Floats) -> tuple[Floats, Floats]:
        """Places as each box sees them: along its length and across, shape (places, boxes)."""
        x = places[:, :1] - self._middles[:, 0]
        y = places[:, 1:] - self._middles[:, 1]
        return self._cosines * x + self._sines * y, self._cosines * y - self._sines * x

    def _free_corners(self) -> Floats:
        reach = self._margins / cos(pi / 4 / TURNS)
        corners = []
        for along in (1, -1):
            for across in (1, -1):
                for turn in (np.arange(TURNS) + 0.5) * pi / 2 / TURNS:
                    x = along * (self._halves[:, 0] + reach * cos(turn))
                    y = across * (self._halves[:, 1] + reach * sin(turn))
                    corners.append(
                        self._middles
                        + np.stack((self._cosines * x - self._sines * y, self._sines * x + self._cosines * y), axis=1)
                    )
        everywhere = np.concatenate(corners)
        return everywhere[self.are_free(everywhere)]


def _uncovered(blocks: Sequence[Block], height: float) -> list[Block]:
    """The blocks that a robot of some height meets, without those that lie below another of them: legs of tables."""
    met = [block for block in blocks if block.bottom < height]
    tops = [block for block in met if block.bottom > 0.0]
    return [block for block in met if not any(_covers(top, block) for top in tops)]


def _covers(top: Block, block: Block) -> bool:
    if top is block or abs(top.x - block.x) + abs(top.y - block.y) > top.length + top.width:
        return False
    pose = Pose2D(top.x, top.y, top.heading)
    half_x, half_y = top.length / 2 + _ROUNDING, top.width / 2 + _ROUNDING
    corners = [pose.locate(x, y) for x, y in block.footprint]
    is_same = all(abs(abs(x) - half_x) < 2 * _ROUNDING and abs(abs(y) - half_y) < 2 * _ROUNDING for x, y in corners)
    return not is_same and all(abs(x) <= half_x and abs(y) <= half_y for x, y in corners)


def _box(block: Block) -> tuple[float, ...]:
    return block.x, block.y, block.heading, block.length / 2, block.width / 2, 0.0


def _object_box(movable: Movable) -> tuple[float, ...]:
    pose = movable.pose
    if movable.shape is Shape.CYLINDER:
        return pose.x, pose.y, 0.0, 0.0, 0.0, movable.length / 2
    return pose.x, pose.y, pose.heading, movable.length / 2, movable.width / 2, 0.0


def _leaf_box(door: MovingDoor) -> tuple[float, ...]:
    (x1, y1), (x2, y2) = door.jamb, door.post
    return (x1 + x2) / 2, (y1 + y2) / 2, door.frame.heading, door.width / 2, LEAF_THICKNESS / 2, 0.0


def _beyond(value: Floats, half: Floats) -> Floats:
    """How far something is outside of -half to half."""
    beyond: Floats = np.maximum(np.abs(value) - half, 0.0)
    return beyond


def _distances(ax: Floats, ay: Floats, bx: Floats, by: Floats, halves: Floats) -> Floats:
    """From straight ways a to b to boxes about the origin, one each, m: 0 where they cross."""
    half_x, half_y = halves[:, 0], halves[:, 1]
    to_start = np.hypot(_beyond(ax, half_x), _beyond(ay, half_y))
    to_end = np.hypot(_beyond(bx, half_x), _beyond(by, half_y))
    nearest = np.minimum(to_start, to_end)
    for x, y in ((half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y)):
        nearest = np.minimum(nearest, _to_point(x - ax, y - ay, bx - ax, by - ay))
    enter_x, leave_x = _slab(ax, bx - ax, half_x)
    enter_y, leave_y = _slab(ay, by - ay, half_y)
    crosses = np.maximum(np.maximum(enter_x, enter_y), 0.0) <= np.minimum(np.minimum(leave_x, leave_y), 1.0)
    return np.where(crosses, 0.0, nearest)


def _to_point(x: Floats, y: Floats, dx: Floats, dy: Floats) -> Floats:
    """From a way that begins at the origin and ends at (dx, dy) to (x, y), m."""
    squared = np.maximum(dx * dx + dy * dy, 1e-12)
    share = np.clip((x * dx + y * dy) / squared, 0.0, 1.0)
    distance: Floats = np.hypot(x - share * dx, y - share * dy)
    return distance


def _slab(start: Floats, way: Floats, half: Floats) -> tuple[Floats, Floats]:
    """Shares of the way at which it comes between -half and half, and leaves again; never, where the first is inf."""
    runs_along = np.abs(way) < 1e-12
    safe = np.where(runs_along, 1.0, way)
    one, other = (-half - start) / safe, (half - start) / safe
    inside = np.abs(start) <= half
    enter = np.where(runs_along, np.where(inside, -np.inf, np.inf), np.minimum(one, other))
    leave = np.where(runs_along, np.inf, np.maximum(one, other))
    return enter, leave

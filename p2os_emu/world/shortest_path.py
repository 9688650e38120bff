"""The shortest way for a disc through what stands still in a world: what missions are measured against.

Shortest ways are straight but where they turn round a corner, so the search (A*) knows no grid: it goes from corner to
corner. What it finds is at most a few centimetres longer than the truth for each corner.
"""

from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import pairwise
from math import dist, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry import Point
from p2os_emu.world.free_space import Floats, FreeSpace
from p2os_emu.world.spec import WorldSpec

_NO_PART = -1


class Path(NamedTuple):
    """A way: its corners, m, with both ends."""

    points: tuple[Point, ...]

    @property
    def length(self) -> float:
        """Of the whole way, m."""
        return sum(dist(a, b) for a, b in pairwise(self.points))


def shortest_path(
    spec: WorldSpec, start: Point, goal: Point, radius: float, *, shut: Sequence[str] = (), height: float = inf
) -> Path | None:
    """Find the shortest way for a disc.

    Args:
        spec: The world; people and open doors are not in the way.
        start, goal: Where its middle begins and ends, m.
        radius: Of the disc, m.
        shut: Names of moving doors that are.
        height: Of the robot that the disc stands for, m; it passes below blocks that begin higher.
    Returns:
        None where there is no way, or where the disc does not fit an end.
    """
    return path_in(FreeSpace(spec, radius, shut, height=height), start, goal)


def path_in(space: FreeSpace, start: Point, goal: Point) -> Path | None:
    """Likewise in a space that has been prepared, for those who ask often."""
    if not (space.is_free(start) and space.is_free(goal)):
        return None
    places = np.concatenate(([start, goal], space.corners))
    to_goal = np.hypot(*(places - goal).T)
    lengths = np.full(len(places), np.inf)
    lengths[0] = 0.0
    before = np.zeros(len(places), np.int64)
    is_open = np.ones(len(places), np.bool_)
    queue = [(to_goal[0], 0)]
    while queue:
        here = heappop(queue)[1]
        if here == 1:
            return Path(_traced(places, before))
        if not is_open[here]:
            continue
        is_open[here] = False
        through = lengths[here] + np.hypot(*(places - places[here]).T)
        better = np.flatnonzero(is_open & (through < lengths))
        for near in better[_reached(space, places, here, better)]:
            lengths[near], before[near] = through[near], here
            heappush(queue, (through[near] + to_goal[near], int(near)))
    return None


def _reached(space: FreeSpace, places: Floats, here: int, others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which places can be reached straight from one of them: start (0), goal (1), and then the corners."""
    if here == 0:
        return space.reachable((places[0][0], places[0][1]), places[others])
    reached = np.zeros(len(others), np.bool_)
    are_corners = others > 1
    reached[are_corners] = space.reachable_corners(here - 2, others[are_corners] - 2)
    if not are_corners.all():
        reached[~are_corners] = space.reachable((places[here][0], places[here][1]), places[1:2])
    return reached


def are_connected(space: FreeSpace, places: Sequence[Point]) -> bool:
    """Return whether a disc gets from every place to every other.

    From each place the search spreads to a part of the space, until all parts have met or one can grow no more.
    """
    if not all(space.is_free(place) for place in places):
        return False
    nodes = np.concatenate((np.array(places), space.corners))
    parts = np.full(len(nodes), _NO_PART)
    parts[: len(places)] = np.arange(len(places))
    queues = {number: [number] for number in range(len(places))}
    while len(queues) > 1:
        number = min(queues, key=lambda each: (np.count_nonzero(parts == each), each))  # a closet is soon known
        queue = queues[number]
        if not queue:
            return False
        missing = nodes[: len(places)][parts[: len(places)] != number]
        x, y = nodes[queue, :, np.newaxis].transpose(1, 0, 2) - missing.T[:, np.newaxis]
        here = nodes[queue.pop(int(np.hypot(x, y).min(axis=1).argmin()))]  # the nearest to a place of another part
        others = np.flatnonzero(parts != number)
        found = others[space.reachable((here[0], here[1]), nodes[others])]
        queue += found[parts[found] == _NO_PART].tolist()
        for met in set(parts[found].tolist()) - {_NO_PART}:
            queue += queues.pop(met)
            parts[parts == met] = number
        parts[found] = number
    return True


def _traced(places: Floats, before: NDArray[np.int64]) -> tuple[Point, ...]:
    """The places from start (0) to goal (1)."""
    way = [1]
    while way[-1] != 0:
        way.append(int(before[way[-1]]))
    return tuple((float(places[i][0]), float(places[i][1])) for i in reversed(way))

"""Rays in one plane above the floor, all at once: what planar sensors see, without asking the physics engine.

The world is cut at the sensor's height: what ends below it, begins above it or is made of glass is not seen. What is
left are edges: those of blocks, prepared once, and those of robots and objects, as they stand at this step. Of these
only the ones count that face the sensor, lie within its reach, and cross the sector of some beam; each such pair of
beam and edge is one division.
"""

from collections.abc import Callable, Iterable, Sequence
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry import Polygon, Pose2D
from p2os_emu.body import Echoes, ScanBeams
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.spec import Block

Floats = NDArray[np.float64]

_ROUNDING = 1e-9  # of a beam; where two edges meet, a beam must not slip between them


class Edges(NamedTuple):
    """Edges of outlines that run counter-clockwise, each array of shape (n,).

    x, y: where they start, m. along_x, along_y: from there to where they end, m. lengths: m. reflects: of the surfaces.
    owners: whose they are, -1 for what stands still.
    """

    x: Floats
    y: Floats
    along_x: Floats
    along_y: Floats
    lengths: Floats
    reflects: NDArray[np.bool_]
    owners: NDArray[np.int64]


class PlanarScene:
    """Everything in one world that a planar sensor can meet."""

    def __init__(self, blocks: Iterable[Block], moving: Callable[[], Sequence[MovingObject]]) -> None:
        """Prepare what stands still.

        Args:
            blocks: What stands still.
            moving: What may be elsewhere after the next step; the same object as long as nothing has moved.
        """
        self._blocks = tuple(blocks)
        self._moving = moving
        self._still: dict[float, Edges] = {}
        self._cut: dict[float, tuple[Sequence[MovingObject], Edges]] = {}  # all edges, and what moves of them

    def cast(self, beams: ScanBeams, pose: Pose2D, own: str) -> Echoes:
        """Follow beams to the first surface.

        Args:
            beams: Together they span a full turn at most; one step or more between two, in either sense.
            pose: Of the robot that they are given in.
            own: Name of that robot; it does not see itself.
        """
        x, y = pose.transform(beams.x, beams.y)
        first, step = pose.heading + beams.first, beams.step
        rises = step > 0
        if not rises:
            first, step = first + step * (beams.count - 1), -step
        edges, index = self._edges(beams.height, own)
        echoes = _cast(edges, index, x, y, first, step, beams.count, beams.reach)
        return echoes if rises else echoes.reversed()

    def _edges(self, height: float, own: str) -> tuple[Edges, int]:
        """Return all edges at a height, and the owner of those of a robot; -2 if it has none."""
        still = self._still.get(height)
        if still is None:
            cut = [
                (block.footprint, block.reflector, -1)
                for block in self._blocks
                if block.crosses(height) and not block.glass
            ]
            still = self._still[height] = _edges(cut)
        moving = self._moving()
        known, edges = self._cut.get(height, (None, still))
        if known is not moving:
            cut = [
                (each.footprint, each.reflector, index)
                for index, each in enumerate(moving)
                if each.bottom <= height <= each.top
            ]
            edges = Edges(*(np.concatenate((a, b)) for a, b in zip(still, _edges(cut), strict=True)))
            self._cut[height] = moving, edges
        return edges, next((index for index, each in enumerate(moving) if each.name == own), -2)


def _edges(outlines: Sequence[tuple[Polygon, bool, int]]) -> Edges:
    starts = [corner for outline, _, _ in outlines for corner in outline]
    ends = [corner for outline, _, _ in outlines for corner in (*outline[1:], outline[0])]
    sizes = [len(outline) for outline, _, _ in outlines]
    x, y = np.array(starts, np.float64).reshape(-1, 2).T.copy()
    end_x, end_y = np.array(ends, np.float64).reshape(-1, 2).T
    return Edges(
        x,
        y,
        end_x - x,
        end_y - y,
        np.hypot(end_x - x, end_y - y),
        np.repeat(np.array([reflects for _, reflects, _ in outlines], np.bool_), sizes),
        np.repeat(np.array([owner for _, _, owner in outlines], np.int64), sizes),
    )


def _cast(edges: Edges, own: int, x: float, y: float, first: float, step: float, count: int, reach: float) -> Echoes:
    """Follow beams whose bearings rise; own: owner of edges that are not seen."""
    ax, ay = edges.x - x, edges.y - y
    area = ax * edges.along_y - ay * edges.along_x  # negative where the outside of an edge faces the sensor
    seen = np.flatnonzero((area < 0.0) & (area >= -reach * edges.lengths) & (edges.owners != own))
    ax, ay, area, ex, ey = (each[seen] for each in (ax, ay, area, edges.along_x, edges.along_y))
    bx, by = ax + ex, ay + ey

    # In units of beams: where each edge begins, counter-clockwise from the first beam, and how many it covers.
    begin = (np.arctan2(by, bx) - first) % (2 * pi) / step
    cover = np.arctan2(-area, ax * bx + ay * by) / step
    turn = 2 * pi / step
    beams, which = _pairs(np.concatenate((begin, begin - turn)), np.concatenate((cover, cover)), count)
    which %= max(1, len(seen))

    bearings = first + step * np.arange(count)
    c, s = np.cos(bearings), np.sin(bearings)
    slant = s[beams] * ex[which] - c[beams] * ey[which]  # of beam and edge: the sine between them by the edge's length
    with np.errstate(divide="ignore", invalid="ignore"):  # beams along an edge, which do not meet it
        distances = -area[which] / slant
    met = np.flatnonzero((distances > 0.0) & (distances <= reach))
    order = met[np.argsort(-distances[met], kind="stable")]  # the last one written to a beam stays: the nearest
    ranges = np.full(count, np.inf)
    cosines = np.zeros(count)
    reflects = np.zeros(count, np.bool_)
    hit, nearest = beams[order], which[order]
    ranges[hit] = distances[order]
    cosines[hit] = slant[order] / edges.lengths[seen[nearest]]
    reflects[hit] = edges.reflects[seen[nearest]]
    return Echoes(ranges, cosines, reflects)


def _pairs(begin: Floats, cover: Floats, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Every beam that crosses an edge, with the index of that edge."""
    low = np.maximum(np.ceil(begin - _ROUNDING), 0.0).astype(np.int64)
    high = np.minimum(np.floor(begin + cover + _ROUNDING), count - 1.0).astype(np.int64)
    sizes = np.maximum(high - low + 1, 0)
    which = np.repeat(np.arange(len(sizes)), sizes)
    offsets = low - (np.cumsum(sizes) - sizes)
    return np.arange(len(which)) + offsets[which], which

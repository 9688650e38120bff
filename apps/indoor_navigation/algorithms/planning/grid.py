"""What the robot has seen: for each cell of the floor, how much speaks for an obstacle.

A hit speaks louder than a ray that passes, but a few rays that pass end what hits have begun, so that a person who has
walked on is forgotten at once, and a room may change. What stands where it was free before may go again, and so may
what was not seen for long: who walks about is seen for the first time somewhere, too. And who walked and is out of
sight has walked on, as far as one knows.
"""

from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.planning.area import NEVER, PASSABLE, PASSED, Area, Flags
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Floats, ObstRead, Place

Cells = NDArray[np.intp]

HIT = 2  # what a reading adds to a cell that a ray hits, and PASSED to one that a ray passes
SURELY_FREE = -3  # a cell that has been so is no wall, whatever stands there later
MOST, LEAST = 8, -4
MARGIN = 5.0  # m that the area grows beyond what made it grow
THEIRS = 0.5  # s since somebody was in a place, in which what is hit there is theirs
SEAM = 0.6  # m; two hits nearer to each other are taken for one surface


@dataclass(frozen=True, slots=True)
class GridParameters:
    """What is believed, and how finely it is kept, in m.

    resolution: edge of a cell. reach: beyond which no ray is believed. lone_reach: likewise, of a ray that shares its
    origin with no other: so sonar sees, which is surer of distances than of directions. largest: edge of the area.
    settled: s after the first hit, from which on another one tells that somebody who walks about is not there.
    gone: s after the last hit, when somebody who walks about is not there any more, though nobody looks.
    """

    resolution: float
    reach: float
    lone_reach: float
    largest: float
    settled: float
    gone: float


class Grid:
    """What has been seen so far. `area` is replaced as a whole when it grows, so that others may read it meanwhile."""

    def __init__(self, parameters: GridParameters) -> None:
        self._parameters = parameters
        self._steps = np.arange(0.0, self._parameters.reach, self._parameters.resolution)
        self.forget()

    def forget(self) -> None:
        """Know nothing any more."""
        self.area = Area.of(0.0, 0.0, self._parameters.resolution, np.zeros((0, 0), np.int8))

    def include(self, place: Place, margin: float = 0.0) -> bool:
        """Let the area hold a place with a margin, m. False where it would become too large, and stays as it is."""
        area, resolution = self.area, self._parameters.resolution
        low = np.array(area.cell(place[0] - margin, place[1] - margin))
        high = np.array(area.cell(place[0] + margin, place[1] + margin)) + 1
        shape = np.array(area.evidence.shape)
        if (low >= 0).all() and (high <= shape).all():
            return True
        wide = ceil(MARGIN / resolution)
        if not area.evidence.size:
            before, after = wide - low, high + wide
        else:
            before = np.where(low < 0, wide - low, 0)
            after = np.where(high > shape, high - shape + wide, 0)
        if (shape + before + after).max() * resolution > self._parameters.largest:
            return False
        pad = list(zip(before.tolist(), after.tolist(), strict=True))
        self.area = Area(
            area.x - int(before[1]) * resolution,
            area.y - int(before[0]) * resolution,
            resolution,
            np.pad(area.evidence, pad),
            np.pad(area.first_hit, pad, constant_values=NEVER),
            np.pad(area.fixed, pad),
            np.pad(area.hit_at, pad, constant_values=-np.inf),
            np.pad(area.theirs_at, pad, constant_values=-np.inf),
        )
        return True

    def see(self, reading: ObstRead) -> None:
        """Note where rays have passed and where they have hit something."""
        if not self.include(reading.pose[:2], self._parameters.reach):
            return
        rays = _BelievedRays.of(Perceived.of(reading).rays, self._parameters)
        area = self.area
        passed = self._passed(rays)
        people = self._flat(reading.people_x, reading.people_y)
        hits = np.concatenate((self._flat(rays.end_x[rays.hits], rays.end_y[rays.hits]), people))
        kept = self._flat(*_seams(rays.end_x[rays.hits], rays.end_y[rays.hits]))
        votes = np.zeros(area.evidence.size, np.int8)
        votes[passed] = PASSED
        votes[kept] = 0
        votes[hits] = HIT
        changed = np.flatnonzero(votes)
        evidence = area.evidence.reshape(-1)
        evidence[changed] = np.clip(evidence[changed] + votes[changed], LEAST, MOST)
        free = changed[evidence[changed] <= SURELY_FREE]
        self._date(changed[votes[changed] == HIT], np.concatenate((free, self._unfixed(people))), reading.stamp)
        area.theirs_at.reshape(-1)[self._about(reading.people_x, reading.people_y)] = reading.stamp
        self._let_go(area.around(reading.pose[:2], margin=self._parameters.reach), reading.stamp)

    def take_for_walls(self, x: float, y: float, radius: float) -> None:
        """What stands here does not yield: it counts as what was never free."""
        part = self.area.around((x, y), margin=radius)
        part.fixed[part.occupied] = True

    def doubt(self, x: float, y: float, radius: float) -> None:
        """Know nothing of what is here any more."""
        part = self.area.around((x, y), margin=radius)
        part.evidence[:] = 0
        part.first_hit[:], part.fixed[:] = NEVER, False

    def _date(self, hit: Cells, free: Cells, stamp: float) -> None:
        """Note since when something is there."""
        first_hit, fixed = self.area.first_hit.reshape(-1), self.area.fixed.reshape(-1)
        self.area.hit_at.reshape(-1)[hit] = stamp
        first_hit[free], fixed[free] = PASSABLE, False
        first_hit[hit[np.isnan(first_hit[hit])]] = stamp
        fixed[hit] |= stamp - first_hit[hit] >= self._parameters.settled

    def _unfixed(self, people: Cells) -> Cells:
        """Where somebody stands who walked there is floor, though nobody has seen it, unless a wall was seen there."""
        return people[~self.area.fixed.reshape(-1)[people]]

    def _about(self, x: Floats, y: Floats) -> Cells:
        """The cells at these places and beside them."""
        edge = self._parameters.resolution
        beside = [self._flat(x + right * edge, y + up * edge) for right in (-1, 0, 1) for up in (-1, 0, 1)]
        return np.concatenate(beside)

    def _let_go(self, near: Area, stamp: float) -> None:
        """Who walks about and is out of sight."""
        are_theirs = near.hit_at - THEIRS < near.theirs_at
        near.evidence[are_theirs & (stamp - near.hit_at > self._parameters.gone) & near.occupied & ~near.fixed] = 0

    def _passed(self, rays: "_BelievedRays") -> Cells:
        """The cells through which rays have passed. One that hits passes to a cell before its end."""
        lengths = rays.lengths - np.where(rays.hits, self._parameters.resolution, 0.0)
        going = self._steps[None, :] < lengths[:, None]
        x = (rays.origin_x[:, None] + rays.cosines[:, None] * self._steps[None, :])[going]
        y = (rays.origin_y[:, None] + rays.sines[:, None] * self._steps[None, :])[going]
        return self._flat(x, y)

    def _flat(self, x: Floats, y: Floats) -> Cells:
        """Indices of the cells at these places, those outside left out."""
        area = self.area
        height, width = area.evidence.shape
        columns = np.floor((x - area.x) / area.resolution).astype(np.intp)
        rows = np.floor((y - area.y) / area.resolution).astype(np.intp)
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        cells: Cells = (rows * width + columns)[inside]
        return cells


class _BelievedRays(NamedTuple):
    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    cosines: Floats
    sines: Floats
    lengths: Floats
    hits: Flags

    @classmethod
    def of(cls, rays: Rays, parameters: GridParameters) -> "_BelievedRays":
        """Return the rays with finite coordinates, shortened to the length up to which they are believed."""
        dx, dy = rays.end_x - rays.origin_x, rays.end_y - rays.origin_y
        lengths = np.hypot(dx, dy)
        sound = np.isfinite(lengths) & (lengths > 0.0)
        reach = np.where(rays.is_of_scanner, parameters.reach, parameters.lone_reach)[sound]
        dx, dy, lengths = dx[sound], dy[sound], lengths[sound]
        return cls(
            rays.origin_x[sound],
            rays.origin_y[sound],
            rays.end_x[sound],
            rays.end_y[sound],
            dx / lengths,
            dy / lengths,
            np.minimum(lengths, reach),
            rays.hits[sound] & (lengths <= reach),
        )


def _seams(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Places between neighbouring hits of one surface.

    Where a wall is seen at a grazing angle, rays pass within its cells before they hit it a few cells farther on; there
    they say nothing.
    """
    if len(x) < 2:
        return x, y
    near = np.hypot(np.diff(x), np.diff(y)) < SEAM
    parts = np.linspace(0.0, 1.0, 7)[1:-1, None]
    from_x, to_x, from_y, to_y = x[:-1][near], x[1:][near], y[:-1][near], y[1:][near]
    return (from_x + parts * (to_x - from_x)).ravel(), (from_y + parts * (to_y - from_y)).ravel()

"""Matching of one scan with points seen before: correlation over a window, then point to line.

The points seen before are written into a grid, each cell with the number of the nearest point. So a nearest point is
one look into an array, whatever their number. Normals point to where a point was seen from, so the two faces of a thin
wall never match each other.

Source: E. Olson, Real-time correlative scan matching, ICRA 2009; A. Censi, An ICP variant using a point-to-line
metric, ICRA 2008.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D, wrap_angle
from maps.building.readings import Floats, moved, turned

Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]

CELL = 0.04
"""m, of the grid of nearest points; half of it is well below the accuracy that point to line reaches."""
REACH = 0.32
"""m from a point up to which it is found."""
ALIKE = 0.6
"""Least cosine between the normals of two points that match."""
COARSEST, FINEST = 0.15, 0.03
"""m, at the first and the last step: distances from which on a point counts for less."""
STEPS = 18
STILL = 1e-4
"""m and rad; a step below it is the last one."""
SIGMA = 0.015
"""m, of the distance of a point from its line: noise of scanner and line together."""
STEP_LEAST, STEP_MOST = 0.08, 0.2
"""m between two poses that are tried in a window."""
MOST_CORRELATED = 90
"""About so many points of a scan are used in it."""
FEWEST = 12
"""Points that must match at least."""
CORRELATED = 8.0
"""Points of one scan err together (timing, odometry during the scan), so that many count as one."""


@dataclass(frozen=True, slots=True)
class Match:
    """A pose found by matching.

    pose: of the scan in the frame of the points. information: inverse covariance of x, y and heading in that frame,
    shape (3, 3). overlap: share of the scan's points near a line. residual: m, root of their mean squared distance.
    """

    pose: Pose2D
    information: Floats
    overlap: float
    residual: float

    @property
    def is_constrained(self) -> bool:
        """Whether the points fix the pose in every direction: not so in a bare corridor."""
        return bool(np.linalg.eigvalsh(self.information[:2, :2])[0] > 1.5 / SIGMA**2 / 2.0)


class SurfaceField:
    """Points with normals, ready for scans to be matched with them."""

    def __init__(self, points: Floats, normals: Floats, *, one_sided: bool = True) -> None:
        """Write the points into a grid.

        Args:
            points: m, shape (n, 2), n > 0.
            normals: Of unit length towards the sensor, likewise; NaN where unknown: such points are left out.
            one_sided: Whether it is known which side of a surface was seen; not so of lines of a file.
        """
        known = np.isfinite(normals[:, 0])
        self._one_sided = one_sided
        self.points, self.normals = points[known], normals[known]
        self._low = (self.points.min(axis=0) if len(self.points) else np.zeros(2)) - 2 * REACH
        high = (self.points.max(axis=0) if len(self.points) else np.zeros(2)) + 2 * REACH
        columns, rows = np.ceil((high - self._low) / CELL).astype(np.int64) + 1
        self._nearest = np.full((rows, columns), -1, np.int32)
        at = ((self.points - self._low) / CELL).astype(np.int64)
        numbers = np.arange(len(self.points), dtype=np.int32)
        flat = self._nearest.reshape(-1)
        cells = at[:, 1] * columns + at[:, 0]
        for dx, dy in _offsets():  # from far to near: the nearest comes last
            flat[cells + (dy * columns + dx)] = numbers

    def nearest(self, points: Floats) -> Integers:
        """Return the number of the nearest point for each of some points; -1 where none is near."""
        at = np.floor((points - self._low) / CELL).astype(np.int64)
        rows, columns = self._nearest.shape
        inside = (at[:, 0] >= 0) & (at[:, 0] < columns) & (at[:, 1] >= 0) & (at[:, 1] < rows)
        at[~inside] = 0
        found = self._nearest[at[:, 1], at[:, 0]].astype(np.int64)
        found[~inside] = -1
        return found

    def likelihood(self, width: float) -> NDArray[np.float32]:
        """Return how likely an echo is in each cell, 0 to 1, for errors of a standard deviation, m."""
        found = self._nearest
        rows, columns = np.indices(found.shape)
        middles = self._low + CELL * (np.stack((columns, rows), axis=2) + 0.5)
        away = np.square(middles - self.points[found]).sum(axis=2)
        return np.where(found >= 0, np.exp(-away / (2.0 * width**2)), 0.0).astype(np.float32)

    def correlate(self, points: Floats, middle: Pose2D, reach: float, turn: float) -> Pose2D:
        """Search a window for the pose at which most points are likely; the wider, the coarser.

        Args:
            points: Of the scan, m, shape (n, 2).
            middle: Of the window. reach: m to either side in x and y. turn: rad likewise.
        """
        step = min(max(STEP_LEAST, reach / 8.0), STEP_MOST)
        points = points[:: 1 + len(points) // MOST_CORRELATED]
        likely = self.likelihood(1.2 * step)
        farthest = float(np.quantile(np.hypot(points[:, 0], points[:, 1]), 0.8))
        angles = middle.heading + np.arange(-turn, turn + 1e-9, max(0.01, step / max(farthest, 1.0)))
        shift = max(1, round(step / CELL))
        count = int(np.ceil(reach / (shift * CELL)))
        offsets = shift * np.arange(-count, count + 1)
        best, found = -1.0, middle
        for angle in angles:
            at = np.floor((moved(points, Pose2D(middle.x, middle.y, float(angle))) - self._low) / CELL)
            scores = _scores(likely, at.astype(np.int64), offsets)
            row, column = np.unravel_index(int(np.argmax(scores)), scores.shape)
            if scores[row, column] > best:
                best = float(scores[row, column])
                x, y = middle.x + CELL * offsets[column], middle.y + CELL * offsets[row]
                found = Pose2D(float(x), float(y), wrap_angle(float(angle)))
        return found

    def align(
        self, points: Floats, normals: Floats, start: Pose2D, prior: Floats | None = None, coarsest: float = COARSEST
    ) -> Match | None:
        """Improve a pose until the points lie on the lines seen before.

        Args:
            points, normals: Of the scan, in its own frame.
            start: Where to begin, in the frame of the points of this field.
            prior: Information of the start itself, which keeps a pose that the points do not fix; shape (3, 3).
            coarsest: m, for the first step.
        Returns:
            None where too few points match.
        """
        if not len(self.points):
            return None
        pose = np.array([start.x, start.y, start.heading])
        began = pose.copy()
        for number in range(STEPS):
            scale = max(FINEST, coarsest * 0.75**number)
            system = self._system(points, normals, pose, scale)
            if system is None:
                return None
            hessian, gradient, _, _ = system
            if prior is not None:
                hessian = hessian + prior
                gradient = gradient + prior @ (pose - began)
            step = -np.linalg.solve(hessian + 1e-6 * np.eye(3), gradient)
            pose = pose + step
            if scale == FINEST and np.abs(step).max() < STILL:
                break
        system = self._system(points, normals, pose, FINEST)
        if system is None:
            return None
        information, _, near, residual = system
        return Match(Pose2D(pose[0], pose[1], wrap_angle(float(pose[2]))), information, near / len(points), residual)

    def _system(
        self, points: Floats, normals: Floats, pose: Floats, scale: float
    ) -> tuple[Floats, Floats, int, float] | None:
        """Linearise: information, gradient, number of points near a line, and their residual, m."""
        about = turned(points, pose[2])
        at = about + pose[:2]
        found = self.nearest(at)
        facing = turned(normals, pose[2])
        theirs = self.normals[found]
        alike = (facing * theirs).sum(axis=1)
        fits = (found >= 0) & ~((alike if self._one_sided else np.abs(alike)) < ALIKE)  # one that is unknown fits
        if np.count_nonzero(fits) < FEWEST:
            return None
        about, at, theirs, found = about[fits], at[fits], theirs[fits], found[fits]
        away = ((at - self.points[found]) * theirs).sum(axis=1)
        weights = 1.0 / (1.0 + np.square(away / scale))
        weights /= SIGMA**2 * CORRELATED
        rows = np.stack((theirs[:, 0], theirs[:, 1], theirs[:, 1] * about[:, 0] - theirs[:, 0] * about[:, 1]), axis=1)
        weighted = rows * weights[:, None]
        near = np.abs(away) < 2.0 * scale
        residual = float(np.sqrt(np.square(away[near]).mean())) if near.any() else float("inf")
        return weighted.T @ rows, weighted.T @ away, int(np.count_nonzero(near)), residual


def _scores(likely: NDArray[np.float32], cells: Integers, offsets: Integers) -> Floats:
    """How likely the echoes are in cells (x, y), shifted by all pairs of offsets; rows are shifts in y."""
    rows, columns = likely.shape
    x, y = cells[:, 0, None] + offsets, cells[:, 1, None] + offsets
    inside_x, inside_y = (x >= 0) & (x < columns), (y >= 0) & (y < rows)
    scores = likely[np.where(inside_y, y, 0)[:, :, None], np.where(inside_x, x, 0)[:, None, :]]
    result: Floats = np.where(inside_y[:, :, None] & inside_x[:, None, :], scores, 0.0).sum(axis=0)
    return result


def scan_normals(points: Floats, origins: Floats) -> Floats:
    """Return the normals of a scan's points, of unit length and towards the sensor; NaN where neighbours are far.

    Args:
        points, origins: Ends and beginnings of the beams in their order, shape (n, 2).
    """
    ranges = np.hypot(*(points - origins).T)
    gaps = np.hypot(*np.diff(points, axis=0).T)
    joined = gaps < np.maximum(0.08, 0.10 * np.minimum(ranges[1:], ranges[:-1]))
    # Over two neighbours on either side where the surface goes on so far; noise counts for less.
    left = np.arange(len(points))
    right = left.copy()
    for _ in range(2):
        left = np.where((left > 0) & np.append(True, joined)[left], left - 1, left)
        right = np.where((right < len(points) - 1) & np.append(joined, True)[right], right + 1, right)
    way = points[right] - points[left]
    length = np.hypot(*way.T)
    with np.errstate(invalid="ignore", divide="ignore"):  # points that coincide have no normal
        normals = np.stack((-way[:, 1], way[:, 0]), axis=1) / length[:, None]
        bent = np.abs(((points - points[left]) * normals).sum(axis=1))
    towards = (normals * (origins - points)).sum(axis=1)
    normals = normals * np.where(towards < 0.0, -1.0, 1.0)[:, None]
    normals[(right - left < 2) | ~(length > 0.02) | (bent > 0.03)] = np.nan
    result: Floats = normals
    return result


def field_of(parts: list[tuple[Pose2D, Floats, Floats]], *, one_sided: bool = True) -> SurfaceField:
    """Make one field of several scans: pose, points and normals of each; `one_sided` as for `SurfaceField`."""
    points = np.concatenate([moved(points, pose) for pose, points, _ in parts])
    normals = np.concatenate([turned(normals, pose.heading) for pose, _, normals in parts])
    return SurfaceField(points, normals, one_sided=one_sided)


@cache
def _offsets() -> tuple[tuple[int, int], ...]:
    """Cells about a point within its reach, from far to near."""
    count = int(REACH / CELL)
    cells = [(dx, dy) for dx in range(-count, count + 1) for dy in range(-count, count + 1)]
    near = [cell for cell in cells if np.hypot(*cell) <= count]
    return tuple(sorted(near, key=lambda cell: -np.hypot(*cell)))

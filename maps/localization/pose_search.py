"""Search of a pose in the whole map: the pose that explains the readings of the last metres best, and how clearly."""

from dataclasses import dataclass
from math import pi, tau

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D, wrap_angle
from maps.localization.likelihood_field import LikelihoodField, RangeCosts
from maps.localization.motion import placed
from maps.localization.settings import LocalizationSettings, PoseSearchSettings, SensorTrust, TrustSettings

Points = NDArray[np.float64]
Poses = NDArray[np.float64]

_STEPS = ((0.1, 0.05), (0.05, 0.025), (0.025, 0.0125))  # m and rad by which poses are improved, one after the other
_WIDE = 0.25  # m, standard deviation of the first choice, whose poses are far apart
_ASIDE, _TURNED = (-0.4, -0.2, 0.0, 0.2, 0.4), (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)  # m and rad about a given pose


@dataclass(frozen=True, slots=True)
class FoundPose:
    """A pose that explains the readings.

    score: share of the readings whose ends are near a wall.
    margin: nats by which it is better than the best pose elsewhere.
    """

    pose: Pose2D
    score: float
    margin: float

    def is_clear(self, trust: SensorTrust) -> bool:
        """Return whether it explains the readings, and no other place does."""
        return self.score >= trust.good and self.margin >= trust.margin


@dataclass(frozen=True, slots=True)
class ComparedPose:
    """A pose that was given, compared with every other one.

    score: share of the readings whose ends are near a wall at the best pose near it.
    behind: nats by which a pose elsewhere is better; 0 if none is.
    """

    score: float
    behind: float

    def is_confirmed(self, trust: SensorTrust) -> bool:
        """Return whether it explains the readings well enough for a pose that was given, and no other place better."""
        return self.score >= trust.enough and self.behind <= trust.rival


class PoseSearch:
    """Compares readings with the map at every free place and in every direction."""

    def __init__(self, field: LikelihoodField, settings: LocalizationSettings, rng: np.random.Generator) -> None:
        self._field = field
        self._settings: PoseSearchSettings = settings.search
        self._trust: TrustSettings = settings.trust
        self._rng = rng
        self._wide = field.costs(_WIDE, settings.field.clutter)
        self._fine = field.costs(2.0 * settings.field.laser_sigma, settings.field.clutter)
        self._poses = self._everywhere()

    def score(self, pose: Pose2D, ends: Points, origins: Points, near: float) -> float:
        """Share of readings that the map explains at a pose: they end within `near` m of a wall and pass through none.

        Args:
            pose: Of the robot in `map`.
            ends, origins: Of the readings in `base_link`, m, shape (n, 2).
            near: m.
        Returns:
            0 to 1; 0 without readings.
        """
        if not len(ends):
            return 0.0
        is_near, is_blocked = self._field.explained(placed(pose, origins), placed(pose, ends), near)
        return float(np.mean(is_near & ~is_blocked))

    def find(self, ends: Points, origins: Points, near: float) -> FoundPose | None:
        """The best pose for readings in `base_link`, as for `score`; None without readings or free places."""
        if not self._can_search(ends):
            return None
        poses, costs = self._best(ends, origins, near)
        best = int(costs.argmin())
        others = costs[self._are_apart(poses, poses[best])]
        margin = float(others.min() - costs[best]) * self._trust.weight if len(others) else np.inf
        found = _pose(poses[best])
        return FoundPose(found, self.score(found, ends, origins, near), margin)

    def compare(self, given: Pose2D, ends: Points, origins: Points, trust: SensorTrust) -> ComparedPose:
        """Compare a pose that was given, or the best one near it, with all others by readings in `base_link`.

        Readings that are too few for a search would fit too many poses near the given one; it is taken as it is then.
        """
        if not self._can_search(ends):
            return ComparedPose(self.score(given, ends, origins, trust.close), 0.0)
        aside = [(given.x + x, given.y + y, given.heading + turn) for x in _ASIDE for y in _ASIDE for turn in _TURNED]
        near, costs = self._refined(np.array(aside), ends, origins, trust.near)
        best = near[int(costs.argmin())]
        others, costs_of_others = self._best(ends, origins, trust.near)
        costs_of_others = costs_of_others[self._are_apart(others, best)]
        behind = float(costs.min() - costs_of_others.min(initial=np.inf)) * self._trust.weight
        return ComparedPose(self.score(_pose(best), ends, origins, trust.close), max(0.0, behind))

    def _can_search(self, ends: Points) -> bool:
        return len(ends) >= self._settings.points and len(self._poses) > 0

    def _best(self, ends: Points, origins: Points, near: float) -> tuple[Poses, NDArray[np.float64]]:
        """The best poses of the whole map, of which no two are nearly the same, and their costs in nats."""
        few = ends[self._rng.choice(len(ends), self._settings.points, replace=False)].astype(np.float32)
        first = self._wide.of(self._poses, few)
        kept = np.argpartition(first, min(self._settings.kept, len(first) - 1))[: self._settings.kept]
        poses = self._poses[kept]
        poses, _ = self._apart(poses, self._wide.of(poses, ends.astype(np.float32)))
        return self._refined(poses, ends, origins, near)

    def _refined(self, poses: Poses, ends: Points, origins: Points, near: float) -> tuple[Poses, NDArray[np.float64]]:
        """The best pose near each one, and its costs; a reading through a wall costs as much as one far from any."""
        poses, costs = _improved(self._fine, poses, ends.astype(np.float32))
        each = [_pose(row) for row in poses]
        all_origins, all_ends = (np.concatenate([placed(pose, points) for pose in each]) for points in (origins, ends))
        _, is_blocked = self._field.explained(all_origins, all_ends, near)
        through = np.count_nonzero(is_blocked.reshape(len(each), -1), axis=1)
        return poses, costs.astype(np.float64) + self._fine.worst * through

    def is_apart(self, one: Pose2D, other: Pose2D) -> bool:
        """Whether two poses are another place or direction."""
        row = np.array([[one.x, one.y, one.heading]])
        return bool(self._are_apart(row, np.array((other.x, other.y, other.heading)))[0])

    def _everywhere(self) -> Poses:
        """Poses on a grid of the free cells, in all directions."""
        cell = self._settings.cell
        places = np.unique(np.floor(self._field.free / cell).astype(np.int64), axis=0)
        centres = np.asarray((places + 0.5) * cell, np.float64)
        centres = centres[self._field.distances_at(centres) > 0.5 * cell]
        headings = np.arange(0.0, tau, self._settings.turn)
        poses = np.empty((len(centres) * len(headings), 3))
        poses[:, :2] = np.repeat(centres, len(headings), axis=0)
        poses[:, 2] = np.tile(headings, len(centres))
        return poses

    def _apart(self, poses: Poses, costs: NDArray[np.float32]) -> tuple[Poses, NDArray[np.float32]]:
        """The best poses, of which no two are nearly the same."""
        chosen: list[int] = []
        left = costs.copy()
        while len(chosen) < self._settings.refined and np.isfinite(left.min()):
            best = int(left.argmin())
            chosen.append(best)
            left[~self._are_apart(poses, poses[best], 0.5)] = np.inf
        return poses[chosen], costs[chosen]

    def _are_apart(self, poses: Poses, one: NDArray[np.float64], share: float = 1.0) -> NDArray[np.bool_]:
        """Which poses are another place or direction than one of them."""
        away = np.hypot(poses[:, 0] - one[0], poses[:, 1] - one[1])
        turned = np.abs(np.remainder(poses[:, 2] - one[2] + pi, tau) - pi)
        is_apart: NDArray[np.bool_] = (away > share * self._trust.apart) | (turned > share * self._trust.apart_turn)
        return is_apart


def _pose(row: NDArray[np.float64]) -> Pose2D:
    x, y, heading = row.tolist()
    return Pose2D(x, y, wrap_angle(heading))


def _improved(costs: RangeCosts, poses: Poses, ends: NDArray[np.float32]) -> tuple[Poses, NDArray[np.float32]]:
    """Poses at the least costs near each one, and these costs: pattern search with ever smaller steps."""
    poses = poses.copy()
    best = costs.of(poses, ends)
    for step, turn in _STEPS:
        moves = np.array([(dx * step, dy * step, dh * turn) for dx, dy, dh in _NEIGHBOURS])
        for _ in range(3):
            tried = (poses[:, np.newaxis, :] + moves).reshape(-1, 3)
            found = costs.of(tried, ends).reshape(len(poses), len(moves))
            choice = found.argmin(axis=1)
            least = found[np.arange(len(poses)), choice]
            is_better = least < best
            if not is_better.any():
                break
            poses[is_better] += moves[choice[is_better]]
            best = np.where(is_better, least, best)
    return poses, best


_NEIGHBOURS = [(dx, dy, dh) for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dh in (-1, 0, 1) if (dx, dy, dh) != (0, 0, 0)]

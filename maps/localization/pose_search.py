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
        if len(ends) < self._settings.points or not len(self._poses):
            return None
        few = ends[self._rng.choice(len(ends), self._settings.points, replace=False)].astype(np.float32)
        first = self._wide.of(self._poses, few)
        kept = np.argpartition(first, min(self._settings.kept, len(first) - 1))[: self._settings.kept]
        poses, every = self._poses[kept], ends.astype(np.float32)
        poses, costs = self._apart(poses, self._wide.of(poses, every))
        poses, costs = _improved(self._fine, poses, every)
        found = [Pose2D(x, y, wrap_angle(heading)) for x, y, heading in poses.tolist()]
        all_origins, all_ends = (np.concatenate([placed(pose, each) for pose in found]) for each in (origins, ends))
        _, is_blocked = self._field.explained(all_origins, all_ends, near)
        costs = costs + self._fine.worst * np.count_nonzero(is_blocked.reshape(len(found), -1), axis=1)
        best = int(costs.argmin())
        others = costs[self._are_apart(poses, poses[best])]
        margin = float(others.min() - costs[best]) * self._trust.weight if len(others) else np.inf
        return FoundPose(found[best], self.score(found[best], ends, origins, near), margin)

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

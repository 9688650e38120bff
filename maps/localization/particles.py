"""A set of particles: weights, the mean with its covariance, and resampling with as many as are needed.

Source: Thrun, Burgard and Fox, Probabilistic Robotics, sections 4.3 and 8.3 (KLD sampling after D. Fox).
"""

from math import atan2, sqrt

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D
from maps.localization.settings import ParticleSettings

Poses = NDArray[np.float64]
Covariance = NDArray[np.float64]


class Particles:
    """Poses in `map` with weights whose sum is 1.

    poses: x, y, heading, shape (n, 3).
    """

    def __init__(self, poses: Poses, settings: ParticleSettings, rng: np.random.Generator) -> None:
        self.poses = poses
        self._weights = np.full(len(poses), 1.0 / len(poses))
        self._settings = settings
        self._rng = rng

    @classmethod
    def around(
        cls, pose: Pose2D, sigma: float, turn: float, settings: ParticleSettings, rng: np.random.Generator
    ) -> "Particles":
        """Normally distributed particles about a pose, with standard deviations in m and rad."""
        poses = rng.standard_normal((settings.most, 3)) * (sigma, sigma, turn)
        poses += np.array((pose.x, pose.y, pose.heading))
        return cls(poses, settings, rng)

    def weigh(self, costs: NDArray[np.float32]) -> None:
        """Multiply the weights by likelihoods, which are given as nats, shape (n,)."""
        logs = np.log(self._weights) - costs
        weights = np.exp(logs - logs.max())
        self._weights = np.maximum(weights / weights.sum(), 1e-300)

    def mean(self) -> tuple[Pose2D, Covariance]:
        """The mean pose and its covariance in x, y and heading: m2, m rad and rad2, shape (3, 3)."""
        x, y = self._weights @ self.poses[:, :2]
        c, s = self._weights @ np.cos(self.poses[:, 2]), self._weights @ np.sin(self.poses[:, 2])
        heading = atan2(s, c)
        errors = self.poses - (x, y, heading)
        errors[:, 2] = np.remainder(errors[:, 2] + np.pi, 2.0 * np.pi) - np.pi
        return Pose2D(float(x), float(y), heading), (errors * self._weights[:, np.newaxis]).T @ errors

    def resample(self) -> None:
        """Draw new particles by the weights, where these differ much; as many as KLD sampling asks for."""
        count = len(self.poses)
        effective = 1.0 / np.square(self._weights).sum()
        if effective > 0.5 * count and count <= 2 * self._needed(self.poses):
            return
        drawn = self.poses[self._chosen(count)]
        needed = self._needed(drawn)
        self.poses = drawn if needed >= count else self.poses[self._chosen(needed)]
        if needed > count:
            self.poses = self.poses[self._rng.integers(0, count, needed)]
        self._weights = np.full(len(self.poses), 1.0 / len(self.poses))

    def inject(self, pose: Pose2D) -> None:
        """Replace a share of the particles by ones around a pose, as wide as a pose that a person gives."""
        settings = self._settings
        count = int(settings.injected * len(self.poses))
        errors = self._rng.standard_normal((count, 3))
        errors *= (settings.start_sigma, settings.start_sigma, settings.start_turn)
        chosen = self._rng.choice(len(self.poses), count, replace=False)
        self.poses[chosen] = errors + np.array((pose.x, pose.y, pose.heading))

    def _chosen(self, count: int) -> NDArray[np.int64]:
        """Indices by the weights, with one random number (low variance sampling)."""
        positions = (np.arange(count) + self._rng.random()) / count
        return np.minimum(np.searchsorted(np.cumsum(self._weights), positions), len(self._weights) - 1)

    def _needed(self, poses: Poses) -> int:
        """Particles for the number of cells of a histogram that they fill."""
        settings = self._settings
        bins = np.floor(poses / (settings.bin, settings.bin, settings.bin_turn)).astype(np.int64)
        bins -= bins.min(axis=0)
        sizes = bins.max(axis=0) + 1
        filled = len(np.unique((bins[:, 0] * sizes[1] + bins[:, 1]) * sizes[2] + bins[:, 2]))
        if filled < 2:
            return settings.least
        k = filled - 1
        part = 2.0 / (9.0 * k)
        needed = k / (2.0 * settings.error) * (1.0 - part + sqrt(part) * settings.quantile) ** 3
        return int(min(max(needed, settings.least), settings.most))

"""Estimation of systematic errors of odometry while driving: scales of distances and turns, and drift.

The localized path is compared with that of odometry, window by window, by recursive least squares with forgetting.
Source: Borenstein and Feng, Measurement and Correction of Systematic Odometry Errors in Mobile Robots, 1996 (the three
errors: wheel diameter, wheel base, unequal wheels).
"""

from dataclasses import dataclass
from math import exp, hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D, wrap_angle
from maps.localization.settings import OdometrySettings

_DISTANCE_NOISE = 0.02  # m, of the localized length of a window, beside the uncertainty of its ends
_TURN_NOISE = 0.01  # rad, of its localized turn, likewise
_SURE = 0.06  # m; a window begins and ends where the pose is known better than this


@dataclass(frozen=True, slots=True)
class SystematicErrors:
    """What odometry is corrected by.

    distance: true m per m of odometry. turn: true rad per rad of odometry. drift: rad per m to the left that odometry
    does not see. deviations: standard deviations of the three.
    """

    distance: float = 1.0
    turn: float = 1.0
    drift: float = 0.0
    deviations: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def corrected(self, step: Pose2D) -> Pose2D:
        """A small step of odometry, in the frame of the pose before, without the errors."""
        heading = self.turn * step.heading + self.drift * step.x
        return Pose2D(self.distance * step.x, self.distance * step.y, wrap_angle(heading))


class OdometryErrorFilter:
    """Estimates the errors from windows of travel."""

    def __init__(self, settings: OdometrySettings) -> None:
        self._settings = settings
        prior = (settings.distance_sigma**2, settings.turn_sigma**2, settings.drift_sigma**2)
        self._estimate = np.array([1.0, 1.0, 0.0])
        self._covariance = np.diag(prior)
        self._prior = np.array(prior)
        self._travel = self._turned = self._forward = 0.0
        self._begin: Pose2D | None = None
        self._begin_deviations = 0.0, 0.0  # m and rad
        self._path = Pose2D()  # of odometry since the beginning of the window, in its frame

    @property
    def errors(self) -> SystematicErrors:
        """The present estimate."""
        distance, turn, drift = self._estimate.tolist()
        a, b, c = np.sqrt(np.diag(self._covariance)).tolist()
        return SystematicErrors(distance, turn, drift, (a, b, c))

    def restart(self) -> None:
        """Begin the window anew, as after a jump of the localized pose; the estimate stays."""
        self._begin = None

    def add(self, step: Pose2D, localized: Pose2D, covariance: NDArray[np.float64]) -> None:
        """Take a step of raw odometry, in the frame of the pose before, and the localized pose behind it."""
        deviation, turn_deviation = sqrt(covariance[0, 0] + covariance[1, 1]), sqrt(covariance[2, 2])
        if self._begin is None:
            if deviation < _SURE:
                self._begin, self._path = localized, Pose2D()
                self._begin_deviations = deviation, turn_deviation
                self._travel = self._turned = self._forward = 0.0
            return
        self._path = self._path.compose(step)
        self._travel += abs(step.x)
        self._forward += step.x
        self._turned += step.heading
        if self._travel >= self._settings.window:
            if deviation < _SURE:
                noise = hypot(_DISTANCE_NOISE, deviation, self._begin_deviations[0])
                self._compare(localized, noise, hypot(_TURN_NOISE, turn_deviation, self._begin_deviations[1]))
            self._begin = None

    def _compare(self, localized: Pose2D, noise: float, turn_noise: float) -> None:
        assert self._begin is not None
        true = localized.relative_to(self._begin)
        length, straight = np.hypot(true.x, true.y), np.hypot(self._path.x, self._path.y)
        expected = self._estimate[1] * self._turned + self._estimate[2] * self._forward
        turned = expected + wrap_angle(true.heading - expected)  # the localized heading knows no full turns
        fade = exp(-self._travel / self._settings.memory)
        self._covariance = np.minimum(1.0 / fade, 2.0) * self._covariance
        np.fill_diagonal(self._covariance, np.minimum(np.diag(self._covariance), self._prior))
        if straight > 0.5 * self._settings.window:
            self._take(np.array([straight, 0.0, 0.0]), length, noise)
        self._take(np.array([0.0, self._turned, self._forward]), turned, turn_noise)

    def _take(self, row: NDArray[np.float64], measured: float, noise: float) -> None:
        gain = self._covariance @ row / (row @ self._covariance @ row + noise**2)
        self._estimate = self._estimate + gain * (measured - row @ self._estimate)
        self._covariance = self._covariance - np.outer(gain, row @ self._covariance)

"""Speeds that increase smoothly: neither the speed nor its rate of change jumps upwards.

A decrease is never delayed, because a lower speed may be needed for safety.
"""

from dataclasses import dataclass

MAX_GAP = 0.5  # s between two steps; after a longer gap the smoothing restarts at the present speed


@dataclass(frozen=True, slots=True)
class SmoothingParameters:
    """Limits of a speed, in its unit.

    rate: maximum change per s. rate_change: maximum change of the rate per s². haste: 1/s, rate per difference to the
    wanted speed. ahead: maximum difference to the present speed, which other components may limit.
    """

    rate: float
    rate_change: float
    haste: float
    ahead: float


class SmoothedSpeed:
    """One speed that increases smoothly."""

    def __init__(self, parameters: SmoothingParameters) -> None:
        self._parameters = parameters
        self._stamp = float("-inf")
        self._speed = self._rate = 0.0

    def step(self, stamp: float, wanted: float, present: float) -> float:
        """Return the speed to command.

        Args:
            stamp: s of any clock.
            wanted: The speed to reach.
            present: The speed of the robot.
        """
        parameters, elapsed = self._parameters, stamp - self._stamp
        if elapsed == 0.0:
            return self._speed
        self._stamp = stamp
        if not 0.0 < elapsed < MAX_GAP:
            self._speed, self._rate = present, 0.0
            return self._speed
        if abs(wanted) <= abs(self._speed) and wanted * self._speed >= 0.0:
            self._speed, self._rate = wanted, 0.0
            return self._speed
        held = _within(self._speed, present - parameters.ahead, present + parameters.ahead)
        if held != self._speed:
            self._speed, self._rate = held, 0.0
        rate = _within(parameters.haste * (wanted - self._speed), -parameters.rate, parameters.rate)
        change = parameters.rate_change * elapsed
        self._rate = _within(rate, self._rate - change, self._rate + change)
        before, self._speed = self._speed, self._speed + self._rate * elapsed
        if (before - wanted) * (self._speed - wanted) < 0.0:
            self._speed, self._rate = wanted, 0.0
        return self._speed


def _within(value: float, least: float, most: float) -> float:
    return max(least, min(most, value))

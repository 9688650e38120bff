"""From wanted speeds to speeds that grow smoothly: neither they nor their rates of change ever jump upwards.

Who wants to be slower has a reason, and is it at once, as far as the robot can.
"""

from dataclasses import dataclass

PAUSE = 0.5  # s without a step, after which it begins anew from where the robot is


@dataclass(frozen=True, slots=True)
class SmoothingParameters:
    """How fast a speed may change, in units of it.

    rate: per s. rate_change: per s². haste: 1/s, of the way to the wanted one. ahead: how far it may be ahead of the
    robot, which others may hold.
    """

    rate: float
    rate_change: float
    haste: float
    ahead: float


class Smooth:
    """One speed."""

    def __init__(self, parameters: SmoothingParameters) -> None:
        self._parameters = parameters
        self._stamp = float("-inf")
        self._speed = self._rate = 0.0

    def step(self, stamp: float, wanted: float, present: float) -> float:
        """The speed to ask for now.

        Args:
            stamp: s of any clock.
            wanted: Speed.
            present: Speed that the robot has.
        """
        parameters, elapsed = self._parameters, stamp - self._stamp
        if elapsed == 0.0:
            return self._speed
        self._stamp = stamp
        if not 0.0 < elapsed < PAUSE:
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

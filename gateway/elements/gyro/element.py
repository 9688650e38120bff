"""An analog gyro whose counts the robot sends; the client computes the turn rate.

A controller that uses the gyro itself (by its CONFIGpac) sends no readings; they improve its odometry.
Source: client libraries.
"""

from math import inf

from gateway.elements.asked import SILENCE
from gateway.elements.element import Element
from gateway.events import TurnRateSeen
from gateway.motion_in_progress import is_at_rest
from p2os import Command, Configuration, GyroReport, StandardSip
from p2os.accessory_packets import GYRO_DEAD, GYRO_PERIOD, GYRO_RATE, GYRO_REST
from p2os.configuration import GyroKind

REST_ERROR = 5.0
"""Standard deviation of the nominal rest count, counts; assumed."""
TIME_TO_SETTLE = 0.5
"""Seconds for which the wheels must have stood before a reading counts as one at rest."""
MEMORY = 200.0
"""Readings over which the rest position is averaged: 5 s."""
ENOUGH = 20.0
"""Readings at rest after which a heading may be built on the gyro: half a second."""


class Gyro(Element[GyroReport]):
    """Learns the rest count of the gyro while the wheels stand, and reports the turn rate.

    is_present: readings come as packets. is_inside: the controller uses the gyro by itself.
    """

    takes = (GyroReport,)
    is_inside = False
    _rest = float(GYRO_REST)
    _noise = 1.0  # variance of a reading, counts²
    _learned = 0.0  # readings at rest so far, at most MEMORY
    _standing_since = inf
    _has_failed = False
    _turned = 0.0  # rad since the last `take_turn`
    _has_turned = False

    def configure(self, configuration: Configuration, now: float) -> None:
        """Take the kind of gyro; a slow line cannot carry its readings."""
        self.is_present = configuration.has_gyro == GyroKind.PACKETS and self._settings.line.streams
        self.is_inside = configuration.has_gyro >= GyroKind.INSIDE
        self.deadline = inf
        if self.is_present:
            self.watch(now)

    def watch(self, now: float) -> None:
        """Ask for readings; again when none come, since robot or line may have dropped the frame."""
        self._ask(Command.GYRO, 1)
        self.deadline = now + SILENCE

    def lose_link(self) -> None:
        """Forget the turn: the wheels may move meanwhile."""
        self.deadline = inf
        self._standing_since = inf
        self._turned, self._has_turned = 0.0, False

    def see(self, sip: StandardSip, now: float) -> None:
        """Note whether the wheels stand, and whether the gyro has failed."""
        self._has_failed = sip.gyro_failed
        if not is_at_rest(sip):
            self._standing_since = inf
        else:
            self._standing_since = min(self._standing_since, now)

    def take(self, packet: GyroReport, now: float) -> None:
        """Turn readings into a turn rate; a gyro that has failed has none."""
        if self.is_present:
            self.deadline = now + SILENCE
        counts = [sample.rate for sample in packet.samples if sample.rate != GYRO_DEAD]
        if self._has_failed or not counts or not self.is_present:
            return
        if now - self._standing_since >= TIME_TO_SETTLE:
            for count in counts:
                self._learn(count)
        unit = GYRO_RATE * self._settings.calibration.gyro
        mean = sum(counts) / len(counts)
        rest_error = REST_ERROR**2 if not self._learned else self._noise / self._learned
        variance = (self._noise / len(counts) + rest_error) * unit**2
        rate, duration = (self._rest - mean) * unit, len(counts) * GYRO_PERIOD
        self._turned += rate * duration
        self._has_turned = True
        self._announce(TurnRateSeen(rate, variance, duration))

    def take_turn(self) -> float | None:
        """Take what the robot has turned since the last call, rad counter-clockwise.

        None where that is not known: no packet has come, or it is not known where the gyro rests.
        """
        turned = self._turned if self._has_turned and self._learned >= ENOUGH else None
        self._turned, self._has_turned = 0.0, False
        return turned

    def _learn(self, count: int) -> None:
        self._learned = min(self._learned + 1.0, MEMORY)
        off = count - self._rest
        self._rest += off / self._learned
        if self._learned > 1.0:
            self._noise += (off * (count - self._rest) - self._noise) / self._learned

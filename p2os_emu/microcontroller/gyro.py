"""The gyro server: samples on their way to the client, or a heading corrected inside the controller.

Source: fact sheet, section 6 and section 7 of the accessories. Assumed: a controller that corrects inside is on from
power-on, by GYRO 1 trusts the wheels while they stand and the gyro while they turn, by GYRO 2 the gyro alone, and
learns the gyro's rest count while the robot stands. A failed gyro reads zero.
"""

from math import radians

from p2os.accessory_packets import GyroReport, GyroSample
from p2os.arguments import GyroMode
from p2os_emu.accessories.analog_gyro import AnalogGyro
from p2os_emu.microcontroller.timers import Cadence

LEARNING = 0.02
"""Least weight of a new sample in the rest count, which is a mean of all samples at first."""
KEPT = 16
"""Samples that wait for a client at most."""
DEAD = GyroSample(0, 0)


class GyroServer:
    """Reads the gyro every 25 ms.

    inside: the controller corrects its own heading; else a client asks for the samples. mode: argument of GYRO.
    rate: rad/s counter-clockwise, as the controller understands the last sample.
    """

    def __init__(self, gyro: AnalogGyro, inside: bool) -> None:
        self.inside = inside
        self._gyro = gyro
        self._cadence = Cadence(gyro.spec.sample_period_s)
        self._rate_of_count = radians(gyro.spec.deg_s_per_count)
        self.power_on()

    def power_on(self) -> None:
        """Begin as after the power switch."""
        self.rate = 0.0
        self._age = 0.0
        self._rest = self._gyro.spec.rest_count
        self._learnt = 0
        self._samples: list[GyroSample] = []
        self.restore()

    def restore(self) -> None:
        """The client has gone."""
        self.set_mode(GyroMode.ON if self.inside else GyroMode.OFF)

    def set_mode(self, mode: int) -> None:
        """GYRO."""
        self.mode = min(max(mode, GyroMode.OFF), GyroMode.ONLY)
        self._samples.clear()

    def advance(self, turn_rate: float, standing: bool, failed: bool, dt: float) -> None:
        """Take one step.

        Args:
            turn_rate: True, rad/s counter-clockwise.
            standing: The wheels do not turn.
            failed: The gyro gives nothing.
            dt: s.
        """
        self._age += dt
        if not self._cadence.advance(dt) or self.mode == GyroMode.OFF:
            return
        sample = DEAD if failed else self._gyro.sample(turn_rate, self._age)
        if self.inside:
            self._understand(sample, standing, failed)
        else:
            self._samples.append(sample)
            del self._samples[:-KEPT]

    def turned(self, standing: bool, failed: bool, dt: float) -> float | None:
        """Rad counter-clockwise that the heading turns in a step by the gyro; None where the wheels decide."""
        if not self.inside or failed or self.mode == GyroMode.OFF or (standing and self.mode == GyroMode.ON):
            return None
        return self.rate * dt

    def report(self) -> GyroReport:
        """The samples since the last report."""
        samples = tuple(self._samples)
        self._samples.clear()
        return GyroReport(samples)

    def _understand(self, sample: GyroSample, standing: bool, failed: bool) -> None:
        if failed:
            self.rate = 0.0
            return
        if standing:
            self._learnt += 1
            self._rest += (sample.rate - self._rest) * max(LEARNING, 1 / self._learnt)
        self.rate = (self._rest - sample.rate) * self._rate_of_count

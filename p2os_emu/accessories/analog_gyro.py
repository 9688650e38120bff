"""A rate gyro with the errors of a real one: offset, drift with temperature, and noise."""

from dataclasses import dataclass
from math import degrees, exp
from random import Random

from p2os.accessory_packets import GYRO_TEMPERATURE_TOP, GYRO_TOP, GyroSample


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalogGyroSpec:
    """A file of `configs/accessories`; deviations are those of normal distributions."""

    sample_period_s: float
    rest_count: float
    deg_s_per_count: float
    bias_counts: float
    scale_error: float
    bias_counts_per_k: float
    noise_counts: float
    ambient_deg_c: float
    warm_up_k: float
    warm_up_s: float
    temperature_count_at_0_deg_c: float
    temperature_counts_per_k: float


class AnalogGyro:
    """One gyro; its age is the time since it got power."""

    def __init__(self, spec: AnalogGyroSpec, rng: Random) -> None:
        self.spec = spec
        self._rng = rng
        self._rest = spec.rest_count + rng.gauss(0.0, spec.bias_counts)
        self._rest_per_k = rng.gauss(0.0, spec.bias_counts_per_k)
        self._counts_per_deg_s = (1.0 + rng.gauss(0.0, spec.scale_error)) / spec.deg_s_per_count

    def sample(self, turn_rate: float, age: float) -> GyroSample:
        """Take one reading.

        Args:
            turn_rate: True, rad/s counter-clockwise.
            age: s since power-on.
        """
        spec = self.spec
        warmth = spec.warm_up_k * (1.0 - exp(-age / spec.warm_up_s))
        rest = self._rest + self._rest_per_k * warmth
        count = rest - degrees(turn_rate) * self._counts_per_deg_s + self._rng.gauss(0.0, spec.noise_counts)
        celsius = spec.ambient_deg_c + warmth
        heat = spec.temperature_count_at_0_deg_c + celsius * spec.temperature_counts_per_k
        return GyroSample(_within(count, GYRO_TOP), _within(heat, GYRO_TEMPERATURE_TOP))


def _within(count: float, top: int) -> int:
    return max(0, min(top, round(count)))

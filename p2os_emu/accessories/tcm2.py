"""A TCM2 compass module: a three-axis magnetometer on a robot of steel, with tilt sensors."""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, radians, sin
from random import Random
from typing import NamedTuple

from p2os.accessory_packets import CompassReport

FULL_SCORE = 9
"""Of a calibration that went all the way round; the scores' scale is assumed."""
MICRO = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Tcm2Spec:
    """A file of `configs/accessories`; deviations are those of normal distributions."""

    period_s: float
    north_deg: float
    horizontal_t: float
    down_t: float
    hard_iron_t: float
    field_noise_t: float
    tilt_noise_deg: float
    temperature_deg_c: float


class _MagneticField(NamedTuple):
    """Magnetic field in the robot's axes, T: forward, right, down."""

    forward: float
    right: float
    down: float


class _Extent(NamedTuple):
    """The least and the most of the field that was seen, T."""

    least_forward: float
    most_forward: float
    least_right: float
    most_right: float

    @classmethod
    def of(cls, field: _MagneticField) -> "_Extent":
        """One field."""
        return cls(field.forward, field.forward, field.right, field.right)

    def including(self, field: _MagneticField) -> "_Extent":
        """This and one more."""
        return _Extent(
            min(self.least_forward, field.forward),
            max(self.most_forward, field.forward),
            min(self.least_right, field.right),
            max(self.most_right, field.right),
        )

    @property
    def width(self) -> float:
        """Of the narrower axis."""
        return min(self.most_forward - self.least_forward, self.most_right - self.least_right)

    @property
    def centre(self) -> tuple[float, float]:
        """What lies in the middle: forward, right."""
        return (self.least_forward + self.most_forward) / 2, (self.least_right + self.most_right) / 2


class Tcm2:
    """One module.

    The robot's own magnetism adds to the field, so that headings err by up to several degrees, until a calibration on
    the spot has measured it: that takes a full turn.
    """

    def __init__(self, spec: Tcm2Spec, rng: Random) -> None:
        self.spec = spec
        self._rng = rng
        self._hard_iron = _MagneticField(*(rng.gauss(0.0, spec.hard_iron_t) for _ in range(3)))
        self.reset()

    def reset(self) -> None:
        """Forget every calibration."""
        self._correction = (0.0, 0.0)
        self._scores = (0, 0, 0.0)
        self._calibrating = False
        self._seen: _Extent | None = None

    @property
    def is_calibrating(self) -> bool:
        """A calibration is under way."""
        return self._calibrating

    def begin_calibration(self) -> None:
        """Begin to measure the extent of the field; the robot should turn once around."""
        self._calibrating = True
        self._seen = None

    def end_calibration(self) -> None:
        """Take the offset of the measured field as the robot's own magnetism, if it was a whole turn."""
        seen = self._seen
        self._calibrating = False
        self._seen = None
        if seen is None:
            return
        turned = min(1.0, seen.width / (2 * self.spec.horizontal_t))
        strength = hypot(self.spec.horizontal_t, self.spec.down_t) / MICRO
        self._scores = (round(FULL_SCORE * turned), 0, strength)
        if self._scores[0] == FULL_SCORE:
            self._correction = seen.centre

    def measure(self, heading: float, nearby: tuple[float, float] = (0.0, 0.0)) -> CompassReport:
        """Take one reading.

        Args:
            heading: True, rad in the world, counter-clockwise.
            nearby: What stands around adds to the earth's field, T along the world's x and y.
        """
        field = self._field(heading, nearby)
        if self._calibrating:
            self._seen = (self._seen or _Extent.of(field)).including(field)
        forward, right = field.forward - self._correction[0], field.right - self._correction[1]
        spec, rng = self.spec, self._rng
        tilt = radians(spec.tilt_noise_deg)
        return CompassReport(
            heading=atan2(-right, forward) % (2 * pi),
            pitch=rng.gauss(0.0, tilt),
            roll=rng.gauss(0.0, tilt),
            field_x=forward,
            field_y=right,
            field_z=field.down,
            temperature=spec.temperature_deg_c,
            errors=0,
            h_score=self._scores[0],
            v_score=self._scores[1],
            m_score=self._scores[2],
        )

    def _field(self, heading: float, nearby: tuple[float, float]) -> _MagneticField:
        """What the magnetometer sees, with the iron of the robot and noise."""
        spec, iron, rng = self.spec, self._hard_iron, self._rng
        north = radians(spec.north_deg)
        x, y = spec.horizontal_t * cos(north) + nearby[0], spec.horizontal_t * sin(north) + nearby[1]
        forward, left = x * cos(heading) + y * sin(heading), y * cos(heading) - x * sin(heading)
        return _MagneticField(
            forward + iron.forward + rng.gauss(0.0, spec.field_noise_t),
            -left + iron.right + rng.gauss(0.0, spec.field_noise_t),
            spec.down_t + iron.down + rng.gauss(0.0, spec.field_noise_t),
        )

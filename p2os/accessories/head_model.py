"""Model of a camera head: axes, lens and times, from a file of `configs/accessories`. Angles are rad, REP 103."""

from dataclasses import dataclass
from enum import StrEnum
from math import atan, log, radians, tan

HEAD_PORT = 1
"""The AUX port of a camera head, as every client has it."""


class HeadKind(StrEnum):
    """The camera heads there are; the values name their files."""

    VCC4 = "vcc4"
    EVID30 = "evid30"


@dataclass(frozen=True, slots=True)
class HeadAxis:
    """Pan or tilt, as the head's controller counts it.

    lowest, highest: counts at the ends. deg_per_count: below zero where the wire counts against REP 103 (pan to the
    left, tilt up). slowest, fastest: speeds that may be set, in counts of speed. deg_s_per_count: what one is worth.
    """

    lowest: int
    highest: int
    deg_per_count: float
    slowest: int
    fastest: int
    deg_s_per_count: float

    @property
    def limits(self) -> tuple[float, float]:
        """The ends, rad, rising."""
        ends = self.angle(self.lowest), self.angle(self.highest)
        return min(ends), max(ends)

    @property
    def top_speed(self) -> float:
        """The most, rad/s."""
        return self.speed(self.fastest)

    def angle(self, count: float) -> float:
        """The angle at a count, rad."""
        return radians(count * self.deg_per_count) + 0.0  # no zero with a minus, which people would wonder at

    def count(self, angle: float) -> int:
        """The count nearest to an angle, rad, within the ends."""
        count = round(angle / radians(self.deg_per_count))
        return min(max(count, self.lowest), self.highest)

    def speed(self, count: float) -> float:
        """The speed of a speed count, rad/s."""
        return radians(count * self.deg_s_per_count)


@dataclass(frozen=True, slots=True)
class Lens:
    """The zoom.

    counts: at the narrow end; 0 is the wide one. ratio: magnification there; every count magnifies alike.
    travel_s: from end to end. wide_deg: horizontal field of view at the wide end.
    """

    counts: int
    ratio: float
    travel_s: float
    wide_deg: float

    def ratio_at(self, count: float) -> float:
        """The magnification at a count, which lies between the ends whatever a head says; 1 at the wide end."""
        return float(self.ratio ** (min(max(count, 0), self.counts) / self.counts))

    def count_at(self, ratio: float) -> int:
        """The count nearest to a magnification, within the ends."""
        return min(max(round(self.counts * log(max(ratio, 1.0), self.ratio)), 0), self.counts)

    def field_of_view(self, ratio: float) -> float:
        """Horizontal, at a magnification, rad."""
        return 2 * atan(tan(radians(self.wide_deg) / 2) / ratio)


@dataclass(frozen=True, slots=True)
class HeadModel:
    """One kind of head.

    baud: of its port, bit/s. starts_on: it has power as soon as the robot has. power_on_s: until it obeys after that.
    initialise_s: until it has found its zero.
    """

    name: str
    about: str
    baud: int
    starts_on: bool
    power_on_s: float
    initialise_s: float
    pan: HeadAxis
    tilt: HeadAxis
    lens: Lens

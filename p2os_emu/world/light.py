"""Light that changes: by a schedule, and by chance."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, isfinite, pi, radians, sin
from random import Random
from typing import NamedTuple

import numpy as np

DIRECTION = (2.0, -3.0, 6.0)
"""From where it comes."""
WAVES = 3
DIMMEST, BRIGHTEST = 0.05, 2.0


class LightState(NamedTuple):
    """The light of one moment. brightness: 1 where light never changes. direction: from where it comes."""

    brightness: float
    direction: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class _LightPoint:
    """One moment of a schedule: brightness (1 is full light) at a time, s."""

    at_s: float
    brightness: float


@dataclass(frozen=True, slots=True)
class Light:
    """How a world file describes light that changes.

    schedule: brightness at some times; between them it changes evenly, before and after it stays.
    drift: by how much of the schedule's brightness it changes at most, by the seed. turn_deg: by how much the direction
    wanders to each side, by the seed. period_s: how long one wave of a drift takes, about.
    """

    schedule: tuple[_LightPoint, ...] = ()
    drift: float = 0.0
    turn_deg: float = 0.0
    period_s: float = 20.0

    def check(self) -> None:
        """See that it makes sense.

        Raises:
            ValueError: A value is out of range, or the times do not rise.
        """
        times = [point.at_s for point in self.schedule]
        if not all(map(isfinite, times)) or any(after <= before for before, after in pairwise(times)):
            raise ValueError("at_s must rise from one entry of the schedule to the next")
        if not all(DIMMEST <= point.brightness <= BRIGHTEST for point in self.schedule):
            raise ValueError(f"brightness must be from {DIMMEST} to {BRIGHTEST:g}")
        if not 0.0 <= self.drift < 1.0:
            raise ValueError("drift must be at least 0 and less than 1")
        if not 0.0 <= self.turn_deg <= 180.0:
            raise ValueError("turn_deg must be from 0 to 180")
        if not 0.1 <= self.period_s < float("inf"):
            raise ValueError("period_s must be at least 0.1 s")


class LightCourse:
    """The light of one run: the same for the same description and seed."""

    def __init__(self, light: Light, seed: int) -> None:
        self._light = light
        self._brightness = _Drift(light.period_s, Random(f"{seed} light brightness"))
        self._turn = _Drift(light.period_s, Random(f"{seed} light direction"))

    def at(self, time: float) -> LightState:
        """Return the light at a time, s."""
        light, brightness = self._light, 1.0
        if light.schedule:
            times, values = zip(*((point.at_s, point.brightness) for point in light.schedule), strict=True)
            brightness = float(np.interp(time, times, values))
        brightness *= 1.0 + light.drift * self._brightness.at(time)
        x, y, z = DIRECTION
        heading = atan2(y, x) + radians(light.turn_deg) * self._turn.at(time)
        return LightState(brightness, (hypot(x, y) * cos(heading), hypot(x, y) * sin(heading), z))


class _Drift:
    """A smooth wandering between -1 and 1: a sum of waves of different periods and phases."""

    def __init__(self, period: float, rng: Random) -> None:
        self._waves: Sequence[tuple[float, float]] = [
            (2 * pi / (period * rng.uniform(0.6, 1.6)), rng.uniform(0.0, 2 * pi)) for _ in range(WAVES)
        ]

    def at(self, time: float) -> float:
        return sum(sin(rate * time + phase) for rate, phase in self._waves) / WAVES

"""Magnetic disturbances of a world: steel in the floor, motors, loudspeakers."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, hypot, radians, sin

NEAREST = 0.3  # m; nearer than this, one stands on it
MICRO = 1e-6


@dataclass(frozen=True, slots=True)
class Magnet:
    """Something magnetic: place, m; field that it adds 1 m away, T; where that points, rad in the world."""

    x: float
    y: float
    field: float
    direction: float


@dataclass(frozen=True, slots=True)
class MagnetEntry:
    """A magnet in a world file: place, field 1 m away in microtesla, where it points."""

    at_m: tuple[float, float]
    field_ut: float
    name: str = ""
    heading_deg: float = 0.0

    def magnet(self) -> Magnet:
        """The magnet in SI."""
        return Magnet(*self.at_m, self.field_ut * MICRO, radians(self.heading_deg))


def field_at(magnets: Iterable[Magnet], x: float, y: float) -> tuple[float, float]:
    """Return the disturbance of the earth's field at a place, T along the world's axes.

    A field that falls with the cube of the distance, as a dipole's does; that its direction turns as one walks round is
    left out.
    """
    along_x = along_y = 0.0
    for magnet in magnets:
        strength = magnet.field / max(NEAREST, hypot(x - magnet.x, y - magnet.y)) ** 3
        along_x += strength * cos(magnet.direction)
        along_y += strength * sin(magnet.direction)
    return along_x, along_y

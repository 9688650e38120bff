"""The direction in which an arm's hand points, and along which level line its fingers part."""

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ROUNDING = 1e-3  # rad by which an angle may lie beyond a limit: what people round


class ReachError(ValueError):
    """The tip cannot get to a point. The message says why, and where the nearest point is."""


@dataclass(frozen=True, slots=True, eq=False)
class HandDirection:
    """Where a hand points, and along which line its fingers part: unit vectors in `base_link`, shape (3,)."""

    ahead: Floats
    across: Floats

    @classmethod
    def of(cls, pitch: float, yaw: float) -> Self:
        """Return a direction below level with fingers that part level.

        Args:
            pitch: rad below level, -pi/2 to pi/2.
            yaw: rad to the left of the robot's front, -pi to pi.
        Raises:
            ReachError: An angle is out of its limits.
        """
        for name, angle, most in (("pitch", pitch, pi / 2.0), ("yaw", yaw, pi)):
            if not abs(angle) <= most + _ROUNDING:
                raise ReachError(f"{name} must be -{most:.4g} to {most:.4g} rad, not {angle:.4g}")
        ahead = np.array([cos(pitch) * cos(yaw), cos(pitch) * sin(yaw), -sin(pitch)])
        return cls(ahead, np.array([-sin(yaw), cos(yaw), 0.0]))

    def turn_from(self, other: "HandDirection") -> Floats:
        """Return the turn that brings a hand from another direction to this one, rad; fingers may change sides."""
        side = other.across if other.across @ self.across >= 0.0 else -other.across
        axes, goals = (other.ahead, side), (self.ahead, self.across)
        turn: Floats = np.cross(np.cross(*axes), np.cross(*goals)) / 2.0
        for axis, goal in zip(axes, goals, strict=True):
            turn = turn + np.cross(axis, goal) / 2.0
        return turn

    def roll_to(self, other: "HandDirection") -> float:
        """Return the shortest turn about this hand that brings its fingers to those of another one, rad."""
        c, s = float(self.across @ other.across), float(self.ahead @ np.cross(self.across, other.across))
        return float(np.arctan(s / c)) if c else pi / 2.0  # fingers may change sides

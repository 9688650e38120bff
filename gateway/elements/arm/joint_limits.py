"""Limits of a joint of any arm."""

from typing import NamedTuple


class JointLimits(NamedTuple):
    """Limits of one joint.

    lower, upper: its ends, rad; m of a gripper that opens. slowest, fastest: rad/s or m/s. slides: it is a gripper's.
    home: where it goes when it is sent home.
    """

    lower: float
    upper: float
    slowest: float
    fastest: float
    slides: bool = False
    home: float = 0.0

    @property
    def unit(self) -> str:
        """The unit of its position."""
        return "m" if self.slides else "rad"

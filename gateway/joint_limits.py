"""How far and how fast a joint goes, whatever moves it."""

from typing import NamedTuple


class JointLimits(NamedTuple):
    """Of one joint.

    lower, upper: its ends, rad; m of a gripper that opens. slowest, fastest: rad/s or m/s. slides: it is a gripper's.
    """

    lower: float
    upper: float
    slowest: float
    fastest: float
    slides: bool = False

    @property
    def unit(self) -> str:
        """Of its position."""
        return "m" if self.slides else "rad"

"""Door-like exits: their parameters, and an opening in a scan."""

from dataclasses import dataclass
from math import hypot


@dataclass(frozen=True, slots=True)
class DoorParameters:
    """Conditions for a door-like exit. Lengths in m.

    narrowest, widest: width of an opening. slack: measuring error of the width. usual: maximum width of a door; a wider
    opening is the mouth of a corridor. clear: minimum free depth behind the opening.
    beams: minimum number of beams that pass so far. share: minimum part of the beams at the opening that do. echoes:
    minimum part of these that hit something; without echoes the opening may be a black surface.
    wall: minimum length of wall in view, both sides together. wall_share: likewise, as part of the opening's width.
    least_wall, mouth_wall: minimum on each side, of a door and of a mouth.
    open_wall, free_wall: minimum on one side, of a wall with one end in the open, and with both. deep_wall: likewise,
    where a jamb is as deep as a cupboard. corridor_wall: minimum length of either wall of a corridor that ends, as part
    of its width.
    """

    narrowest: float
    widest: float
    usual: float
    slack: float
    clear: float
    beams: int
    share: float
    echoes: float
    wall: float
    wall_share: float
    least_wall: float
    mouth_wall: float
    open_wall: float
    free_wall: float
    deep_wall: float
    corridor_wall: float


@dataclass(frozen=True, slots=True)
class Opening:
    """An exit in the scanner's frame: its jambs, the unit normal away from the scanner, and its confidence."""

    left: tuple[float, float]
    right: tuple[float, float]
    normal: tuple[float, float]
    confidence: float

    @property
    def centre(self) -> tuple[float, float]:
        """The middle between the jambs."""
        return (self.left[0] + self.right[0]) / 2.0, (self.left[1] + self.right[1]) / 2.0

    @property
    def width(self) -> float:
        """Distance between the jambs, m."""
        return hypot(self.left[0] - self.right[0], self.left[1] - self.right[1])

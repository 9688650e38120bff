"""What is common to all door-like exits."""

from dataclasses import dataclass
from math import hypot


@dataclass(frozen=True, slots=True)
class DoorParameters:
    """What counts as a door-like exit. Lengths in m.

    narrowest, widest: of an opening; slack: by which it may be measured too narrow. usual: what is wider is no door but
    the mouth of a corridor. clear: free beyond it, at least.
    beams: that go through and so far, at least. share: of the beams that come to the opening, that must. echoes: of
    those that go through, that must meet something in the end: where there is no echo at all, it may as well be black.
    wall: in view, both sides together, at least; wall_share: likewise, as part of the opening's width. least_wall,
    mouth_wall: on either side, of a door and of a mouth.
    open_wall, free_wall: on one side at least, of a wall of which one end is in the open, and of which both are.
    deep_wall: likewise, where a jamb is as deep as a cupboard. corridor_wall: of either wall of a corridor that ends,
    as part of its width.
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
    """An exit in the scanner's frame: its jambs, the unit normal away from the scanner, confidence."""

    left: tuple[float, float]
    right: tuple[float, float]
    normal: tuple[float, float]
    confidence: float

    @property
    def centre(self) -> tuple[float, float]:
        """Half-way between the jambs."""
        return (self.left[0] + self.right[0]) / 2.0, (self.left[1] + self.right[1]) / 2.0

    @property
    def width(self) -> float:
        """From jamb to jamb, m."""
        return hypot(self.left[0] - self.right[0], self.left[1] - self.right[1])

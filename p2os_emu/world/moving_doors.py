"""Doors that open and shut, as data: a leaf that slides along its wall."""

import math
from dataclasses import dataclass

from geometry import Point, Pose2D
from p2os_emu.world.colours import check_colour
from p2os_emu.world.people import check_span

LEAF_THICKNESS = 0.04
"""m; less than a wall's, so that a leaf that stands open is out of sight in the wall."""
LEAF_HEIGHT = 2.0

Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class MovingDoor:
    """A leaf in a gap of a wall.

    jamb, post: the ends of the gap, m; the leaf shuts towards the post and opens past the jamb, into the wall.
    is_open: as the world begins.
    open_time, shut_time: the shortest and the longest time that it stays so by itself, s; None: until it is moved.
    speed: of the leaf, m/s.
    """

    name: str
    jamb: Point
    post: Point
    is_open: bool = True
    open_time: Span | None = None
    shut_time: Span | None = None
    speed: float = 0.6
    colour: str = "wood"

    @property
    def frame(self) -> Pose2D:
        """Pose of the jamb, m, rad, facing the post."""
        (x1, y1), (x2, y2) = self.jamb, self.post
        return Pose2D(x1, y1, math.atan2(y2 - y1, x2 - x1))

    @property
    def width(self) -> float:
        """Of the gap, m."""
        return math.dist(self.jamb, self.post)


@dataclass(frozen=True, slots=True)
class MovingDoorEntry:
    """A door with a leaf, in a world file: from one end of the gap, into which it opens, to the other."""

    name: str
    from_m: tuple[float, float]
    to_m: tuple[float, float]
    is_open: bool = True
    open_s: Span | None = None
    shut_s: Span | None = None
    speed_m_s: float = 0.6
    colour: str = "wood"

    def door(self) -> MovingDoor:
        """The door in SI.

        Raises:
            ValueError: A value makes no sense.
        """
        if self.from_m == self.to_m or not self.speed_m_s > 0.0:
            raise ValueError("from_m and to_m must differ, and speed_m_s must be above 0")
        for key, span in (("open_s", self.open_s), ("shut_s", self.shut_s)):
            if span is not None:
                check_span(key, span)
        check_colour(self.colour)
        return MovingDoor(
            self.name,
            self.from_m,
            self.to_m,
            self.is_open,
            self.open_s,
            self.shut_s,
            self.speed_m_s,
            self.colour,
        )

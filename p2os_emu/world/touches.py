"""Contacts of robots: the bumper segments that they press, and the collisions by which missions are judged."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from geometry import Point
from p2os_emu.surroundings import Touch, Touches

APART = 0.5
"""s without contact after which touching the same thing again counts again."""
REMEMBERED = 100
_EDGE = 1e-9  # of the way round; keeps the leftmost point within the last segment


@dataclass(frozen=True, slots=True)
class Bumper:
    """A bumper round half of the hull, from the axle on the right side to the axle on the left.

    Its segments have equal shares of that way, counted from right to left in front and behind.

    reach: m from the axle to the end of the hull. width: of the hull, m.
    """

    segments: int
    reach: float
    width: float

    def pressed(self, contacts: Iterable[Point]) -> int:
        """Segments that one obstacle presses.

        Args:
            contacts: Where the obstacle touches this half of the hull: (m along the hull from the axle, never negative;
                m to the left). A flat obstacle is known by the ends of its contact; what lies between is pressed too.
        Returns:
            Bit i is set while segment i + 1 is pressed.
        """
        if not self.segments:
            return 0
        places = [self._segment(along, left) for along, left in contacts]
        return sum(1 << segment for segment in range(min(places), max(places) + 1)) if places else 0

    def _segment(self, along: float, left: float) -> int:
        """Index of the segment nearest to a point of the hull."""
        way = 2 * self.reach + self.width
        along, left = min(along, self.reach), max(-self.width / 2, min(left, self.width / 2))
        from_side, from_end = self.width / 2 - abs(left), self.reach - along
        on_end, on_side = self.reach + self.width / 2 + left, along if left < 0 else way - along
        walked = on_end if from_end <= from_side else on_side
        return int(min(max(walked / way, 0.0), 1.0 - _EDGE) * self.segments)


class TouchLog:
    """All touches of one robot."""

    def __init__(self) -> None:
        self._count = 0
        self._last: deque[Touch] = deque(maxlen=REMEMBERED)
        self._until: dict[str, float] = {}

    def note(self, time: float, names: Iterable[str]) -> None:
        """Take in what the robot is in contact with at this step."""
        for name in names:
            if time > self._until.get(name, -1.0):
                self._count += 1
                self._last.append(Touch(time, name))
            self._until[name] = time + APART

    @property
    def touches(self) -> Touches:
        """All so far."""
        return Touches(self._count, tuple(self._last))

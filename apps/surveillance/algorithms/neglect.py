"""When rooms were visited, and how long they were neglected."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RoomVisit:
    """A visit of a room. time: s. after: s since the visit before, or since the beginning."""

    time: float
    room: str
    robot: str
    after: float


class NeglectLedger:
    """Visits of all rooms. Times are s on any steady clock. begun: when it began."""

    def __init__(self, rooms: Iterable[str], now: float) -> None:
        """Begin; all rooms count as visited now."""
        self.begun = now
        self.visits: list[RoomVisit] = []
        self._last = dict.fromkeys(rooms, now)
        self._longest = dict.fromkeys(self._last, 0.0)

    @property
    def rooms(self) -> tuple[str, ...]:
        """All rooms."""
        return tuple(self._last)

    def visit(self, room: str, robot: str, now: float) -> None:
        """Note a visit; of an unknown room, nothing."""
        if room in self._last:
            after = now - self._last[room]
            self.visits.append(RoomVisit(now, room, robot, after))
            self._longest[room] = max(self._longest[room], after)
            self._last[room] = now

    def neglect(self, now: float) -> dict[str, float]:
        """How long each room has not been visited, s."""
        return {room: now - last for room, last in self._last.items()}

    def longest(self, now: float) -> Mapping[str, float]:
        """The longest neglect of each room so far, s, the present one included."""
        return {room: max(self._longest[room], now - last) for room, last in self._last.items()}

    def count(self, room: str) -> int:
        """How often a room was visited."""
        return sum(each.room == room for each in self.visits)

"""The rooms of one robot: what it bids for more, which one it visits next, and which it cannot reach."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

from apps.surveillance.algorithms.floor import PatrolFloor, travel_times
from apps.surveillance.algorithms.tours import best_tour, entered, improved, period, with_room
from apps.surveillance.settings import PatrolSettings
from geometry import Point

_WORST_COUNTS = 8  # power of periods in the gain of a trade: nearly the longer one alone, and yet not quite


@dataclass(frozen=True, slots=True)
class RoomBid:
    """What a robot proposes: to take a room, after which its tour lasts `period` s, `added` s longer. way: m to it."""

    room: str
    period: float
    added: float
    way: float

    @property
    def rank(self) -> tuple[float, float, float]:
        """The lower, the better for the team: its longest neglect is the longest period."""
        return self.period, self.added, self.way


@dataclass(frozen=True, slots=True)
class RoomTrade:
    """What a robot proposes to another one: to take a room of it, and to give a room back, or none if empty.

    mine, theirs: periods of both afterwards, s. gain: what both periods are then, as a share of what they were, the
    longer one counting most; below 1 the team is better off.
    """

    room: str
    back: str
    mine: float
    theirs: float
    gain: float


class RoomPlan:
    """Which rooms one robot visits, and in which order. Times are s on any steady clock."""

    def __init__(self, rooms: Mapping[str, Point], floor: PatrolFloor, settings: PatrolSettings) -> None:
        """Begin without rooms of its own.

        Args:
            rooms: All rooms of the patrol, m in `map`.
            floor: Of the map, for this robot.
            settings: Of the visits.
        """
        self.rooms = dict(rooms)
        self._floor, self._settings = floor, settings
        self._names = list(rooms)
        each = settings.corner_s + settings.dwell_s
        self._times = travel_times(floor.lengths(list(rooms.values())), settings.speed_m_s, each)
        self._order: list[int] = []
        self._next: int | None = None
        self._visited_at: dict[str, float] = {}
        self._attempts: dict[str, int] = {}
        self._barred_until: dict[str, float] = {}
        self._failed: set[str] = set()  # rooms that could not be reached since it last got somewhere
        self.are_seen: set[str] = set()

    @property
    def order(self) -> tuple[str, ...]:
        """Its rooms in the order of the tour, the next one first."""
        at = self._order.index(self._next) if self._next in self._order else 0
        return tuple(self._names[room] for room in self._order[at:] + self._order[:at])

    @property
    def period(self) -> float:
        """How long the tour lasts, s."""
        return period(self._order, self._times)

    @property
    def is_stuck(self) -> bool:
        """Whether it could not reach several rooms in a row."""
        return len(self._failed) >= self._settings.stuck_rooms

    def bid(self, offered: Iterable[str], place: Point, now: float) -> RoomBid | None:
        """Return the best proposal for one of some rooms; None where the robot can reach none of them."""
        bids = [self._bid(room, place) for room in offered if self._can_take(room, place, now)]
        return min(bids, key=lambda each: (*each.rank, each.room), default=None)

    def trade(self, theirs: Sequence[str], place: Point, now: float) -> RoomTrade | None:
        """Return the best trade with a robot that has these rooms; None where no trade is a gain.

        Trades of one or two rooms find good divisions that auctions of single rooms miss.
        """
        other = improved([self._names.index(room) for room in theirs if room in self.rooms], self._times)
        before = self.period**_WORST_COUNTS + period(other, self._times) ** _WORST_COUNTS
        best: RoomTrade | None = None
        for taken in other:
            if not self._can_take(self._names[taken], place, now):
                continue
            left = [each for each in other if each != taken]
            for back in (None, *self._order):
                kept = [each for each in self._order if each != back]
                mine = period(improved(with_room(kept, taken, self._times), self._times), self._times)
                given = left if back is None else with_room(left, back, self._times)
                rest = period(improved(given, self._times), self._times)
                gain = (mine**_WORST_COUNTS + rest**_WORST_COUNTS) / before
                if gain < (best.gain if best is not None else 1.0):
                    name = "" if back is None else self._names[back]
                    best = RoomTrade(self._names[taken], name, mine, rest, gain)
        return best

    def take(self, room: str, place: Point, now: float, neglected: float, *, is_seen: bool) -> None:
        """Take a room.

        Args:
            room: Its name.
            place: Of the robot, m.
            now: s.
            neglected: s since the last visit of the room, by any robot.
            is_seen: Whether a robot has been there.
        """
        index = self._names.index(room)
        if is_seen:
            self.are_seen.add(room)
        self._visited_at[room] = now - neglected
        if index not in self._order:
            self._order = best_tour([*self._order, index], self._times)
        self.enter(place, now)

    def give_up(self, room: str) -> None:
        """Have no more to do with a room."""
        self._order = improved([each for each in self._order if self._names[each] != room], self._times)
        if self._next is not None and self._names[self._next] == room:
            self._next = self._order[0] if self._order else None

    def enter(self, place: Point, now: float) -> None:
        """Begin the tour anew where the longest neglect will be shortest, as after an errand."""
        if not self._order:
            self._next = None
            return
        each = self._settings.corner_s + self._settings.dwell_s
        to_rooms = [
            self._floor.length(self.rooms[name], place) / self._settings.speed_m_s + each for name in self._names
        ]
        neglect = [now - self._visited_at.get(name, now) for name in self._names]
        self._order = entered(self._order, to_rooms, neglect, self._times)
        self._next = self._order[0]

    def next_room(self) -> str | None:
        """Return where to go; None without rooms."""
        return None if self._next is None else self._names[self._next]

    def visited(self, room: str, now: float) -> None:
        """Note that the robot has been in a room, and go on to the next."""
        self._visited_at[room] = now
        self._attempts.pop(room, None)
        self._failed.clear()
        self.are_seen.add(room)
        self._advance(room)

    def missed(self, room: str, now: float) -> bool:
        """Note that the robot could not reach a room, and go on; return whether it gives the room back."""
        attempts = self._attempts[room] = self._attempts.get(room, 0) + 1
        self._failed.add(room)
        self._advance(room)
        if attempts < self._settings.attempts:
            return False
        del self._attempts[room]
        self._barred_until[room] = now + self._settings.barred_s
        self.give_up(room)
        return True

    def has_moved(self) -> None:
        """Note that the robot has got somewhere, so that it is not stuck."""
        self._failed.clear()

    def way(self, target: Point, place: Point) -> float:
        """Length of the way from where the robot is to a target, m; infinite where there is none."""
        return self._floor.length(place, target)

    def _advance(self, room: str) -> None:
        if not self._order:
            self._next = None
        elif self._next is not None and self._names[self._next] == room:
            self._next = self._order[(self._order.index(self._next) + 1) % len(self._order)]

    def _can_take(self, room: str, place: Point, now: float) -> bool:
        if room not in self.rooms or now < self._barred_until.get(room, -inf):
            return False
        others: Sequence[Point] = [self.rooms[self._names[each]] for each in self._order[:1]]
        return all(isfinite(self._floor.length(self.rooms[room], each)) for each in (place, *others))

    def _bid(self, room: str, place: Point) -> RoomBid:
        index = self._names.index(room)
        order = (
            self._order if index in self._order else improved(with_room(self._order, index, self._times), self._times)
        )
        after = period(order, self._times)
        return RoomBid(room, after, after - self.period, self._floor.length(self.rooms[room], place))

"""Reasons and ends of waiting."""

from dataclasses import dataclass, replace
from math import inf

from apps.indoor_navigation.data import Place

FIRST_REQUEST = 1.0  # s of waiting after which whoever is in the way is asked to let the robot pass
MIN_INTERVAL = 15.0  # s before the robot makes way again, so that it can drive on meanwhile
FARTHER = 5.0  # m driven since the robot made way, after which it meets others and counts anew


@dataclass(frozen=True, slots=True)
class Waiting:
    """Waiting ends with a way within the budget, at the time `until`, s, or when the obstacle is found to be a wall.

    why: reason in words. since: s. cost: of the way without the obstacle; `inf` if any way ends waiting. place: where
    the way is barred, if known. is_last_hope: whether there is no other way. passages: that another robot has.
    is_aside: whether the robot has gone aside to wait.
    """

    why: str
    since: float
    until: float
    cost: float = inf
    place: Place | None = None
    is_last_hope: bool = False
    passages: frozenset[str] = frozenset()
    is_aside: bool = False

    @property
    def hopes(self) -> bool:
        """Whether the robot waits for an obstacle to go away."""
        return self.is_last_hope or self.cost < inf

    def budget(self, now: float, detour: float, speed: float) -> float:
        """Return the cost of a way that ends waiting: with a detour as long as the time waited, or a short one, m."""
        return self.cost + detour + speed * (now - self.since)

    def aside(self, until: float) -> "Waiting":
        """Return the same waiting aside, until this time at least."""
        why = self.why if self.is_aside else f"aside, since {self.why}"
        return replace(self, why=why, until=max(self.until, until), is_aside=True)


FOR_SIGHT = Waiting("nothing is seen; see whether sonar and laser work", -inf, inf)


class MakingWay:
    """Counts how often the robot went aside: a person in its way may be waiting for the robot to let them pass.

    waiting: continues when the robot is aside; None while it does not make way.
    """

    def __init__(self, most: int) -> None:
        """most: maximum number of times in one neighbourhood."""
        self._most = self._left = most
        self._went = self._travelled = -inf
        self.waiting: Waiting | None = None

    def is_worth(self, now: float, travelled: float) -> bool:
        """Return whether the robot may go aside at s. travelled: m of this mission."""
        return self._left_at(travelled) > 0 and now - self._went >= MIN_INTERVAL

    def begin(self, waiting: Waiting, travelled: float) -> None:
        """Begin to go aside."""
        self._left = self._left_at(travelled) - 1
        self._travelled = travelled
        self.waiting = waiting

    def _left_at(self, travelled: float) -> int:
        return self._most if travelled - self._travelled > FARTHER else self._left

    def end(self, now: float) -> None:
        """End going aside at s."""
        if self.waiting is not None:
            self.waiting, self._went = None, now


class WayRequests:
    """Requests to whoever is in the way to let the robot pass: some while it waits, never close to each other."""

    def __init__(self, period: float, most: int) -> None:
        """period: s from one to the next. most: of them while the robot waits."""
        self._period, self._most = period, most
        self._left, self._next = 0, -inf

    def begin(self, now: float) -> None:
        """Begin to wait at s."""
        self._left, self._next = self._most, max(self._next, now + FIRST_REQUEST)

    @property
    def have_begun(self) -> bool:
        """Whether the robot has asked since it began to wait."""
        return self._left < self._most

    def is_due(self, now: float) -> bool:
        """Return whether to ask now, and count it."""
        if self._left == 0 or now < self._next:
            return False
        self._left, self._next = self._left - 1, now + self._period
        return True

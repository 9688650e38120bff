"""What the robot waits for, and for how long."""

from dataclasses import dataclass, replace
from math import inf

from apps.indoor_navigation.data import Place

AGAIN = 15.0  # s before the robot makes way once more


@dataclass(frozen=True, slots=True)
class Waiting:
    """Ends with a way within the budget, at the time until, s, or when what bars the way turns out to be a wall.

    why: in words. since: s. cost: of the way if nothing were on it; `inf` where any way will do. place: where the way
    is barred, if it is known. is_last_hope: if that does not go, there is no way.
    """

    why: str
    since: float
    until: float
    cost: float = inf
    place: Place | None = None
    is_last_hope: bool = False

    @property
    def hopes(self) -> bool:
        """Whether something must go that may go."""
        return self.is_last_hope or self.cost < inf

    def budget(self, now: float, detour: float, speed: float) -> float:
        """Cost of a way that is worth it: a detour that takes no longer than the robot has waited, or is short, m."""
        return self.cost + detour + speed * (now - self.since)

    def aside(self, until: float) -> "Waiting":
        """The same, aside, and not ended before this time."""
        return replace(self, why=f"aside, since {self.why}", until=max(self.until, until))


FOR_SIGHT = Waiting("nothing is seen; see whether sonar and laser work", -inf, inf)


class MakingWay:
    """Who stands in the way may be waiting for the robot to go out of theirs, so it goes aside now and then.

    waiting: what it goes on to wait for when it is aside; None while it does not make way.
    """

    def __init__(self, most: int) -> None:
        """most: times on one mission."""
        self._left = most
        self._went = -inf
        self.waiting: Waiting | None = None

    def is_worth(self, now: float) -> bool:
        """Whether it may be of use now, s."""
        return self._left > 0 and now - self._went >= AGAIN

    def begin(self, waiting: Waiting) -> None:
        """Go aside."""
        self._left -= 1
        self.waiting = waiting

    def end(self, now: float) -> None:
        """The robot is aside, or does something else."""
        if self.waiting is not None:
            self.waiting, self._went = None, now

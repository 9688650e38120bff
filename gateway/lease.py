"""The sole right to move one robot, or one element of it, for a while.

While someone holds the lease on the robot, or on the element that a command moves, only commands with that lease's
token move it. A lease ends by release, by expiry, or by a holder of higher priority. A token of the past never moves
anything again, so a holder that does not know that it has lost the lease does no harm.
"""

from collections.abc import Callable, Iterable
from math import inf, isfinite
from typing import Any

from gateway.errors import CommandRefused

ROBOT = "robot"
"""What a lease on everything is on; the other leases are on elements."""
DEFAULT_SECONDS = 5.0
LONGEST_SECONDS = 60.0


class _Lease:
    """The right to move one thing. No clock: call `expire` with the steady time before anything else.

    what: an element's name, or `ROBOT`. holder: the name it gave, None while the thing is free. priority: of the
    holder. deadline: when the lease ends without renewal, s; infinite without a holder.
    """

    def __init__(self, what: str, new_token: Callable[[], str]) -> None:
        self._new_token = new_token
        self._token = ""
        self._seconds = 0.0
        self.what = what
        self.deadline = inf
        self.holder: str | None = None
        self.priority = 0

    def is_held_with(self, token: str) -> bool:
        """Return whether this token is that of the present holder."""
        return self.holder is not None and token == self._token

    def yield_to(self, priority: int, now: float) -> None:
        """Check that a client of this priority may take the lease.

        Raises:
            CommandRefused: Its holder is of the same priority or a higher one.
        """
        if self.holder is not None and priority <= self.priority:
            raise CommandRefused(
                f"{self._held}, priority {self.priority}, for another {self.deadline - now:.1f} s; "
                "wait, or ask with a higher priority"
            )

    def take(self, holder: str, priority: int, seconds: float, now: float) -> str:
        """Make a client the holder in place of the present one; return the token.

        Args:
            holder: A name for people.
            priority: A higher one takes the lease from its holder.
            seconds: How long without `renew`.
            now: Steady time, s.
        Raises:
            CommandRefused: The arguments make no sense.
        """
        if not holder:
            raise CommandRefused("a lease needs a holder; send a name")
        self._seconds = _checked(seconds)
        self._token = self._new_token()
        self.holder, self.priority = holder, priority
        self.deadline = now + self._seconds
        return self._token

    def renew(self, seconds: float | None, now: float) -> None:
        """Extend the lease by the same duration, or by another, s."""
        if seconds is not None:
            self._seconds = _checked(seconds)
        self.deadline = now + self._seconds

    def end(self) -> None:
        """End the lease."""
        self._token = ""
        self.deadline = inf
        self.holder, self.priority = None, 0

    def refusal(self) -> CommandRefused:
        """Return the error for a command without the lease's token."""
        return CommandRefused(f"{self._held}; a command needs its token")

    def state(self, now: float) -> dict[str, Any]:
        """Return what is published: holder, priority, and seconds left; never the token."""
        left = None if self.holder is None else round(max(0.0, self.deadline - now), 3)
        return {"holder": self.holder, "priority": self.priority, "expires_in": left}

    def told(self, now: float) -> dict[str, Any]:
        """Return the reply to its holder."""
        return {"element": self.what, **self.state(now)}

    @property
    def _held(self) -> str:
        return f"{self.holder} holds the lease on the {self.what}"


class Leases:
    """All leases of one robot: either one on the robot, or any on its elements.

    What a change of holders brings to an end is returned as the names of what has to stand still, `ROBOT` for all.
    """

    def __init__(self, new_token: Callable[[], str], elements: Iterable[str]) -> None:
        """Begin without holders.

        Args:
            new_token: Makes one that cannot be guessed.
            elements: What can move.
        """
        self.robot = _Lease(ROBOT, new_token)
        self._elements = {name: _Lease(name, new_token) for name in sorted(elements)}

    @property
    def deadline(self) -> float:
        """When the next lease ends without renewal, s."""
        return min(lease.deadline for lease in self._all)

    def take(self, what: str, holder: str, priority: int, seconds: float, now: float) -> tuple[_Lease, str, list[str]]:
        """Give a lease to a client; return the lease, its token, and what has to stand still.

        Args:
            what: An element, or `ROBOT`, which takes the place of the leases on all elements.
            holder: A name for people.
            priority: A higher one takes the lease from its holder.
            seconds: How long without `renew`.
            now: Steady time, s.
        Raises:
            CommandRefused: Held by someone of the same priority or a higher one, or the arguments make no sense.
        """
        lease = self.robot if what == ROBOT else self._elements.get(what)
        if lease is None:
            raise CommandRefused(f"there is no lease on {what!r}; what moves is {', '.join(self._elements)}")
        rivals = self._all if lease is self.robot else [self.robot, lease]
        for rival in rivals:
            rival.yield_to(priority, now)
        token = lease.take(holder, priority, seconds, now)
        ended = [rival for rival in rivals if rival is not lease and rival.holder is not None]
        for rival in ended:
            rival.end()
        return lease, token, [ROBOT] if self.robot in [lease, *ended] else [what]

    def renew(self, token: str, seconds: float | None, now: float) -> _Lease:
        """Extend a lease by the same duration, or by another, s.

        Raises:
            CommandRefused: The token is not that of a present holder.
        """
        lease = self._held_with(token)
        lease.renew(seconds, now)
        return lease

    def release(self, token: str) -> _Lease:
        """End the lease of a token.

        Raises:
            CommandRefused: The token is not that of a present holder.
        """
        lease = self._held_with(token)
        lease.end()
        return lease

    def expire(self, now: float) -> list[str]:
        """End the leases whose time is over; return what has to stand still."""
        over = [lease for lease in self._all if now >= lease.deadline]
        for lease in over:
            lease.end()
        return [lease.what for lease in over]

    def check(self, element: str, token: str) -> None:
        """Check that a command may move an element.

        Raises:
            CommandRefused: Someone else holds the lease on it or on the robot, or the token is of the past.
        """
        held = [lease for lease in (self.robot, self._elements[element]) if lease.holder is not None]
        if any(lease.is_held_with(token) for lease in held):
            return
        if held:
            raise held[0].refusal()
        if token and not any(lease.is_held_with(token) for lease in self._all):
            raise CommandRefused("the token is of a lease that has ended; take the lease again")

    def state(self, now: float) -> dict[str, Any]:
        """Return what is published: the lease on the robot, and under `elements` the leases held on elements."""
        held = {name: lease.state(now) for name, lease in self._elements.items() if lease.holder is not None}
        return {**self.robot.state(now), "elements": held}

    @property
    def _all(self) -> list[_Lease]:
        return [self.robot, *self._elements.values()]

    def _held_with(self, token: str) -> _Lease:
        for lease in self._all:
            if lease.is_held_with(token):
                return lease
        raise CommandRefused("this token does not hold the lease; take it again")


def _checked(seconds: float) -> float:
    if not (isfinite(seconds) and 0.0 < seconds <= LONGEST_SECONDS):
        raise CommandRefused(
            f"a lease of {seconds} s is not possible; ask for up to {LONGEST_SECONDS:g} s and renew it"
        )
    return seconds

"""The sole right to move one robot, for a while. While someone holds it, only commands with its token move the robot.

A lease ends by release, by expiry, or by a holder of higher priority. A token of the past never moves the robot again,
so a holder that does not know that it has lost the lease does no harm.
"""

from collections.abc import Callable
from math import inf, isfinite
from typing import Any

from gateway.errors import CommandRefused

DEFAULT_SECONDS = 5.0
LONGEST_SECONDS = 60.0


class Lease:
    """Who may move the robot. No clock: call `expire` with the steady time before anything else.

    holder: the name it gave, None while the robot is free. priority: of the holder.
    """

    def __init__(self, new_token: Callable[[], str]) -> None:
        self._new_token = new_token
        self._token = ""
        self._seconds = 0.0
        self._expires_at = inf
        self.holder: str | None = None
        self.priority = 0

    @property
    def deadline(self) -> float:
        """When the lease ends if nobody renews it, s; infinite while nobody holds it."""
        return self._expires_at

    def take(self, holder: str, priority: int, seconds: float, now: float) -> str:
        """Become the holder; return the token.

        Args:
            holder: A name for people.
            priority: A higher one takes the lease from whoever holds it.
            seconds: How long without `renew`.
            now: Steady time, s.
        Raises:
            CommandRefused: Held by someone of the same priority or a higher one, or the arguments make no sense.
        """
        if not holder:
            raise CommandRefused("a lease needs a holder; say who you are")
        if self.holder is not None and priority <= self.priority:
            left = self._expires_at - now
            raise CommandRefused(f"{self.holder} holds the lease, priority {self.priority}, for another {left:.1f} s")
        self._seconds = _checked(seconds)
        self._token = self._new_token()
        self.holder, self.priority = holder, priority
        self._expires_at = now + self._seconds
        return self._token

    def renew(self, token: str, seconds: float | None, now: float) -> None:
        """Hold on for as long again, or for as many seconds as said.

        Raises:
            CommandRefused: The token is not that of the present holder.
        """
        self._check(token)
        if seconds is not None:
            self._seconds = _checked(seconds)
        self._expires_at = now + self._seconds

    def release(self, token: str) -> None:
        """Let go.

        Raises:
            CommandRefused: The token is not that of the present holder.
        """
        self._check(token)
        self._end()

    def expire(self, now: float) -> bool:
        """End the lease if its time is over; say whether it ended just now."""
        if now < self._expires_at:
            return False
        self._end()
        return True

    def check(self, token: str) -> None:
        """Let a command pass.

        Raises:
            CommandRefused: Someone else holds the lease, or the token is of the past.
        """
        if token == self._token:
            return
        if self.holder is None:
            raise CommandRefused("the token is of a lease that has ended; take the lease again")
        raise CommandRefused(f"{self.holder} holds the lease; a command needs its token")

    def state(self, now: float) -> dict[str, Any]:
        """As it is published: holder, priority, and seconds left; never the token."""
        left = None if self.holder is None else round(max(0.0, self._expires_at - now), 3)
        return {"holder": self.holder, "priority": self.priority, "expires_in": left}

    def _check(self, token: str) -> None:
        if self.holder is None or token != self._token:
            raise CommandRefused("this token does not hold the lease; take it anew")

    def _end(self) -> None:
        self._token = ""
        self._expires_at = inf
        self.holder, self.priority = None, 0


def _checked(seconds: float) -> float:
    if not (isfinite(seconds) and 0.0 < seconds <= LONGEST_SECONDS):
        raise CommandRefused(
            f"a lease of {seconds} s is not possible; ask for up to {LONGEST_SECONDS:g} s and renew it"
        )
    return seconds

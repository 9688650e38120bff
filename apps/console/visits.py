"""The pages that browsers have opened, and their ends."""

import asyncio
import math
import secrets
import time
from collections import deque
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass, field

from apps.web.certificates import why_expired

_MOST_OUTCOMES = 50


@dataclass(slots=True, eq=False)
class Visit:
    """One page in one browser.

    ticket: secret part of the addresses of its websockets. name: for people. session: with which it was opened; empty
    where no password is asked for. robot: which it shows; empty for none. sockets: by which its browser drives.
    outcomes: of the latest commands, the newest first: time of the day and words. outcome_count: of all of them.
    motions: requests that its browser began; they are cancelled when it is gone. on_end: ends the page itself, when its
    session ends or its certificate expires; called with the reason in words, empty for somebody who has logged out.
    look_only: why it can command nothing, in words; empty if it can. owner: of its certificate; empty
    without one. expires: when that does, s since 1970.
    """

    ticket: str
    name: str
    session: str = ""
    robot: str = ""
    sockets: int = 0
    outcomes: deque[tuple[str, str]] = field(default_factory=lambda: deque(maxlen=_MOST_OUTCOMES))
    outcome_count: int = 0
    motions: "set[asyncio.Task[None]]" = field(default_factory=set)
    on_end: Callable[[str], None] | None = None
    look_only: str = ""
    owner: str = ""
    expires: float = math.inf

    @property
    def may_command(self) -> bool:
        """Whether it can command robots and agents."""
        return not self.look_only

    def tell(self, clock: str, words: str) -> None:
        """Note what has happened, at a time of the day."""
        self.outcomes.appendleft((clock, words))
        self.outcome_count += 1

    def cancel_motions(self) -> None:
        """Cancel what it has set in motion."""
        for motion in self.motions:
            motion.cancel()


class Visits:
    """The pages that are open."""

    def __init__(self, release: Callable[[Visit, str], Awaitable[None]], look_only: str = "") -> None:
        """Begin without any.

        Args:
            release: Stops what a page drives, and gives back its leases; called with the reason in words.
            look_only: Why no page can command anything, in words; empty if the role on the bus permits it.
        """
        self._release, self._look_only = release, look_only
        self._by_ticket: dict[str, Visit] = {}
        self._count = 0

    def __contains__(self, ticket: str) -> bool:
        return ticket in self._by_ticket

    def get(self, ticket: str) -> Visit | None:
        """Return a page by the secret part of its addresses; None if it has ended, or never was."""
        return self._by_ticket.get(ticket)

    def begin(
        self, browser: str, session: str = "", look_only: str = "", owner: str = "", expires: float = math.inf
    ) -> Visit:
        """Return the state of a new page.

        Args:
            browser: Its address.
            session: With which it was opened.
            look_only: Why the browser may command nothing, in words; empty if it may what this program may.
            owner: Of its certificate; empty without one.
            expires: When that certificate does, s since 1970.
        """
        self._count += 1
        name = f"page {self._count} ({owner or browser})"
        look_only = self._look_only or look_only
        visit = Visit(secrets.token_urlsafe(16), name, session, look_only=look_only, owner=owner, expires=expires)
        self._by_ticket[visit.ticket] = visit
        return visit

    async def end(self, visit: Visit) -> None:
        """Forget a page; what it drove is stopped."""
        self._by_ticket.pop(visit.ticket, None)
        visit.cancel_motions()
        await self._release(visit, "the page was closed")

    async def end_session(self, session: str, why: str) -> None:
        """End all pages of a session; why: in words, empty for somebody who has logged out."""
        await self._end_all((each, why) for each in self._by_ticket.values() if each.session == session)

    async def end_expired(self) -> None:
        """End the pages of browsers whose certificates have expired."""
        now = time.time()
        expired = [each for each in self._by_ticket.values() if now >= each.expires]
        await self._end_all((each, why_expired(each.owner, each.expires)) for each in expired)

    async def _end_all(self, ended: Iterable[tuple[Visit, str]]) -> None:
        """End pages that may stay no longer.

        All at once: leases that are given back slowly, or an error, keep no other robot from being stopped.
        """
        await asyncio.gather(*(self._end_by_rule(visit, why) for visit, why in list(ended)))

    async def _end_by_rule(self, visit: Visit, why: str) -> None:
        """End a page. From now on it can command nothing, though its browser is there."""
        visit.look_only = visit.look_only or why or "you have logged out"
        try:
            if visit.on_end is not None:
                visit.on_end(why)
        finally:
            await self.end(visit)

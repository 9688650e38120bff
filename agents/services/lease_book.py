"""The book of an arbiter: the leases that it has given, and the claims that wait. No bus, no clock."""

import asyncio
from dataclasses import dataclass, field
from typing import Any

from agents.platform import AgentName
from agents.services.leases import LeaseTarget
from bus import Refused


@dataclass(frozen=True, slots=True)
class Wish:
    """A request for a lease. seconds: how long it lasts without a renewal."""

    place: LeaseTarget
    holder: AgentName
    priority: int
    seconds: float

    def told(self) -> dict[str, Any]:
        """Return the public part as JSON."""
        return {
            "element": str(self.place),
            "holder": str(self.holder),
            "priority": self.priority,
            "seconds": self.seconds,
        }


@dataclass(slots=True, eq=False)
class Grant:
    """A lease.

    seconds: how long it lasts from each renewal. expires_at: s of the loop's time, a little
    earlier than by the gateway's clock. timer: expires then.
    """

    id: str
    wish: Wish
    token: str
    seconds: float
    expires_at: float
    is_renewed: bool = False
    timer: asyncio.TimerHandle | None = None

    @property
    def place(self) -> LeaseTarget:
        """The target of the lease."""
        return self.wish.place

    @property
    def holder(self) -> AgentName:
        """The holder."""
        return self.wish.holder

    @property
    def priority(self) -> int:
        """The priority."""
        return self.wish.priority

    def told(self) -> dict[str, Any]:
        """Return the part for its holder as JSON, without the token."""
        return {"lease": self.id, "element": str(self.place), "priority": self.priority, "seconds": self.seconds}


@dataclass(slots=True, eq=False)
class Claim:
    """A request that waits for holders. stirred: set when something has changed. outbid_by: who outbid it."""

    wish: Wish
    stirred: asyncio.Event = field(default_factory=asyncio.Event)
    outbid_by: str = ""


class Book:
    """The leases and the claims that wait. grants: by id."""

    def __init__(self) -> None:
        """Make an empty book."""
        self.grants: dict[str, Grant] = {}
        self._claims: list[Claim] = []

    def claim(self, wish: Wish) -> Claim:
        """Add a claim; waiting claims with a lower priority are outbid.

        Raises:
            Refused: Another holds it or waits for it with the same priority or a higher one.
        """
        waiting = [claim for claim in self._claims if claim.wish.place.conflicts_with(wish.place)]
        for rival in (*(grant.wish for grant in self.held_against(wish)), *(claim.wish for claim in waiting)):
            if wish.priority <= rival.priority:
                raise Refused(
                    f"{rival.holder} holds {rival.place} or is about to, priority {rival.priority}; "
                    "wait, or ask with a higher priority"
                )
        for claim in waiting:
            claim.outbid_by = str(wish.holder)
            claim.stirred.set()
        mine = Claim(wish)
        self._claims.append(mine)
        return mine

    def withdraw(self, claim: Claim) -> None:
        """Remove a claim that has been fulfilled or given up."""
        self._claims.remove(claim)

    def held_against(self, wish: Wish) -> list[Grant]:
        """Return the leases that conflict with a request."""
        return [grant for grant in self.grants.values() if grant.place.conflicts_with(wish.place)]

    def is_claimed(self, place: LeaseTarget) -> bool:
        """Return whether there is a claim on a target."""
        return any(claim.wish.place.conflicts_with(place) for claim in self._claims)

    def notify(self) -> None:
        """Wake the waiting claims after a release."""
        for claim in self._claims:
            claim.stirred.set()

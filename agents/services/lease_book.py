"""Who holds what by an arbiter's grace, and who waits for what somebody holds. No bus, no clock."""

import asyncio
import secrets
from dataclasses import dataclass, field
from typing import Any

from agents.platform import AgentName
from agents.services.leases import LeaseTarget
from bus import Refused


def new_id() -> str:
    """An id for a lease, that nobody can guess."""
    return secrets.token_hex(8)


@dataclass(frozen=True, slots=True)
class Wish:
    """What somebody asks for. seconds: how long it is to last without being renewed."""

    place: LeaseTarget
    holder: AgentName
    priority: int
    seconds: float

    def told(self) -> dict[str, Any]:
        """As everyone may see it."""
        return {
            "element": str(self.place),
            "holder": str(self.holder),
            "priority": self.priority,
            "seconds": self.seconds,
        }


@dataclass(slots=True, eq=False)
class Grant:
    """A lease that has been given.

    seconds: how long it lasts from each renewal. expires_at: s of the loop's time; the gateway's clock says a little
    later. timer: calls when that is.
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
        """What it is on."""
        return self.wish.place

    @property
    def holder(self) -> AgentName:
        """Who has it."""
        return self.wish.holder

    @property
    def priority(self) -> int:
        """With what priority."""
        return self.wish.priority

    def told(self) -> dict[str, Any]:
        """As its holder may see it, but for the token."""
        return {"lease": self.id, "element": str(self.place), "priority": self.priority, "seconds": self.seconds}


@dataclass(slots=True, eq=False)
class Claim:
    """A wish that waits for holders to let go. stirred: set when something has changed. outbid_by: by whom it was."""

    wish: Wish
    stirred: asyncio.Event = field(default_factory=asyncio.Event)
    outbid_by: str = ""


class Book:
    """The leases given and the claims that wait. grants: by id."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.grants: dict[str, Grant] = {}
        self._claims: list[Claim] = []

    def claim(self, wish: Wish) -> Claim:
        """Be next; whoever waits for the same with a lower priority is outbid.

        Raises:
            Refused: Somebody holds it or waits for it with the same priority or a higher one.
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
        """It has been fulfilled, or given up."""
        self._claims.remove(claim)

    def held_against(self, wish: Wish) -> list[Grant]:
        """The leases that are in the way of a wish."""
        return [grant for grant in self.grants.values() if grant.place.conflicts_with(wish.place)]

    def is_claimed(self, place: LeaseTarget) -> bool:
        """Whether somebody is about to take over a place."""
        return any(claim.wish.place.conflicts_with(place) for claim in self._claims)

    def notify(self) -> None:
        """Something has been given back: whoever waits looks again."""
        for claim in self._claims:
            claim.stirred.set()

"""The life of a lease at an arbiter: renewed, expired, lost or revoked. The holder is informed."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
from typing import Any

from agents.platform import AclMessage, AgentName, Performative
from agents.services.audit import Audit, AuditEvent
from agents.services.gateway_leases import GatewayAway, GatewayLeases
from agents.services.lease_book import Book, Grant
from agents.services.leases import ONTOLOGY, LeaseEvent, LeaseTarget
from bus import Refused
from bus.bus import Closeable

TRY_AGAIN = 0.2  # s


class LeaseManager(Closeable):
    """Keeps an arbiter's book consistent with the gateways."""

    def __init__(
        self, me: AgentName, book: Book, gateways: GatewayLeases, audit: Audit, send: Callable[[AclMessage], None]
    ) -> None:
        """Make one in a running event loop.

        Args:
            me: The arbiter.
            book: Its leases and claims.
            gateways: The gateways' leases.
            audit: Records every change.
            send: Sends messages to holders.
        """
        self._me = me
        self._book = book
        self._gateways = gateways
        self._audit = audit
        self._send = send
        self._loop = asyncio.get_running_loop()
        self._at_work: set[asyncio.Task[None]] = set()

    def begin(self, grant: Grant, how: AuditEvent) -> None:
        """Add a lease of a gateway."""
        self._book.grants[grant.id] = grant
        self._note(how, grant, seconds=grant.seconds)
        self._wind(grant)

    def end(self, grant: Grant, how: AuditEvent, event: LeaseEvent | None = None, by: str = "") -> None:
        """Remove a lease, record why, and inform its holder."""
        if self._book.grants.pop(grant.id, None) is None:
            return  # it has ended already, for another reason
        if grant.timer is not None:
            grant.timer.cancel()
        self._book.notify()
        self._note(how, grant, **({"by": by} if by else {}))
        if event is not None:
            self.inform(grant.holder, grant.id, grant.place, event, 0.0, by)

    def warn(self, grant: Grant, within: float, by: str) -> None:
        """Warn its holder that another is about to take over."""
        self._note(AuditEvent.WARNED, grant, by=by, within=within)
        self.inform(grant.holder, grant.id, grant.place, LeaseEvent.PREEMPTED, within, by)

    async def renew(self, grant: Grant, seconds: float) -> bool:
        """Renew it for this time, also for later renewals; return False when the gateway does not know it any more.

        The first renewal is recorded, and each with another time.

        Raises:
            GatewayAway: It is not known; the lease expires as before.
        """
        if not await self._last(grant, seconds):
            return False
        if not grant.is_renewed or grant.seconds != seconds:
            grant.is_renewed, grant.seconds = True, seconds
            self._note(AuditEvent.RENEWED, grant, seconds=seconds)
        return True

    async def take_back(self, grant: Grant) -> None:
        """Have the gateway end a lease, which stops the element; without a connection it expires there."""
        while self._loop.time() < grant.expires_at:
            try:
                with suppress(Refused):  # it knows it no more
                    await self._gateways.release(grant.place.robot, grant.token)
                return
            except GatewayAway:
                await asyncio.sleep(TRY_AGAIN)

    def on_holder_death(self, holder: AgentName) -> None:
        """Revoke the leases of a holder that has died, which stops their elements."""
        for grant in [grant for grant in self._book.grants.values() if grant.holder == holder]:
            self.work(self.take_back(grant))
            self.end(grant, AuditEvent.DIED)

    def doubt(self, robot: str, state: Mapping[str, Any]) -> None:
        """Check the leases on a robot that its state does not show; the state may be older than they are."""
        for grant in list(self._book.grants.values()):
            is_shown = (str(grant.holder), grant.priority) in grant.place.holders(state)
            if grant.place.robot == robot and not is_shown and not self._book.is_claimed(grant.place):
                self.work(self._make_sure(grant))

    def inform(
        self, holder: AgentName, lease: str, place: LeaseTarget, event: LeaseEvent, within: float, by: str
    ) -> None:
        """Send a holder news of its lease; without an id for a lease of another arbiter."""
        self._send(
            AclMessage(
                performative=Performative.INFORM,
                sender=self._me,
                receivers=(holder,),
                content={"lease": lease, "element": str(place), "event": str(event), "within": within, "by": by},
                ontology=ONTOLOGY,
                conversation_id=lease,
            )
        )

    def work(self, work: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine in the background."""
        task = asyncio.ensure_future(work)
        self._at_work.add(task)
        task.add_done_callback(self._at_work.discard)

    def close(self) -> None:
        """Stop all timers; the leases stay with their holders."""
        for task in self._at_work:
            task.cancel()
        for grant in self._book.grants.values():
            if grant.timer is not None:
                grant.timer.cancel()

    def _wind(self, grant: Grant) -> None:
        """Set the timer of a lease."""
        if grant.timer is not None:
            grant.timer.cancel()
        grant.timer = self._loop.call_at(grant.expires_at, lambda: self.work(self._expire(grant)))

    async def _expire(self, grant: Grant) -> None:
        """End it, unless its holder has renewed it at the gateway."""
        left = 0.0
        with suppress(GatewayAway):  # it cannot have been renewed there
            left = await self._gateways.time_left(grant.place, str(grant.holder))
        if left > 0.0 and grant.id in self._book.grants:
            grant.expires_at = self._loop.time() + left
            self._wind(grant)
        else:
            self.end(grant, AuditEvent.EXPIRED, LeaseEvent.EXPIRED)

    async def _make_sure(self, grant: Grant) -> None:
        left = grant.expires_at - self._loop.time()
        with suppress(GatewayAway):  # the lease ends at its time
            if left > 0.0:
                await self._last(grant, left)

    async def _last(self, grant: Grant, seconds: float) -> bool:
        """Renew it at the gateway; it ends when the gateway does not know it."""
        asked_at = self._loop.time()
        try:
            await self._gateways.renew(grant.place, grant.token, seconds)
        except Refused as err:
            self.end(grant, AuditEvent.LOST, LeaseEvent.LOST, by=err.why)
            return False
        grant.expires_at = asked_at + seconds
        if grant.id in self._book.grants:
            self._wind(grant)
        return True

    def _note(self, event: AuditEvent, grant: Grant, **more: Any) -> None:
        self._audit.note(event, str(grant.holder), str(grant.place), grant.priority, **more)

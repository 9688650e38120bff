"""The arbiter: leases on the elements of all robots, with priorities, notice and an audit.

The gateways decide: an arbiter takes their leases in the names of the holders, and passes on the tokens.
So two arbiters never give one element to two holders, and the leases of an arbiter that dies expire. An arbiter warns a
holder before one of higher priority takes over, stops what a dead holder moves at once, and records all events.

A name such as `name:doorway` is no part of a robot: only the arbiter records its holder, and only the agreement of the
applications enforces it. A new arbiter leases no name for `TIME_TO_RETURN`, in which the holders from a previous
arbiter renew theirs.

A lease lasts for the requested time from its last renewal: a holder that is frozen loses it. The holder is the sender
of the ACL message; the right to move is the token, which only the holder gets, and `renew` and `release` need the id of
the lease, which only the holder knows.
"""

import asyncio
import secrets
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, ClassVar

from agents.platform import Agent, AgentName, AgentState, Directory, NameNotValid, agree, asker, request
from agents.services.audit import Audit, AuditEvent
from agents.services.gateway_leases import GatewayAway, GatewayLeases
from agents.services.lease_book import Book, Claim, Grant, Wish
from agents.services.lease_manager import LeaseManager
from agents.services.leases import ID_BYTES, SERVICE, LeaseEvent, LeaseTarget
from bus import Refused
from bus.aio import hand_over
from bus.bus import Closeable

LONGEST_LEASE = 60.0  # s, as the gateways have it
LONGEST_NOTICE = 5.0  # s
HIGHEST_PRIORITY = 1000  # and the lowest is its negative
TIME_TO_APPEAR = 0.5  # s for the token of a holder that has just begun to live
TIME_TO_RETURN = 3.0  # s; more than a holder of a name takes to renew it
MOST_ROWS = 500  # of the audit in one answer


class Arbiter(Agent):
    """Property `audit_file`: where to append the record, as lines of JSON."""

    services: ClassVar[tuple[str, ...]] = (SERVICE,)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._book = Book()
        self._gateways = GatewayLeases(self.query)
        self._held_open: list[Closeable] = []

    async def setup(self) -> None:
        """Watch the holders, the gateways and their leases."""
        loop = self._own_loop = asyncio.get_running_loop()
        self._audit = Audit(
            self.publish,
            loop.time,
            self.home.wall_time,
            lambda err: self.home.report(self.name, "the audit is written down no more", err),
            self.properties.get("audit_file"),
        )
        self._gives_names_from = loop.time() + TIME_TO_RETURN
        self._keeper = LeaseManager(self.name, self._book, self._gateways, self._audit, self.send)
        self._directory = Directory(self.bus, lambda name, lives: hand_over(loop, self._on_life, name, lives))
        watching = self.bus.watch_alive("*/alive", lambda key, lives: hand_over(loop, self._on_robot, key, lives))
        self._held_open += [self._audit, self._keeper, self._directory, watching]
        self.listen("*/lease/state", self._on_state, keep=1000, keyed=True)

    async def take_down(self) -> None:
        """Keep the leases: they last until they expire, and another arbiter may continue them."""
        while self._held_open:
            self._held_open.pop().close()

    # Requests.

    @request("lease", agrees_itself=True)
    async def lease(self, element: str, priority: int = 0, seconds: float = 5.0, notice: float = 0.5) -> dict[str, Any]:
        """Give the one who asks the right to move `base@happy` or the whole robot `happy`, or to use `name:doorway`.

        Args:
            element: What: an element, a robot, or a name of any kind after `name:`.
            priority: Whoever holds it with a lower one is warned, and loses it.
            seconds: How long it lasts without `renew`.
            notice: s that the present holder is given.
        """
        wish = Wish(LeaseTarget.parse(element), asker(), priority, seconds)
        try:
            _check("priority", priority, -HIGHEST_PRIORITY, HIGHEST_PRIORITY)
            _check("seconds", seconds, 0.1, LONGEST_LEASE)
            _check("notice", notice, 0.0, LONGEST_NOTICE)
            await self._await_life(wish.holder)
            if wish.place.is_named:
                await asyncio.sleep(self._gives_names_from - self._own_loop.time())
            grant = await self._give(wish, notice)
        except GatewayAway as err:
            raise self._no(wish, str(err)) from err
        except Refused as err:
            raise self._no(wish, err.why) from err
        return {**grant.told(), "token": grant.token}

    @request("renew", agrees_itself=True)
    async def renew(
        self, lease: str, seconds: float = 0.0, token: str = "", element: str = "", priority: int = 0
    ) -> dict[str, Any]:
        """Let a lease last for as long again, or for so many seconds from now on.

        With token and element a lease goes on that was given by an arbiter that is gone: the gateway knows the token.
        A name goes on, with the priority, unless somebody else holds it by now.
        """
        _check("seconds", seconds, 0.0, LONGEST_LEASE)
        try:
            if lease not in self._book.grants and token and element:
                place = LeaseTarget.parse(element)
                if place.is_named:
                    return self._take_up(lease, token, Wish(place, asker(), priority, seconds or 5.0)).told()
                return (await self._adopt(lease, token, place, seconds or 5.0)).told()
            grant = self._own(lease)
            if not await self._keeper.renew(grant, seconds or grant.seconds):
                raise Refused(f"the gateway of {grant.place.robot} does not know this lease any more; ask anew")
        except GatewayAway as err:
            agree()  # a refusal would say that the lease has ended
            raise Refused(f"{err} The lease runs on as it was") from err
        return grant.told()

    @request("release", agrees_itself=True)
    async def release(self, lease: str) -> dict[str, Any]:
        """Give a lease back."""
        grant = self._own(lease)
        self._keeper.end(grant, AuditEvent.RELEASED)
        await self._keeper.take_back(grant)
        return {}

    @request("leases")
    async def leases(self) -> list[dict[str, Any]]:
        """Who holds what; neither ids nor tokens."""
        now = self._own_loop.time()
        return [
            {**grant.wish.told(), "expires_in": round(max(0.0, grant.expires_at - now), 3)}
            for grant in sorted(self._book.grants.values(), key=lambda grant: grant.place)
        ]

    @request("audit")
    async def audit(self, last: int = 50) -> list[dict[str, Any]]:
        """What has happened, oldest first."""
        return self._audit.last(min(last, MOST_ROWS))

    # Granting.

    async def _give(self, wish: Wish, notice: float) -> Grant:
        claim = self._book.claim(wish)
        try:
            await self._clear(claim, notice)
            self._make_good(claim)
            grant = await self._take_lease(wish)
            for rival in self._book.held_against(wish):
                self._keeper.end(rival, AuditEvent.PREEMPTED, LeaseEvent.PREEMPTED, by=str(wish.holder))
            try:
                self._make_good(claim)  # while the gateway was at it, much may have happened
            except Refused:
                await self._keeper.take_back(grant)
                raise
        finally:
            self._book.withdraw(claim)
        self._keeper.begin(grant, AuditEvent.GRANTED)
        return grant

    async def _clear(self, claim: Claim, notice: float) -> None:
        """Warn the holders of conflicting leases, and wait until they release or lose them."""
        if not notice:
            return
        wish = claim.wish
        known = {str(grant.holder) for grant in self._book.held_against(wish)}
        others = [
            (holder, priority)
            for holder, priority in await self._gateways.holders(wish.place)
            if holder not in known and priority < wish.priority
        ]
        for grant in self._book.held_against(wish):
            self._keeper.warn(grant, notice, str(wish.holder))
        for holder, _ in others:  # from another arbiter, or from before this one began
            with suppress(NameNotValid):  # no agent holds it, and none can be told
                name = AgentName.parse(holder)
                self._keeper.inform(name, "", wish.place, LeaseEvent.PREEMPTED, notice, str(wish.holder))
        with suppress(TimeoutError):  # the notice is over, and they lose it now
            async with asyncio.timeout(notice):
                while (others or self._book.held_against(wish)) and not claim.outbid_by:
                    await claim.stirred.wait()
                    claim.stirred.clear()

    def _make_good(self, claim: Claim) -> None:
        """Refuse a claim that has been outbid, or whose holder has gone."""
        if claim.outbid_by:
            raise Refused(f"{claim.outbid_by} asks for it with a higher priority")
        if not self._directory.knows(claim.wish.holder):
            raise Refused(f"{claim.wish.holder} has gone")

    async def _take_lease(self, wish: Wish) -> Grant:
        """Take the lease from the gateway; if the request is cancelled meanwhile, the lease is released."""
        asked_at = self._own_loop.time()
        taking = asyncio.ensure_future(self._gateways.take(wish.place, str(wish.holder), wish.priority, wish.seconds))
        try:
            token = await asyncio.shield(taking)
        except asyncio.CancelledError:
            self._keeper.work(self._undo(wish, taking))
            raise
        return Grant(secrets.token_hex(ID_BYTES), wish, token, wish.seconds, asked_at + wish.seconds)

    async def _undo(self, wish: Wish, taking: asyncio.Future[str]) -> None:
        with suppress(Refused, GatewayAway):  # it was never taken, or is gone with its gateway
            await self._keeper.take_back(Grant("", wish, await taking, 0.0, self._own_loop.time() + wish.seconds))

    async def _adopt(self, lease: str, token: str, place: LeaseTarget, seconds: float) -> Grant:
        asked_at = self._own_loop.time()
        holder, priority = await self._gateways.renew(place, token, seconds)
        if holder != str(asker()):
            raise Refused(f"this token is {holder}'s, not yours")
        if lease not in self._book.grants:
            grant = Grant(lease[:64], Wish(place, asker(), priority, seconds), token, seconds, asked_at + seconds)
            self._keeper.begin(grant, AuditEvent.ADOPTED)
        return self._book.grants[lease]

    def _take_up(self, lease: str, token: str, wish: Wish) -> Grant:
        """Continue a lease on a name from a previous arbiter."""
        _check("priority", wish.priority, -HIGHEST_PRIORITY, HIGHEST_PRIORITY)
        if self._book.held_against(wish) or self._book.is_claimed(wish.place):
            agree()  # a failure is final; a refusal may mean that this arbiter is suspended
            raise Refused(f"somebody else has {wish.place} by now; ask anew")
        grant = Grant(lease[:64], wish, token, wish.seconds, self._own_loop.time() + wish.seconds)
        self._keeper.begin(grant, AuditEvent.ADOPTED)
        return grant

    async def _await_life(self, holder: AgentName) -> None:
        """Refuse a holder without a liveliness token: it has died, or its name is forged."""
        with suppress(TimeoutError):  # whether it lives is asked below
            async with asyncio.timeout(TIME_TO_APPEAR):
                while not self._directory.knows(holder):
                    await asyncio.sleep(TIME_TO_APPEAR / 10)
        if not self._directory.knows(holder):
            raise Refused(
                f"no agent {holder} lives, as far as one sees here; ask when you are active, in your own name"
            )

    def _own(self, lease: str) -> Grant:
        """Return the lease with this id of the initiator."""
        grant = self._book.grants.get(lease)
        if grant is None or grant.holder != asker():
            raise Refused("you hold no lease of this id; it has ended, or was never yours")
        return grant

    def _no(self, wish: Wish, why: str) -> Refused:
        self._audit.note(AuditEvent.REFUSED, str(wish.holder), str(wish.place), wish.priority, why=why)
        return Refused(why)

    # Events on the bus.

    def _on_life(self, name: AgentName, lives: bool) -> None:
        """Note that an agent has appeared or disappeared."""
        if not lives and self.state is not AgentState.DELETED:  # else it comes while this arbiter ends, or after it
            self._keeper.on_holder_death(name)

    def _on_robot(self, key: str, lives: bool) -> None:
        """Note that a gateway has appeared; after a restart it has lost its leases."""
        if lives and self.state is not AgentState.DELETED:
            self._keeper.doubt(key.partition("/")[0], {})

    async def _on_state(self, key: str, state: dict[str, Any]) -> None:
        """Take the leases that a gateway publishes."""
        self._keeper.doubt(key.partition("/")[0], state)


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise Refused(f"{name} {value:g} is not within {low:g} and {high:g}")

"""Leases for agents that need the sole right to move something.

    async with leased(self, "base@happy", priority=1) as lease:
        await self.request("base@happy", "move", distance=1.0, token=lease.token)

An arbiter grants it, or without one the robot's gateway itself, without notice to other holders. It is renewed while
its agent is active, also when the arbiter goes or another one starts, and released at the end of the block. An agent
that is suspended or frozen does not renew, and loses it.
"""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from math import inf
from typing import Any

from agents.platform import (
    Agent,
    AgentName,
    Cyclic,
    Directory,
    Done,
    Ending,
    Outcome,
    Performative,
    RequestNotDone,
    Template,
)
from agents.platform.errors import in_words
from agents.services.gateway_leases import ANSWER_TIME, TAKING_TIME, GatewayAway, GatewayLeases
from agents.services.leases import ID_BYTES, ONTOLOGY, SERVICE, LeaseEvent, LeaseNews, LeaseTarget
from bus import BusError, Refused

SECONDS = 3.0
NOTICE = 0.5
RENEWALS = 3  # within the time that a lease lasts, so that one may fail
LONGEST_PERIOD = (
    0.8  # s between renewals of a name; two of them with a search are less than an arbiter's TIME_TO_RETURN
)
TIME_TO_LET_GO = 1.0  # s
TIME_TO_TAKE_OVER = TAKING_TIME  # s for the gateway to answer, once a warned holder's time is up

OnNews = Callable[[LeaseNews], None]


class HeldLease:
    """A lease on an element, for its holder.

    token: for commands. place, priority, seconds: as requested. news: the latest news about it, such as a warning.
    ended: set when the lease has ended.
    """

    def __init__(self, agent: Agent, place: LeaseTarget, priority: int, seconds: float, on_news: OnNews | None) -> None:
        """Prepare it; `take` takes it."""
        self.token = ""
        self.place = place
        self.priority = priority
        self.seconds = seconds
        self.news: LeaseNews | None = None
        self.ended = asyncio.Event()
        self._agent = agent
        self._gateways = GatewayLeases(agent.query)
        self._arbiter: AgentName | None = None
        self._id = secrets.token_hex(ID_BYTES)
        self._on_news = on_news
        self._loop = asyncio.get_running_loop()
        self._expires_at = self._warned_until = self._loop.time()

    @property
    def period(self) -> float:
        """s from one renewal to the next; short for a name, for which a new arbiter waits before it gives it anew."""
        return min(self.seconds / RENEWALS, LONGEST_PERIOD if self.place.is_named else inf)

    @property
    def patience(self) -> float:
        """s that a renewal may take."""
        return LONGEST_PERIOD if self.place.is_named else inf

    @property
    def is_held(self) -> bool:
        """Whether it is held, as far as its holder knows."""
        return not self.ended.is_set() and self._loop.time() < self._expires_at

    @property
    def wanted_by(self) -> str:
        """The holder of higher priority that is about to take it; empty for none."""
        return self.news.by if self.news is not None and self._loop.time() < self._warned_until else ""

    async def take(self, arbiter: AgentName | None, notice: float) -> None:
        """Take the lease.

        Args:
            arbiter: The arbiter; None for the robot's gateway.
            notice: s until the present holder loses it.
        Raises:
            RequestNotDone: It was not granted; the message says why.
        """
        self._arbiter = arbiter
        if arbiter is None:
            await self._take_from_gateway()
        else:
            wish: dict[str, Any] = {"element": str(self.place), "priority": self.priority, "seconds": self.seconds}
            given = (await self._agent.request(arbiter, "lease", **wish, notice=notice)).value()
            self._id, self.token = given["lease"], given["token"]
        self._expires_at = self._loop.time() + self.seconds  # more or less; the gateway has the last word

    async def hear(self) -> None:
        """Take the next news of an arbiter about this lease; only the arbiter knows its id."""
        message = await self._agent.receive(Template.of(Performative.INFORM, ontology=ONTOLOGY, conversation=self._id))
        news = LeaseNews.from_content(message.content)
        if news is not None:
            self._tell(news)

    async def renew(self) -> None:
        """Renew it.

        Raises:
            Done: It has ended.
        """
        asked_at = self._loop.time()
        try:
            if self.is_held and await self._is_renewed():
                self._expires_at = asked_at + self.seconds
        except Refused as err:
            self._tell(LeaseNews(LeaseEvent.LOST, by=err.why))
        if self._loop.time() >= self._expires_at:
            self._tell(LeaseNews(LeaseEvent.EXPIRED))
        if self.ended.is_set():
            raise Done

    async def release(self) -> None:
        """Release it, at the gateway itself when no arbiter answers."""
        if not self.is_held:
            return
        self.ended.set()
        with suppress(BusError, TimeoutError, GatewayAway):  # it expires by itself
            released = self._arbiter and (await self._ask(self._arbiter, "release", TIME_TO_LET_GO)).is_done
            if not released:
                await self._gateways.release(self.place.robot, self.token)

    async def _take_from_gateway(self) -> None:
        if self.place.is_named:
            raise RequestNotDone(f"no arbiter is there to give {self.place}: start a team with acromovi up")
        try:
            self.token = await self._gateways.take(self.place, str(self._agent.name), self.priority, self.seconds)
        except Refused as err:
            raise RequestNotDone(f"{Ending.REFUSED}: {in_words(err)}") from err
        except GatewayAway as err:
            raise RequestNotDone(f"{Ending.DIED}: {err}") from err

    async def _is_renewed(self) -> bool:
        """Renew it at the arbiter, or else at the gateway, which decides.

        Raises:
            Refused: The lease has ended.
        """
        if self._arbiter is not None:
            patience = min((self._expires_at - self._loop.time()) / 2.0, self.patience)
            about = {"seconds": self.seconds, "token": self.token, "element": str(self.place)}
            outcome = await self._ask(self._arbiter, "renew", patience, **about, priority=self.priority)
            if outcome.is_done:
                return True
            if self.place.is_named and outcome.ending is Ending.FAILED:  # a refusal may come from one that rests
                raise Refused(outcome.why)
        if self.place.is_named:
            self._arbiter = await find_arbiter(self._agent, self.period / 2.0)
            return False  # the next renewal asks that one
        try:
            await self._gateways.renew(self.place, self.token, self.seconds)
        except GatewayAway:  # it is tried again at the next renewal
            return False
        self._arbiter = await find_arbiter(self._agent, self.seconds / RENEWALS / 2.0)  # one that is there by now
        return True

    async def _ask(self, arbiter: AgentName, request: str, within: float, **about: Any) -> Outcome:
        return await self._agent.request(arbiter, request, reply_within=within, lease=self._id, **about)

    def _tell(self, news: LeaseNews) -> None:
        if self.ended.is_set():
            return
        self.news = news
        if news.is_warning:
            self._warned_until = self._loop.time() + news.within + TIME_TO_TAKE_OVER
        else:
            self.ended.set()
        if self._on_news is not None:
            self._on_news(news)


@asynccontextmanager
async def leased(
    agent: Agent,
    element: str,
    *,
    priority: int = 0,
    seconds: float = SECONDS,
    notice: float = NOTICE,
    arbiter: AgentName | None = None,
    on_news: OnNews | None = None,
) -> AsyncIterator[HeldLease]:
    """Hold the lease on an element, or a whole robot, during a block.

    Args:
        agent: The holder; it must be active, since its liveliness token is watched.
        element: `base@happy`, `happy` for the whole robot, or `name:doorway` for a name, which only the arbiter knows.
        priority: A holder with a lower one loses it.
        seconds: How long it lasts without a renewal.
        notice: s until the present holder loses it.
        arbiter: The arbiter; by default any agent with that service, or else the robot's gateway.
        on_news: Called when a holder of higher priority wants it (`within` s are left), and when it ends.
    Raises:
        RequestNotDone: It was not granted; the message says why.
        Refused: The element or name is not valid.
    """
    lease = HeldLease(agent, LeaseTarget.parse(element), priority, seconds, on_news)
    await lease.take(arbiter or await find_arbiter(agent), notice)
    behaviours = [agent.every(lease.period, lease.renew), agent.add(Cyclic(lease.hear))]
    try:
        yield lease
    finally:
        for behaviour in behaviours:
            behaviour.stop()
        await asyncio.shield(lease.release())


async def find_arbiter(agent: Agent, within: float = ANSWER_TIME) -> AgentName | None:
    """Return an arbiter, the same for all programs; None when none has answered in time."""
    with Directory(agent.bus) as directory:
        found = await directory.search(service=SERVICE, within=within)
    return found[0].name if found else None

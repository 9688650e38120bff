"""Holding a lease, for agents that want to move something alone.

    async with leased(self, "base@happy", priority=1) as lease:
        await self.request("base@happy", "move", distance=1.0, token=lease.token)

The lease is renewed while its agent is active, and given back at the end of the block. An agent that is suspended or
frozen does not renew, and loses it.
"""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

from agents.platform import Agent, AgentName, Cyclic, Directory, Done, Ending, Performative, RequestNotDone, Template
from agents.services.leases import ONTOLOGY, SERVICE, LeaseEvent, LeaseLost, LeaseNews, Place
from bus import BusError, keys

SECONDS = 3.0
NOTICE = 0.5
RENEWALS = 3  # within the time that a lease lasts, so that one may fail
TIME_TO_LET_GO = 1.0  # s

OnNews = Callable[[LeaseNews], None]


class HeldLease:
    """A lease on an element, in its holder's hands.

    token: what a command must carry. element, priority, seconds: as they were asked for. news: the last that the
    arbiter has said, a warning perhaps. ended: set when the lease has ended.
    """

    def __init__(self, agent: Agent, arbiter: AgentName, given: dict[str, Any], on_news: OnNews | None) -> None:
        """Take up what an arbiter has just given."""
        self.token: str = given["token"]
        self.element: str = given["element"]
        self.priority: int = given["priority"]
        self.seconds: float = given["seconds"]
        self.news: LeaseNews | None = None
        self.ended = asyncio.Event()
        self._agent = agent
        self._arbiter = arbiter
        self._id: str = given["lease"]
        self._on_news = on_news
        self._loop = asyncio.get_running_loop()
        self._expires_at = self._loop.time() + self.seconds

    @property
    def is_held(self) -> bool:
        """Whether it has not ended, by all that its holder knows."""
        return not self.ended.is_set() and self._loop.time() < self._expires_at

    def check(self) -> None:
        """Make sure that it is still held.

        Raises:
            LeaseLost: It is not.
        """
        if not self.is_held:
            raise LeaseLost(f"the lease on {self.element} has ended: {self.news or LeaseEvent.EXPIRED}")

    async def hear(self) -> None:
        """Take the next thing that an arbiter says of this lease; nobody else knows its id."""
        message = await self._agent.receive(Template.of(Performative.INFORM, ontology=ONTOLOGY, conversation=self._id))
        news = LeaseNews.from_content(message.content)
        if news is not None:
            self._tell(news)

    async def renew(self) -> None:
        """Let it last for as long again; when its arbiter is gone, another one may take it over.

        Raises:
            Done: It has ended.
        """
        asked_at = self._loop.time()
        outcome = await self._agent.request(
            self._arbiter,
            "renew",
            reply_within=max(self._expires_at - asked_at, 0.1) / 2.0,
            lease=self._id,
            seconds=self.seconds,
            token=self.token,
            element=self.element,
        )
        if outcome.is_done:
            self._expires_at = asked_at + self.seconds
        elif outcome.ending is Ending.DIED:
            self._arbiter = await find_arbiter(self._agent) or self._arbiter
        if self._loop.time() >= self._expires_at:
            self._tell(LeaseNews(LeaseEvent.EXPIRED))
        if self.ended.is_set():
            raise Done

    async def release(self) -> None:
        """Give it back; at the gateway itself, when no arbiter takes it."""
        if not self.is_held:
            return
        self.ended.set()
        with suppress(BusError, TimeoutError):  # it expires by itself
            outcome = await self._agent.request(self._arbiter, "release", reply_within=TIME_TO_LET_GO, lease=self._id)
            if not outcome.is_done:
                key = keys.LEASE.key(Place.parse(self.element).robot)
                await self._agent.query(key, {"do": "release", "token": self.token}, TIME_TO_LET_GO)

    def _tell(self, news: LeaseNews) -> None:
        if self.ended.is_set():
            return
        self.news = news
        if not (news.event is LeaseEvent.PREEMPTED and news.within > 0.0):
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
        agent: Who holds it; it must be active, since one sees by its token that it lives.
        element: `base@happy`, or `happy` for the whole robot.
        priority: Whoever holds it with a lower one loses it.
        seconds: How long it lasts when its holder can renew it no more.
        notice: s that the present holder is given to let go.
        arbiter: Whom to ask; by default whoever offers arbitration.
        on_news: Told when the lease is wanted by somebody of higher priority (`within` s are left), and when it ends.
    Raises:
        RequestNotDone: It was not given; says why.
    """
    chosen = arbiter or await find_arbiter(agent)
    if chosen is None:
        raise RequestNotDone(f"nobody gives leases on {element} here; start an arbiter, as `acromovi up` does")
    outcome = await agent.request(chosen, "lease", element=element, priority=priority, seconds=seconds, notice=notice)
    lease = HeldLease(agent, chosen, outcome.value(), on_news)
    behaviours = [agent.every(seconds / RENEWALS, lease.renew), agent.add(Cyclic(lease.hear))]
    try:
        yield lease
    finally:
        for behaviour in behaviours:
            behaviour.stop()
        await asyncio.shield(lease.release())


async def find_arbiter(agent: Agent) -> AgentName | None:
    """An arbiter that lives, the same for all who ask; None when there is none."""
    with Directory(agent.bus) as directory:
        found = await directory.search(service=SERVICE)
    return found[0].name if found else None

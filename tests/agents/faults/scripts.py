"""Every protocol as a script: who begins it and how, what is said in which order, and how it ends."""

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from agents.platform import Agent, AgentName, Ending, RequestNotDone

PATIENCE = 1000.0  # s; nobody may need it
BEFORE_LEAVING = 2.5  # s until an initiator that cancels does so


@dataclass(frozen=True)
class Script:
    """One way through one protocol.

    begin: what the initiator does with the responder, and how that ended for it.
    words: what the two say to each other, in order.
    ending: the end when nobody dies.
    settled: after how many words the end stands for the initiator, whatever becomes of the responder.
    """

    name: str
    begin: Callable[[Agent, AgentName], Coroutine[Any, Any, Ending]]
    words: tuple[str, ...]
    ending: Ending
    settled: int


async def _request(me: Agent, peer: AgentName) -> Ending:
    return (await me.request(peer, "work", reply_within=PATIENCE)).ending


async def _cancel(me: Agent, peer: AgentName) -> Ending:
    asking = me.begin_request(peer, "work", reply_within=PATIENCE)
    try:
        async with asyncio.timeout(BEFORE_LEAVING):
            await asking
    except TimeoutError:
        pass  # as meant: it is left in the midst of it
    finally:
        ended = await asking.cancel()  # which leaves the end as it is, if it has come
    return ended.ending


async def _query_ref(me: Agent, peer: AgentName) -> Ending:
    return (await me.query_ref(peer, "distance", reply_within=PATIENCE)).ending


async def _query_if(me: Agent, peer: AgentName) -> Ending:
    return (await me.query_if(peer, "ready", reply_within=PATIENCE)).ending


async def _subscribe(me: Agent, peer: AgentName) -> Ending:
    try:
        async with me.subscribe(peer, "count", to=2) as values:
            async for _ in values:
                pass
    except RequestNotDone:
        pass  # how it ended is looked at below
    assert values.outcome is not None
    return values.outcome.ending


async def _unsubscribe(me: Agent, peer: AgentName) -> Ending:
    try:
        async with me.subscribe(peer, "count") as values:
            async for _ in values:
                return Ending.CANCELLED
    except RequestNotDone:
        pass  # how it ended is looked at below
    assert values.outcome is not None
    return values.outcome.ending


async def _accept(me: Agent, peer: AgentName) -> Ending:
    tender = await me.call_for_proposals([peer], "carry", choose=lambda bids: bids, reply_within=PATIENCE)
    return tender.outcomes[peer].ending


async def _reject(me: Agent, peer: AgentName) -> Ending:
    tender = await me.call_for_proposals([peer], "carry", choose=lambda bids: None, reply_within=PATIENCE)
    return tender.outcomes[peer].ending


SCRIPTS = (
    Script("request", _request, ("request", "agree", "inform"), Ending.DONE, 3),
    Script("cancel", _cancel, ("request", "agree", "cancel", "failure"), Ending.CANCELLED, 4),
    Script("query-ref", _query_ref, ("query-ref", "agree", "inform"), Ending.DONE, 3),
    Script("query-if", _query_if, ("query-if", "agree", "inform"), Ending.DONE, 3),
    Script("subscribe", _subscribe, ("subscribe", "agree", "inform", "inform", "inform"), Ending.DONE, 5),
    Script("unsubscribe", _unsubscribe, ("subscribe", "agree", "inform", "cancel", "failure"), Ending.CANCELLED, 3),
    Script("contract-net", _accept, ("cfp", "propose", "accept-proposal", "inform"), Ending.DONE, 4),
    Script("rejection", _reject, ("cfp", "propose", "reject-proposal"), Ending.REJECTED, 3),
)

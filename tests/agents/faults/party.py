"""One of two who talk, in a process of its own: `python -m tests.agents.faults.party PROFILE ME [PEER]`.

It answers in every protocol and, if a peer is named, is in the middle of every protocol with it. It says `ready` in a
line, and lives until its standard input ends.
"""

import asyncio
import sys
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager
from typing import Any

from agents.platform import Agent, AgentName, Container, Directory, Ending, RequestNotDone
from bus import Bus, ZenohBus
from tests.agents.faults.processes import until
from tests.agents.faults.scripts import PATIENCE
from tests.agents.faults.worker import Worker
from tests.waiting import waiting


@asynccontextmanager
async def party(bus: Bus, name: AgentName) -> AsyncIterator[Worker]:
    """A worker that lives during the block."""
    async with Container(bus, f"{name.local}-on-{name.platform}", platform=name.platform) as container:
        worker = Worker(name)
        assert await container.start(worker)
        try:
            yield worker
        finally:
            worker.may_go.set()


async def meet(bus: Bus, *names: AgentName) -> None:
    """Wait until these agents are seen."""
    with Directory(bus) as directory:
        await until(lambda: all(map(directory.knows, names)), f"{', '.join(map(str, names))} can be seen")


async def reach(me: Agent, peer: AgentName) -> None:
    """Ask until there is an answer: the first question after a change may be lost on the way."""
    async with waiting():
        while not (await me.request(peer, "look", reply_within=1.0)).is_done:
            await asyncio.sleep(0.01)


def conversations(me: Agent, peer: AgentName) -> dict[str, Coroutine[Any, Any, Ending]]:
    """One in each protocol, and how it ended; each keeps the peer at work for long."""
    return {
        "request": _request(me, peer),
        "cancel": _cancel(me, peer),
        "query-ref": _query_ref(me, peer),
        "query-if": _query_if(me, peer),
        "subscribe": _subscribe(me, peer),
        "contract-net": _call(me, peer),
    }


async def _request(me: Agent, peer: AgentName) -> Ending:
    return (await me.request(peer, "work", reply_within=PATIENCE)).ending


async def _cancel(me: Agent, peer: AgentName) -> Ending:
    asking = me.begin_request(peer, "cling", reply_within=PATIENCE)
    await asyncio.sleep(0.1)
    return (await asking.cancel()).ending


async def _query_ref(me: Agent, peer: AgentName) -> Ending:
    return (await me.query_ref(peer, "distance", reply_within=PATIENCE)).ending


async def _query_if(me: Agent, peer: AgentName) -> Ending:
    return (await me.query_if(peer, "ready", reply_within=PATIENCE)).ending


async def _subscribe(me: Agent, peer: AgentName) -> Ending:
    try:
        async with me.subscribe(peer, "count") as values:
            async for _ in values:
                pass
    except RequestNotDone:
        pass  # how it ended is looked at below
    assert values.outcome is not None
    return values.outcome.ending


async def _call(me: Agent, peer: AgentName) -> Ending:
    tender = await me.call_for_proposals(
        [peer], "carry", choose=lambda bids: bids, bids_within=PATIENCE, reply_within=PATIENCE
    )
    return tender.outcomes[peer].ending


async def main(profile: str, me: str, peer: str = "") -> None:
    """Take part."""
    with ZenohBus.open(profile) as bus:
        async with party(bus, AgentName.parse(me)) as worker:
            tasks = []
            if peer:
                await meet(bus, AgentName.parse(peer))
                tasks = [asyncio.ensure_future(one) for one in conversations(worker, AgentName.parse(peer)).values()]
            print("ready", flush=True)
            await asyncio.to_thread(sys.stdin.read)
            for task in tasks:
                task.cancel()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))

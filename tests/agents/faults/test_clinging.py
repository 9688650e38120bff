"""What does not end although it is told to keeps neither its agent nor its container nor who waits for it."""

import asyncio
import contextlib

import pytest

from agents.platform import Ending, Outcome
from tests.agents.faults.pair import RESPONDER, Pair

LONG = 1000.0  # s


async def cling() -> str:
    """Bear every cancellation."""
    loop = asyncio.get_running_loop()
    until = loop.time() + LONG
    while loop.time() < until:
        with contextlib.suppress(asyncio.CancelledError):  # it clings: that is the fault
            await asyncio.sleep(until - loop.time())
    return "at last"


@pytest.mark.parametrize("what", ["request", "behaviour"])
def test_an_agent_ends_although_something_in_it_clings(pair: Pair, what: str) -> None:
    async def begin() -> "asyncio.Task[Outcome] | None":
        if what == "behaviour":
            pair.responder.agent.add(cling)
            return None
        pair.responder.agent.answer("cling", cling)
        return asyncio.ensure_future(pair.initiator.agent.request(RESPONDER, "cling", reply_within=10 * LONG))

    asking = pair.run(begin())
    pair.loop.run_for(1.0)
    pair.run(pair.responder.container.stop(RESPONDER))
    assert pair.loop.time() < 5.0
    assert pair.responder.container.agents == []
    pair.loop.run_for(0.1)
    if asking is not None:
        assert asking.result() == Outcome(Ending.FAILED, why="worker@happy has ended", agreed=True)
    doing = {"request": "the request cling of console@lab", "behaviour": "the behaviour cling"}
    assert [report.what for report in pair.reports] == [f"{doing[what]} goes on although it was told to end"]
    pair.loop.run_for(LONG)


def test_a_container_closes_although_something_in_it_clings(pair: Pair) -> None:
    pair.responder.agent.answer("cling", cling)
    asking = pair.begin(pair.initiator.agent.request(RESPONDER, "cling", reply_within=10 * LONG))
    pair.loop.run_for(1.0)
    pair.leave(pair.responder)
    pair.loop.run_for(0.1)
    assert pair.loop.time() < 5.0
    assert asking.result().ending is Ending.FAILED
    pair.loop.run_for(LONG)

"""An agent that blocks its container: others are told that it does not answer, and all goes on when it ends."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from agents.platform import Agent, AgentName, Container, Ending, Report, request
from bus import MemoryBus, MemoryNetwork
from tests.waiting import patience, wait_until

BLOCKER, NEIGHBOUR = AgentName("blocker", "happy"), AgentName("neighbour", "happy")


class Blocker(Agent):
    """Holds up its loop until it is let go."""

    let_go: threading.Event

    @request("block")
    def block(self) -> None:
        assert self.let_go.wait(patience())


class Neighbour(Agent):
    """Counts how often it has been asked to count."""

    counted = 0

    @request("count")
    def count(self) -> int:
        self.counted += 1
        return self.counted


@contextmanager
def happy(network: MemoryNetwork, reports: list[Report], let_go: threading.Event) -> Iterator[None]:
    """A container of both, with a loop and a thread of its own."""
    ready, ended = threading.Event(), threading.Event()

    async def live() -> None:
        async with Container(MemoryBus(network), "happy", reports.append) as container:
            blocker = Blocker(BLOCKER)
            blocker.let_go = let_go
            await container.start(blocker)
            await container.start(Neighbour(NEIGHBOUR))
            ready.set()
            await asyncio.to_thread(ended.wait)

    thread = threading.Thread(target=lambda: asyncio.run(live()))
    thread.start()
    assert ready.wait(patience())
    try:
        yield
    finally:
        let_go.set()
        ended.set()
        thread.join()


def test_who_asks_a_neighbour_loses_patience_and_what_was_asked_is_not_done_later() -> None:
    network, reports, let_go = MemoryNetwork(), list[Report](), threading.Event()

    async def main() -> None:
        async with Container(MemoryBus(network), "lab") as container:
            console = Agent("console@lab")
            await container.start(console)
            blocking = console.begin_request(BLOCKER, "block", reply_within=patience())
            await asyncio.to_thread(wait_until, lambda: reports, "the blocker is reported")
            late = await console.request(NEIGHBOUR, "count", reply_within=0.05)
            assert (late.ending, late.agreed) == (Ending.TIMED_OUT, False)
            assert late.why == "neighbour@happy has not come to an end within 0.05 s"
            let_go.set()
            assert (await blocking).is_done
            assert (await console.request(NEIGHBOUR, "count", reply_within=patience())).value() == 1

    with happy(network, reports, let_go):
        asyncio.run(main())
    assert reports[0].agent == BLOCKER
    assert "the request block of console@lab holds up all agents of this container" in reports[0].what

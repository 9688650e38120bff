"""The same between processes on Zenoh: one is killed or frozen in the middle of every protocol."""

import asyncio
import signal
import subprocess
from collections.abc import Callable, Coroutine
from contextlib import ExitStack
from typing import Any

import pytest

from agents.platform import AgentName, Ending
from bus import ZenohBus
from tests.agents.faults import processes
from tests.agents.faults.party import conversations, meet, party
from tests.agents.faults.worker import Worker
from tests.waiting import waiting


def here(me: AgentName, main: Callable[[Worker], Coroutine[Any, Any, None]]) -> None:
    """Run a coroutine function with an agent of this process."""

    async def run() -> None:
        with ZenohBus.open() as bus:
            async with party(bus, me) as worker:
                await main(worker)

    asyncio.run(run())


def test_who_asked_in_every_protocol_comes_to_one_end_when_who_answers_is_killed(robot: str) -> None:
    console, peer = AgentName("console", f"lab-{robot}"), AgentName("worker", robot)

    async def main(me: Worker, other: "subprocess.Popen[str]") -> None:
        await meet(me.bus, peer)
        begun = {name: asyncio.ensure_future(one) for name, one in conversations(me, peer).items()}
        while (await me.request(peer, "load")).value() < len(begun):
            await asyncio.sleep(0.01)
        other.kill()
        async with waiting():
            endings = {name: await one for name, one in begun.items()}
        assert endings.pop("cancel") in (Ending.DIED, Ending.CANCELLED)  # it does not wait for its word for long
        assert set(endings.values()) == {Ending.DIED}

    with processes.party(peer) as other:
        here(console, lambda me: main(me, other))


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_who_answers_in_every_protocol_leaves_it_when_who_asked_is_killed_or_frozen(
    robot: str, how: signal.Signals
) -> None:
    console, peer = AgentName("console", f"lab-{robot}"), AgentName("worker", robot)

    async def main(me: Worker) -> None:
        with ExitStack() as stack:
            other = await asyncio.to_thread(stack.enter_context, processes.party(console, peer))
            await processes.until(lambda: me.at_work == 6, "it is at work in every protocol")
            other.send_signal(how)
            await processes.until(lambda: len(me.in_flight) == 1, "it has left all but what clings")
        (clinging,) = me.in_flight
        assert clinging.message.content["action"] == "cling"

    here(peer, main)

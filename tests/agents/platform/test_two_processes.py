"""Agents in two processes on Zenoh: requests, streams of messages, and a container that is killed or frozen."""

import asyncio
import signal
import subprocess
import sys
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest

from agents.platform import AclMessage, Agent, AgentName, Container, Ending, Outcome, Performative
from bus import ZenohBus

ROOT = Path(__file__).resolve().parents[3]

BASE_ALONE = """
import asyncio, sys
from agents.platform import Agent, Container, request
from bus import ZenohBus

class Base(Agent):
    @request("look")
    async def look(self):
        return "all clear"

    @request("count")
    async def count(self, to: int):
        return [(await self.receive()).content for _ in range(to)]

    @request("sleep")
    async def sleep(self):
        await asyncio.sleep(3600.0)

async def main():
    with ZenohBus.open() as bus:
        async with Container(bus) as container:
            await container.start(Base("base@" + sys.argv[1]))
            print("ready", flush=True)
            await asyncio.to_thread(sys.stdin.read)

asyncio.run(main())
"""


@pytest.fixture
def base(robot: str) -> Iterator[subprocess.Popen[str]]:
    """A process with a container and a base in it."""
    process = subprocess.Popen(
        [sys.executable, "-c", BASE_ALONE, robot], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.send_signal(signal.SIGCONT)
        process.kill()


def test_a_request_and_a_burst_of_messages_cross(base: "subprocess.Popen[str]", robot: str) -> None:
    peer = AgentName("base", robot)

    async def main(console: Agent) -> list[Outcome]:
        looked = await console.request(peer, "look")
        counting = asyncio.ensure_future(console.request(peer, "count", to=150))
        for number in range(150):
            inform = AclMessage(
                performative=Performative.INFORM, sender=console.name, receivers=(peer,), content=number
            )
            console.send(inform)
        return [looked, await counting]

    looked, counted = with_console(main)
    assert looked == Outcome(Ending.DONE, "all clear", agreed=True)
    assert counted == Outcome(Ending.DONE, list(range(150)), agreed=True)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_container_that_is_killed_or_frozen_is_a_peer_that_died(
    base: "subprocess.Popen[str]", robot: str, how: signal.Signals
) -> None:
    async def main(console: Agent) -> list[Outcome]:
        assert (await console.request(f"base@{robot}", "look")).is_done
        sleeping = asyncio.ensure_future(console.request(f"base@{robot}", "sleep", reply_within=3600.0))
        await asyncio.sleep(0)  # now it is asked, before the next
        # The agreement is sent one turn of the loop after the handler begins, maybe after the first of these results.
        for _ in range(2):
            assert (await console.request(f"base@{robot}", "look")).is_done
        base.send_signal(how)
        return [await sleeping]

    (outcome,) = with_console(main)
    assert outcome == Outcome(Ending.DIED, why=f"base@{robot} has gone before the end", agreed=True)


def with_console(main: Callable[[Agent], Awaitable[list[Outcome]]]) -> list[Outcome]:
    """Run a coroutine function with an agent of this process."""

    async def run() -> list[Outcome]:
        with ZenohBus.open() as bus:
            async with Container(bus) as container:
                console = Agent("console@lab")
                await container.start(console)
                return await main(console)

    return asyncio.run(run())

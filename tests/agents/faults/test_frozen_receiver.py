"""Messages to a process that is frozen hold up who sends them for a moment only, and are lost until it goes on."""

import asyncio
import signal
import subprocess
import time
from contextlib import ExitStack

import pytest

from agents.platform import AclMessage, AgentName, Directory, Ending, Performative
from bus import ZenohBus
from tests.agents.faults import processes
from tests.agents.faults.party import meet, party, reach

LONGEST = 10.0  # s; about 3 s is what the bus profiles allow, on a machine that has nothing else to do
MESSAGES = 200  # more than any socket holds
SIZE = 200_000  # bytes


@pytest.mark.parametrize("first", ["receiver", "sender"])  # on the bus: whoever comes later dials the other
def test_who_sends_to_a_frozen_receiver_goes_on_and_reaches_it_again(robot: str, first: str) -> None:
    console, peer = AgentName("console", f"lab-{robot}"), AgentName("worker", robot)

    async def main(bus: ZenohBus, receiver: "subprocess.Popen[str]") -> None:
        message = AclMessage(performative=Performative.INFORM, sender=console, receivers=(peer,), content="x" * SIZE)
        async with party(bus, console) as me:
            with Directory(bus) as directory:
                await meet(bus, peer)
                receiver.send_signal(signal.SIGSTOP)
                longest = 0.0
                for _ in range(MESSAGES):
                    begun = time.monotonic()
                    me.send(message)
                    longest = max(longest, time.monotonic() - begun)
                assert longest < LONGEST
                await processes.until(lambda: not directory.knows(peer), "it counts as dead")
            assert (await me.request(peer, "look")).ending is Ending.DIED
            receiver.send_signal(signal.SIGCONT)
            await reach(me, peer)

    with ExitStack() as stack:
        opened = stack.enter_context(ZenohBus.open()) if first == "sender" else None
        receiver = stack.enter_context(processes.party(peer))
        asyncio.run(main(opened or stack.enter_context(ZenohBus.open()), receiver))

"""The router of a bus is killed and started again, or frozen and let go on, while agents talk through it."""

import asyncio
import signal
import socket
import subprocess
from contextlib import ExitStack
from typing import Any

import pytest

from agents.platform import AclMessage, AgentName, Directory, Ending, Performative
from bus import ZenohBus
from bus.session import configuration
from tests.agents.faults import processes
from tests.agents.faults.party import conversations, meet, party, reach
from tests.agents.faults.worker import Worker
from tests.waiting import waiting

CONSOLE, WORKER = AgentName("console", "lab"), AgentName("worker", "happy")


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_conversations_end_clearly_and_all_is_as_before_when_the_router_is_back(how: signal.Signals) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        address = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    client = configuration("router", {"connect/endpoints": [address]})

    async def main(stack: ExitStack, router: "Router") -> None:
        there, here, elsewhere = (stack.enter_context(ZenohBus(client)) for _ in range(3))
        directory, consoles_own = (stack.enter_context(Directory(bus)) for bus in (elsewhere, here))
        async with party(there, WORKER) as worker, party(here, CONSOLE) as console:
            await processes.until(lambda: directory.names == [CONSOLE, WORKER], "both are listed")
            await meet(here, WORKER)
            heard = listen(console)
            begun = {name: asyncio.ensure_future(one) for name, one in conversations(console, WORKER).items()}
            await processes.until(lambda: worker.at_work == len(begun), "they are in the middle of it")

            router.fail(how)
            async with waiting():
                endings = {name: await one for name, one in begun.items()}
            assert endings.pop("cancel") in (Ending.DIED, Ending.CANCELLED)
            assert set(endings.values()) == {Ending.DIED}
            await processes.until(lambda: directory.names == [], "nobody is listed")
            await processes.until(lambda: WORKER not in consoles_own.names, "the console's session has noticed, too")
            await processes.until(lambda: worker.at_work <= 1, "the worker has left all but what clings")
            assert (await console.request(WORKER, "look")).ending is Ending.DIED
            worker.publish({"number": 1})  # which nobody hears, and which does no harm
            console.send(AclMessage(performative=Performative.INFORM, sender=CONSOLE, receivers=(WORKER,)))

            await asyncio.to_thread(router.come_back)
            await processes.until(lambda: directory.names == [CONSOLE, WORKER], "both are listed again")
            await reach(console, WORKER)
            assert [found.name for found in await directory.search(robot="happy")] == [WORKER]
            async with console.subscribe(WORKER, "count") as values:
                assert await anext(values) == 0
            await processes.until(lambda: worker.is_heard, "its results are listened to again")
            worker.publish({"number": 2})
            await processes.until(lambda: heard, "a result has come")
            assert heard == [{"number": 2}]

    with ExitStack() as stack, Router(address) as router:
        asyncio.run(main(stack, router))


class Router(ExitStack):
    """A router that fails and comes back."""

    def __init__(self, address: str) -> None:
        super().__init__()
        self._address = address
        self._process = self._started()

    def fail(self, how: signal.Signals) -> None:
        """Be killed or frozen."""
        self._how = how
        self._process.send_signal(how)

    def come_back(self) -> None:
        """Be there again."""
        if self._how is signal.SIGKILL:
            self._process = self._started()
        else:
            self._process.send_signal(signal.SIGCONT)

    def _started(self) -> "subprocess.Popen[str]":
        return self.enter_context(processes.running("acromovi", "router", "--listen", self._address, says="routing"))


def listen(console: Worker) -> list[dict[str, Any]]:
    """What it hears of the worker's results."""
    heard: list[dict[str, Any]] = []

    async def hear(result: dict[str, Any]) -> None:
        heard.append(result)

    console.listen(WORKER.results_key, hear)
    return heard

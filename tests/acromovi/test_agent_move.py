"""An agent moves between containers in processes of their own while others talk to it all the time."""

import asyncio
import subprocess
import sys
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

from agents.platform import AclMessage, Agent, AgentName, Container, Outcome, Performative
from bus import ZenohBus
from tests.acromovi.container_process import ROOT, container
from tests.waiting import waiting

WANDERER = """
import asyncio
from pathlib import Path
from agents.platform import Agent, request

class Wanderer(Agent):
    async def setup(self):
        self.served, self.heard = [], []
        while "gate" in self.properties and not Path(self.properties["gate"]).exists():
            await asyncio.sleep(0.02)
        self.add(self.hear)

    def pack(self):
        return {"served": self.served, "heard": self.heard}

    def unpack(self, state):
        self.served, self.heard = state["served"], state["heard"]

    async def hear(self):
        while True:
            self.heard.append((await self.receive()).content)

    @request("serve")
    async def serve(self, number: int):
        self.served.append(number)
        await asyncio.sleep(0.01)
        return self.home.name

    @request("tell")
    async def tell(self):
        return {"served": self.served, "heard": self.heard}
"""
KIND = "wanderer_in_processes:Wanderer"
MOST_AT_A_TIME = 50  # requests; an agent that moves lets 100 of one asker wait and refuses more, however long it takes


@pytest.fixture
def apps(tmp_path: Path) -> str:
    (tmp_path / "wanderer_in_processes.py").write_text(WANDERER)
    return str(tmp_path)


@pytest.fixture
def gate(tmp_path: Path) -> Path:
    """While this file is missing, the setup of an agent that is told of it does not end."""
    gate = tmp_path / "gate"
    gate.touch()
    return gate


@pytest.fixture
def processes(robot: str, apps: str) -> "Iterator[dict[str, subprocess.Popen[str]]]":
    """Two containers: `here` and `there`, each with the robot's name before it."""
    with ExitStack() as stack:
        names = [f"{robot}-here", f"{robot}-there"]
        yield {name: stack.enter_context(container(name, "--apps", apps)) for name in names}


class Crowd:
    """Talks to one agent without a pause: requests, `MOST_AT_A_TIME` of them, and messages that are numbered.

    asked: the requests. told: how many messages were sent.
    """

    def __init__(self, console: Agent, peer: AgentName) -> None:
        self.asked: list[asyncio.Task[Outcome]] = []
        self.told = 0
        self._console = console
        self._peer = peer
        self._work = [asyncio.ensure_future(work) for work in (self._ask(), self._tell())]

    async def end(self) -> list[Outcome]:
        """Say no more; how the requests ended."""
        for work in self._work:
            work.cancel()
        return await asyncio.gather(*self.asked)

    async def _ask(self) -> None:
        while True:
            while len([asked for asked in self.asked if not asked.done()]) >= MOST_AT_A_TIME:
                await asyncio.sleep(0.05)
            number = len(self.asked)
            request = self._console.request(self._peer, "serve", reply_within=60.0, number=number)
            self.asked.append(asyncio.ensure_future(request))
            await asyncio.sleep(0.05)

    async def _tell(self) -> None:
        while True:
            message = AclMessage(
                performative=Performative.INFORM,
                sender=self._console.name,
                receivers=(self._peer,),
                content=self.told,
            )
            self._console.send(message)
            self.told += 1
            await asyncio.sleep(0.005)


def test_an_agent_moves_there_and_back_under_fire_and_nothing_is_lost_or_doubled(
    robot: str, processes: "dict[str, subprocess.Popen[str]]"
) -> None:
    peer, (here, there) = AgentName("wanderer", robot), processes

    async def main(console: Agent) -> None:
        await acromovi("agent", "start", str(peer), KIND, "--in", here)
        seen: list[bool] = []
        console.bus.watch_alive(peer.alive_key, lambda key, is_alive: seen.append(is_alive))
        crowd = Crowd(console, peer)
        for to in (there, here):
            said = await acromovi("agent", "move", str(peer), to)
            assert said == (0, f"{peer} is active in {to}\n", "")
        outcomes = await crowd.end()
        assert Counter(outcome.ending for outcome in outcomes) == {"done": len(outcomes)}
        assert {outcome.result for outcome in outcomes} == {here, there}
        kept = await told_by(console, peer, crowd.told)
        assert sorted(kept["served"]) == list(range(len(outcomes)))
        assert kept["heard"] == list(range(crowd.told))
        assert seen == [True], "it was there all the time"

    with_console(robot, main)


def test_a_container_that_is_killed_in_the_middle_leaves_the_agent_where_it_was(
    robot: str, processes: "dict[str, subprocess.Popen[str]]", gate: Path
) -> None:
    peer, (here, there) = AgentName("wanderer", robot), processes

    async def main(console: Agent) -> None:
        await acromovi("agent", "start", str(peer), KIND, f"gate={gate}", "--in", here)
        gate.unlink()
        crowd = Crowd(console, peer)
        moving = asyncio.ensure_future(acromovi("agent", "move", str(peer), there))
        await until_it_arrives(console, peer, there)
        processes[there].kill()
        code, _, why = await moving
        assert code == 1
        assert f"{peer} stays in {here}: " in why
        outcomes = await crowd.end()
        assert {(outcome.ending, outcome.result) for outcome in outcomes} == {("done", here)}
        kept = await told_by(console, peer, crowd.told)
        assert sorted(kept["served"]) == list(range(len(outcomes)))
        assert kept["heard"] == list(range(crowd.told))

    with_console(robot, main)


def test_a_container_that_is_killed_after_it_has_packed_an_agent_loses_neither_it_nor_its_state(
    robot: str, processes: "dict[str, subprocess.Popen[str]]", gate: Path
) -> None:
    peer, (here, there) = AgentName("wanderer", robot), processes

    async def main(console: Agent) -> None:
        await acromovi("agent", "start", str(peer), KIND, f"gate={gate}", "--in", here)
        gate.unlink()
        for number in range(3):
            assert (await console.request(peer, "serve", number=number)).result == here
        moving = asyncio.ensure_future(acromovi("agent", "move", str(peer), there))
        await until_it_arrives(console, peer, there)
        waits = asyncio.ensure_future(console.request(peer, "serve", number=3))
        await asyncio.sleep(0)
        processes[here].kill()
        waited = await waits  # before the door of the one that died; it hears of that at once
        code, _, why = await moving
        assert code == 1, why
        gate.touch()
        async with waiting(30.0):
            while not (outcome := await console.request(peer, "serve", number=4)).is_done:
                await asyncio.sleep(0.1)
        assert outcome.result == there
        assert (await told_by(console, peer, 0))["served"] == [0, 1, 2, *[3] * waited.is_done, 4]

    with_console(robot, main)


async def acromovi(*words: str) -> tuple[int | None, str, str]:
    """Run a command: exit code, what it prints, and its errors."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "acromovi", *words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    shown, errors = await process.communicate()
    return process.returncode, shown.decode(), errors.decode()


async def told_by(console: Agent, peer: AgentName, messages: int) -> dict[str, Any]:
    """What the agent has served and heard, once it has heard so many messages."""
    async with waiting():
        while True:
            kept: dict[str, Any] = (await console.request(peer, "tell")).value()
            if len(kept["heard"]) >= messages:
                return kept


async def until_it_arrives(console: Agent, peer: AgentName, where: str) -> None:
    """Wait until an agent is being set up in a container."""
    async with waiting():
        while True:
            with suppress(TimeoutError):  # not there yet: asked again until the deadline above
                listed = await console.query(f"{where}/containers/{where}/description")
                if [row["name"] for row in listed["agents"]] == [str(peer)]:
                    return
            await asyncio.sleep(0.02)


def with_console(robot: str, main: Callable[[Agent], Awaitable[None]]) -> None:
    """Run a coroutine function with an agent of this process."""

    async def run() -> None:
        with ZenohBus.open() as bus:
            async with Container(bus) as home:
                console = Agent(AgentName("console", robot))
                await home.start(console)
                await main(console)

    asyncio.run(run())

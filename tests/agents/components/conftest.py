"""A robot, its driver, a bus and agents under one virtual clock."""

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Mapping
from typing import Any, TypeVar

import pytest

from acromovi.lockstep import Lockstep
from agents.components.robot_agents import RobotAgents
from agents.platform import Agent, AgentName, Container, Outcome, Report
from agents.platform.virtual_time import VirtualTimeLoop
from p2os_emu.emulator import STEP
from p2os_emu.world import WorldSpec, load_world
from tests.agents.components.bench import Bench

T = TypeVar("T")
ROBOT = "happy"


class Lab:
    """The robot `happy` in a world, the agents of its elements, and `app@lab`, which asks them.

    reports: what went wrong in the robot's container, in words.
    """

    def __init__(self, loop: VirtualTimeLoop, world: WorldSpec, model: str, fit: str, perfect: bool) -> None:
        self.loop = loop
        self.lockstep = Lockstep(world, {ROBOT: model}, fits={ROBOT: fit}, perfect=perfect)
        self.reports: list[str] = []
        self.app = Agent(AgentName("app", "lab"))
        self.bus = self.lockstep.bus()
        self.container = Container(self.bus, ROBOT, self._note)
        self.office = Container(self.lockstep.bus(), "lab")
        self._tasks: list[asyncio.Task[None]] = []
        self.do(self._begin())

    async def _begin(self) -> None:
        await self.office.start(self.app)
        self._tasks = [asyncio.ensure_future(self._live()), asyncio.ensure_future(self._keep_agents())]

    async def _live(self) -> None:
        """Let the world keep up with the loop's time."""
        while True:
            self.lockstep.run(STEP)
            await asyncio.sleep(STEP)

    async def _keep_agents(self) -> None:
        await RobotAgents(self.container, ROBOT).run()

    def _note(self, report: Report) -> None:
        self.reports.append(f"{report.agent}: {report.what}: {report.error}")

    @property
    def elements(self) -> set[str]:
        """Those whose agents live."""
        return {agent.name.local for agent in self.container.agents}

    def do(self, work: Awaitable[T]) -> T:
        """Let time pass until this is done."""

        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.loop.run_for(seconds)

    def until(self, condition: Callable[[], object], limit: float = 20.0) -> None:
        """Let time pass until a condition holds."""
        deadline = self.loop.time() + limit
        while not condition():
            assert self.loop.time() < deadline, f"waited {limit} s of virtual time in vain"
            self.loop.run_for(0.02)

    def begin(self, element: str, name: str, within: float = 100.0, **arguments: Any) -> "asyncio.Task[Outcome]":
        """Ask an agent of the robot for something, without waiting."""
        peer = AgentName(element, ROBOT)
        return self.loop.create_task(self.app.request(peer, name, reply_within=within, **arguments))

    def ask(self, element: str, name: str, **arguments: Any) -> Outcome:
        """Ask an agent of the robot for something, and wait for the end."""
        return self.do(self.begin(element, name, **arguments))

    def value(self, element: str, name: str, **arguments: Any) -> Any:
        """The same; it must be done."""
        return self.ask(element, name, **arguments).value()

    def results(self, element: str) -> list[Mapping[str, Any]]:
        """What an agent sends from now on, in a list that grows."""
        heard: list[Mapping[str, Any]] = []

        async def hear(result: Mapping[str, Any]) -> None:
            heard.append(result)

        async def listen() -> None:
            self.app.listen(AgentName(element, ROBOT).results_key, hear, keep=100)

        self.do(listen())
        return heard

    def close(self) -> None:
        """End everything."""
        for task in self._tasks:
            task.cancel()
        self.do(asyncio.wait(self._tasks))
        self.do(self.office.close())
        self.do(self.container.close())
        self.lockstep.close()


MakeLab = Callable[..., Lab]


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()


@pytest.fixture
def make_lab(loop: VirtualTimeLoop) -> Iterator[MakeLab]:
    """Make a lab; its agents live when it is returned."""
    made: list[Lab] = []

    def make(fit: str = "", model: str = "p3dx-sh", world: str = "empty", perfect: bool = True) -> Lab:
        lab = Lab(loop, load_world(world), model, fit, perfect)
        made.append(lab)
        lab.until(lambda: {"base", "sonar"} <= lab.elements)
        return lab

    yield make
    for lab in made:
        lab.close()


@pytest.fixture
def lab(make_lab: MakeLab) -> Lab:
    """A lab with a plain Pioneer in an empty world."""
    return make_lab()


@pytest.fixture
def make_bench(loop: VirtualTimeLoop) -> Iterator[Callable[..., Bench]]:
    """Put the component of an element on a bench, with what the description says of it."""
    made: list[Bench] = []

    def make(element: str, **properties: Any) -> Bench:
        made.append(Bench(loop, element, properties))
        return made[-1]

    yield make
    for bench in made:
        bench.close()

"""The agents of a robot are its elements, whatever becomes of robot, cable and description."""

import asyncio
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from agents.components.all_components import DERIVED
from agents.components.robot_agents import RobotAgents
from agents.platform import Agent, AgentName, AlreadyThere, Container, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, Refused, Subscription, keys
from tests.agents.components.conftest import Lab, MakeLab

PLAIN = {"base", "battery", "io", "sonar", "sound", "servos"}
FURTHER = set(DERIVED["sonar"])
"""Agents of every robot with range sensors that are those of no element."""


def test_a_robot_has_an_agent_for_each_of_its_elements(lab: Lab) -> None:
    lab.run(1.0)
    (answer,) = lab.bus.query("happy/description")
    described = {element["name"] for element in answer.value["elements"]}
    assert lab.elements == described | FURTHER
    assert described >= PLAIN
    assert lab.reports == []


def test_a_laser_that_is_unplugged_takes_its_agent_with_it_and_brings_it_back(make_lab: MakeLab) -> None:
    lab = make_lab("laser")
    lab.until(lambda: "laser" in lab.elements)
    others = lab.elements - {"laser"}
    before = [agent for agent in lab.container.agents if agent.name.local != "laser"]
    cut = lab.lockstep.fault("line-cut:cable=laser")
    lab.until(lambda: "laser" not in lab.elements, 5.0)
    assert lab.elements == others
    lab.lockstep.clear(cut)
    lab.until(lambda: "laser" in lab.elements)
    assert all(agent in lab.container.agents for agent in before)


def test_a_robot_whose_cable_is_cut_keeps_its_agents(lab: Lab) -> None:
    lab.run(1.0)
    before = lab.container.agents
    lab.lockstep.fault("line-cut@0+3")
    lab.run(8.0)
    assert lab.container.agents == before


class Gateway:
    """What agents see of a gateway: tokens and a description, as the test wants them."""

    def __init__(self, bus: MemoryBus, robot: str = "happy") -> None:
        self.bus = bus
        self.robot = robot
        self.elements: dict[str, dict[str, Any]] = {}
        self.refuses = False
        self._serving: Subscription | None = None
        self._tokens: dict[str, Subscription] = {}

    def answer(self, is_there: bool = True) -> None:
        if is_there:
            self._serving = self.bus.serve(keys.DESCRIPTION.key(self.robot), self._describe)
        elif self._serving is not None:
            self._serving.close()

    def _describe(self, arguments: dict[str, Any]) -> dict[str, Any]:
        if self.refuses:
            raise Refused("not now")
        return {"model": "p3dx-sh", "elements": list(self.elements.values())}

    def add(self, name: str, streams: tuple[str, ...] = (), **extras: Any) -> None:
        self.describe(name, streams, **extras)
        self._tokens[name] = self.bus.declare_alive(keys.ELEMENT_ALIVE.key(self.robot, name))

    def describe(self, name: str, streams: tuple[str, ...] = (), **extras: Any) -> None:
        self.elements[name] = {"name": name, "streams": list(streams), "commands": [], **extras}

    def remove(self, name: str) -> None:
        del self.elements[name]
        self._tokens.pop(name).close()


class Home:
    """The container of a robot's agents."""

    def __init__(self, loop: VirtualTimeLoop, bus: MemoryBus, robot: str = "happy") -> None:
        self.loop = loop
        self.bus = bus
        self.reports: list[str] = []
        self.container = Container(bus, robot, self._note)
        self.task = loop.create_task(self._run(robot))

    async def _run(self, robot: str) -> None:
        await RobotAgents(self.container, robot).run()

    def _note(self, report: Report) -> None:
        self.reports.append(report.what)

    @property
    def agents(self) -> dict[str, Agent]:
        return {agent.name.local: agent for agent in self.container.agents}

    def do(self, work: Any) -> Any:
        return self.loop.run_until_complete(work)

    def close(self) -> None:
        self.task.cancel()
        self.do(asyncio.wait([self.task]))
        self.do(self.container.close())

    def die(self) -> None:
        """As a process that is killed: nothing is closed in order, and the bus sees that it has gone."""
        self.task.cancel()
        self.bus.close()


class World(Home):
    """The robot happy, as a gateway shows it, and its container."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        super().__init__(loop, MemoryBus())
        self.gateway = Gateway(self.participant())
        self.others: list[Home] = []

    def participant(self) -> MemoryBus:
        return MemoryBus(self.bus.network)

    def another_container(self, robot: str = "happy") -> Home:
        self.others.append(Home(self.loop, self.participant(), robot))
        return self.others[-1]

    def another_gateway(self, robot: str = "happy") -> Gateway:
        return Gateway(self.participant(), robot)


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[World]:
    world = World(loop)
    yield world
    for home in (*world.others, world):
        home.close()


def test_a_robot_that_vanishes_and_returns_takes_its_agents_along(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    first = world.agents["thermometer"]
    world.gateway.remove("thermometer")
    world.gateway.answer(False)
    world.loop.run_for(0.1)
    assert world.agents == {}
    world.loop.run_for(60.0)
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    assert world.agents["thermometer"] is not first


def test_a_gateway_that_is_killed_takes_the_agents_along_and_another_brings_them_back(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    world.gateway.bus.close()
    world.loop.run_for(0.1)
    assert world.agents == {}
    again = world.another_gateway()
    again.answer()
    again.add("thermometer")
    again.add("barometer")
    world.loop.run_for(0.1)
    assert set(world.agents) == {"thermometer", "barometer"}


def test_an_element_that_is_lost_for_a_moment_only_has_an_agent_afterwards(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    for _ in range(5):
        world.gateway.remove("thermometer")
        world.gateway.add("thermometer")
    world.loop.run_for(1.0)
    assert set(world.agents) == {"thermometer"}


def test_two_robots_in_two_containers_have_nothing_to_do_with_each_other(world: World) -> None:
    grumpy, home = world.another_gateway("grumpy"), world.another_container("grumpy")
    for gateway in (world.gateway, grumpy):
        gateway.answer()
        gateway.add("thermometer")
    grumpy.add("barometer")
    world.loop.run_for(0.1)
    assert (set(world.agents), set(home.agents)) == ({"thermometer"}, {"thermometer", "barometer"})
    assert str(home.agents["thermometer"].name) == "thermometer@grumpy"
    grumpy.bus.close()
    world.loop.run_for(0.1)
    assert (set(world.agents), set(home.agents)) == ({"thermometer"}, set())


@pytest.mark.parametrize("is_killed", [False, True])
@pytest.mark.parametrize("is_early", [False, True])
def test_a_container_that_is_started_again_has_the_same_agents(world: World, is_killed: bool, is_early: bool) -> None:
    gateway, first = world.another_gateway("grumpy"), world.another_container("grumpy")
    gateway.answer()
    gateway.add("thermometer")
    world.loop.run_for(0.1)
    before = first.agents["thermometer"]
    second = world.another_container("grumpy") if is_early else None  # it finds that there is an agent, and waits
    world.loop.run_for(0.1)
    assert second is None or second.agents == {}
    if is_killed:
        first.die()
    else:
        first.close()
    second = second or world.another_container("grumpy")
    world.loop.run_for(0.1)
    assert set(second.agents) == {"thermometer"}
    assert second.agents["thermometer"] is not before


def test_an_agent_that_somebody_else_has_just_started_is_taken_over_when_it_goes(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def come_too_late(agent: Agent) -> bool:
        monkeypatch.undo()
        raise AlreadyThere("somebody was faster")

    other = Container(world.participant(), "lab")
    monkeypatch.setattr(world.container, "start", come_too_late)
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    world.do(other.start(Agent(AgentName("thermometer", "happy"))))
    world.loop.run_for(1.0)
    assert world.agents == {}
    world.do(other.close())
    world.loop.run_for(0.1)
    assert set(world.agents) == {"thermometer"}


@pytest.mark.parametrize("is_silent", [True, False])
def test_a_description_that_does_not_come_is_asked_for_until_it_does(world: World, is_silent: bool) -> None:
    world.gateway.add("thermometer")
    world.gateway.refuses = True
    world.gateway.answer(not is_silent)
    world.loop.run_for(40.0)
    assert world.agents == {}
    world.gateway.refuses = False
    world.gateway.answer()
    world.loop.run_for(20.0)
    assert set(world.agents) == {"thermometer"}


def test_a_token_that_comes_before_its_description_waits_for_it(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer")
    row = world.gateway.elements.pop("thermometer")
    world.loop.run_for(1.0)
    assert world.agents == {}
    world.gateway.elements["thermometer"] = row
    world.loop.run_for(2.0)
    assert set(world.agents) == {"thermometer"}


def test_what_an_element_says_later_reaches_its_agent(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer", reach=1.0)
    world.loop.run_for(0.1)
    agent = world.agents["thermometer"]
    world.gateway.describe("thermometer", reach=2.0)
    world.loop.run_for(11.0)
    assert world.agents["thermometer"] is agent
    assert agent.properties["reach"] == 2.0


def test_an_element_with_other_streams_gets_another_agent(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("gyro")
    world.loop.run_for(0.1)
    agent = world.agents["gyro"]
    world.gateway.describe("gyro", ("happy/imu",))
    world.loop.run_for(11.0)
    assert world.agents["gyro"] is not agent
    assert world.agents["gyro"].properties["streams"] == ["happy/imu"]


def test_an_agent_that_somebody_stopped_stays_away_until_its_element_returns(world: World) -> None:
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    world.do(world.container.stop(AgentName("thermometer", "happy")))
    world.loop.run_for(60.0)
    assert world.agents == {}
    world.gateway.remove("thermometer")
    world.loop.run_for(0.1)
    world.gateway.add("thermometer")
    world.loop.run_for(0.1)
    assert set(world.agents) == {"thermometer"}


def test_an_agent_that_lives_elsewhere_is_not_made_twice(world: World) -> None:
    other = Container(MemoryBus(world.bus.network), "lab")
    world.do(other.start(Agent(AgentName("thermometer", "happy"))))
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(1.0)
    assert world.agents == {}
    world.do(other.close())
    world.loop.run_for(1.0)
    assert set(world.agents) == {"thermometer"}


def test_a_setup_that_fails_is_tried_again_at_growing_pauses(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    attempts: list[float] = []

    class Shy(Agent):
        async def setup(self) -> None:
            attempts.append(world.loop.time())
            if len(attempts) < 5:
                raise OSError("not yet")

    monkeypatch.setattr("agents.components.robot_agents.component_for", make_of(Shy))
    world.gateway.answer()
    world.gateway.add("thermometer")
    world.loop.run_for(30.0)
    assert len(attempts) == 5
    pauses = [later - earlier for earlier, later in itertools.pairwise(attempts)]
    assert pauses[-1] > 2 * pauses[0]
    assert world.reports == ["its setup failed"] * 4
    assert set(world.agents) == {"thermometer"}


def make_of(kind: type[Agent]) -> Callable[[str], Any]:
    class Made:
        properties_of = staticmethod(lambda robot, element: dict(element))

        def __new__(cls, name: AgentName, properties: dict[str, Any]) -> Agent:  # type: ignore[misc]  # it is made as its kind
            return kind(name, properties)

    return lambda element: Made


@pytest.mark.parametrize(
    "nonsense", [None, 3, ["base"], [{"name": "base"}], [{"name": 1, "streams": [], "commands": []}]]
)
def test_a_description_without_sense_describes_nothing(nonsense: Any) -> None:
    assert RobotAgents.described({"elements": nonsense}) == {}


def test_an_element_that_is_described_twice_has_the_streams_of_both() -> None:
    rows = [{"name": "gyro", "streams": [], "commands": []}, {"name": "gyro", "streams": ["a/imu"], "commands": []}]
    assert RobotAgents.described({"elements": rows})["gyro"]["streams"] == ["a/imu"]

"""Containers from outside: on a bus in memory and in virtual time."""

import asyncio
import json
from collections.abc import Coroutine, Iterator
from pathlib import Path
from typing import Any

import pytest

from agents.platform import AclMessage, Agent, AgentName, AgentState, Container, Kinds, Performative
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, Refused, Sample
from bus.aio import query

WALKER = """
import asyncio
from agents.platform import Agent, every, on, request

class Walker(Agent):
    services = ("walk",)

    async def setup(self):
        self.steps = 0
        if self.properties.get("lame"):
            raise ValueError("it is lame")
        if self.properties.get("slow"):
            await asyncio.sleep(1.0)

    @every(1.0)
    async def step(self):
        self.steps += 1
        if self.properties.get("stumbles"):
            raise RuntimeError("over a stone")

    @on("sonar")
    async def look(self, sonar):
        pass

    @request("walk")
    async def walk(self, seconds: float):
        await asyncio.sleep(seconds)
        return self.steps

class Picky(Agent):
    def __init__(self, name, robot, element):
        super().__init__(name)
"""


class World:
    """A container that is looked at from another bus."""

    def __init__(self, loop: VirtualTimeLoop, folder: Path) -> None:
        (folder / "walker_for_tests.py").write_text(WALKER)
        self.loop = loop
        self.network = MemoryNetwork()
        self.outside = MemoryBus(self.network)
        self.container = Container(
            MemoryBus(self.network), "yard", lambda report: None, loop.time, platform="team", kinds=Kinds([folder])
        )
        self.container_is_shown(self.container)

    def container_is_shown(self, container: Container) -> None:
        async def show() -> None:
            container.show()

        self.run(show())

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return self.loop.run_until_complete(work)

    def order(self, do: object, **given: object) -> dict[str, Any]:
        key = self.container.called.control_key
        answer: dict[str, Any] = self.run(query(self.outside, key, {"do": do, **given}, 60.0))[0].value
        return answer

    def start(self, name: str = "w@team", **properties: object) -> dict[str, Any]:
        return self.order("start", name=name, kind="walker_for_tests:Walker", properties=properties)


@pytest.fixture
def world(loop: VirtualTimeLoop, tmp_path: Path) -> Iterator[World]:
    world = World(loop, tmp_path)
    yield world
    world.run(world.container.close())
    assert not asyncio.all_tasks(loop), "something is left behind"


def test_a_container_is_seen_until_it_is_closed(world: World) -> None:
    seen: list[tuple[str, bool]] = []
    world.outside.watch_alive("*/containers/*/alive", lambda key, is_alive: seen.append((key, is_alive)))
    world.run(world.container.close())
    assert seen == [("team/containers/yard/alive", True), ("team/containers/yard/alive", False)]


def test_agents_are_started_listed_suspended_resumed_and_stopped_from_outside(world: World) -> None:
    assert world.start(pace=2) == {"name": "w@team", "state": "active"}
    listed = world.order("list")
    assert (listed["container"], listed["platform"]) == ("yard", "team")
    assert listed["agents"] == [{"name": "w@team", "kind": "walker_for_tests:Walker", "state": "active"}]
    assert world.container.agent("w@team").properties == {"pace": 2}
    assert world.order("suspend", name="w@team")["state"] == "suspended"
    assert world.container.agent("w@team").state is AgentState.SUSPENDED
    assert world.order("resume", name="w@team")["state"] == "active"
    assert world.order("stop", name="w@team")["state"] == "deleted"
    assert world.order("list")["agents"] == []


@pytest.mark.parametrize(
    ("order", "why"),
    [
        ({"do": "lst"}, "a container does not obey 'lst'; did you mean list?"),
        ({"do": "dance"}, "a container does not obey 'dance'; it obeys list, start"),
        ({"do": None}, "this order to a container needs 'do', a text"),
        ({"do": "stop"}, "this order to a container needs 'name', a text"),
        ({"do": "stop", "name": "w"}, "'w' names no agent; a name is written like base@happy"),
        ({"do": "stop", "name": "v@team"}, "no agent v@team lives in yard"),
        ({"do": "suspend", "name": "v@team"}, "no agent v@team lives in yard"),
        ({"do": "resume", "name": "v@team"}, "no agent v@team lives in yard"),
        ({"do": "resume", "name": "w@team"}, "w@team is not suspended; it is active"),
        ({"do": "introspect", "name": "v@team"}, "no agent v@team lives in yard"),
        ({"do": "move", "name": "v@team", "to": "x"}, "no agent v@team lives in yard"),
        ({"do": "move", "name": "w@team"}, "this order to a container needs 'to', a text"),
        ({"do": "start", "kind": "walker_for_tests:Walker"}, "this order to a container needs 'name', a text"),
        ({"do": "start", "name": "x@team"}, "this order to a container needs 'kind', a text"),
        (
            {"do": "start", "name": "w@team", "kind": "walker_for_tests:Walker"},
            "an agent w@team lives in the container yard already",
        ),
        ({"do": "start", "name": "x@team", "kind": "walker_for_tests"}, "write module:Class"),
        ({"do": "start", "name": "x@team", "kind": "walker_for_tests:Walkr"}, "did you mean Walker?"),
        ({"do": "start", "name": "x@team", "kind": "walker_for_test:Walker"}, "did you mean walker_for_tests?"),
        (
            {"do": "start", "name": "x@team", "kind": "subprocess:Popen"},
            "there is no module 'subprocess' in the packages",
        ),
        (
            {"do": "start", "name": "x@team", "kind": "agents.platform.agnt:Agent"},
            "did you mean agents.platform.agent?",
        ),
        ({"do": "start", "name": "x@team", "kind": "walker_for_tests:Picky"}, "cannot be made: TypeError"),
        ({"do": "start", "name": "x@team", "kind": "walker_for_tests:Walker", "properties": 1}, "is a JSON object"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_sentence(world: World, order: dict[str, Any], why: str) -> None:
    world.start()
    with pytest.raises(Refused) as refused:
        world.order(**order)
    assert why in str(refused.value)
    assert "\n" not in str(refused.value)
    assert [str(agent.name) for agent in world.container.agents] == ["w@team"]


def test_a_suspended_agent_is_suspended_once_and_can_be_stopped(world: World) -> None:
    world.start()
    world.order("suspend", name="w@team")
    with pytest.raises(Refused, match=r"^w@team is suspended already$"):
        world.order("suspend", name="w@team")
    assert world.order("introspect", name="w@team")["state"] == "suspended"
    assert world.order("stop", name="w@team")["state"] == "deleted"


def test_an_agent_that_lives_elsewhere_is_not_started_again_from_outside(world: World) -> None:
    world.start()
    hall = Container(MemoryBus(world.network), "hall", lambda report: None, kinds=world.container.kinds)
    world.container_is_shown(hall)
    order = {"do": "start", "name": "w@team", "kind": "walker_for_tests:Walker"}
    with pytest.raises(Refused, match="lives in the container yard already; end it there, or take another name"):
        world.run(query(world.outside, hall.called.control_key, order, 60.0))
    assert hall.agents == []
    world.run(hall.close())


def test_a_setup_that_fails_is_told_to_who_started_it(world: World) -> None:
    with pytest.raises(Refused, match=r"^the setup of w@team failed: ValueError: it is lame$"):
        world.start(lame=True)
    assert world.container.agents == []


def test_who_waits_for_an_order_is_told_that_the_container_closes(world: World) -> None:
    heard: list[str] = []

    async def main() -> None:
        given = {"do": "start", "name": "w@team", "kind": "walker_for_tests:Walker", "properties": {"slow": True}}
        asking = asyncio.ensure_future(query(world.outside, world.container.called.control_key, given, 60.0))
        await asyncio.sleep(0.1)
        await world.container.close()
        # what it raises is looked at
        heard.extend(str(each) for each in await asyncio.gather(asking, return_exceptions=True))

    world.run(main())
    assert heard == ["the container yard is being closed"]


def test_an_agent_that_is_being_stopped_ends_as_it_is_to_although_its_container_closes(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    world.start()
    agent = world.container.agent("w@team")
    heard: list[dict[str, Any]] = []
    ended: list[bool] = []

    async def main() -> None:
        async def slow_end() -> None:
            await asyncio.sleep(1.0)
            ended.append(True)

        monkeypatch.setattr(agent, "take_down", slow_end)
        key = world.container.called.control_key
        asking = asyncio.ensure_future(query(world.outside, key, {"do": "stop", "name": "w@team"}, 60.0))
        await asyncio.sleep(0.1)
        await world.container.close()
        heard.extend(answer.value for answer in await asking)

    world.run(main())
    assert heard == [{"name": "w@team", "state": "deleted"}]
    assert ended


def test_introspection_shows_mailbox_behaviours_streams_and_what_is_in_flight(world: World) -> None:
    world.start(stumbles=True)
    console = Agent("console@lab")
    world.run(world.container.start(console))
    told = AclMessage(performative=Performative.INFORM, sender=console.name, receivers=(AgentName("w", "team"),))
    console.send(told)
    asking = world.loop.create_task(console.request("w@team", "walk", seconds=100.0, reply_within=200.0))
    world.loop.run_for(1.5)
    seen = world.order("introspect", name="w@team")
    asking.cancel()
    assert (seen["state"], seen["kind"], seen["requests"]) == ("active", "walker_for_tests:Walker", ["walk"])
    assert (seen["mailbox"]["waiting"], seen["mailbox"]["delivered"], seen["mailbox"]["dropped"]) == (1, 1, 0)
    assert seen["mailbox"]["oldest"][0]["performative"] == "inform"
    assert [(each["name"], each["failures"], each["policy"]) for each in seen["behaviours"]] == [("step", 1, "Restart")]
    assert seen["streams"] == [{"key": "team/sonar", "skipped": 0, "failures": 0}]
    assert [(each["sender"], each["agreed"]) for each in seen["in_flight"]] == [("console@lab", True)]


def test_who_may_look_only_sees_the_same_and_changes_nothing(world: World) -> None:
    def look(**given: object) -> dict[str, Any]:
        key = world.container.called.description_key
        answer: dict[str, Any] = world.run(query(world.outside, key, given, 60.0))[0].value
        return answer

    world.start()
    assert look() == look(do="list") == world.order("list")
    assert look(do="introspect", name="w@team") == world.order("introspect", name="w@team")
    for do in "stop", "suspend", "start", "begin", "adopt":
        with pytest.raises(Refused, match=f"a container does not obey '{do}' where it is described"):
            look(do=do, name="w@team")
    assert world.container.agent("w@team").state is AgentState.ACTIVE


def test_reports_are_heard_on_the_bus(world: World) -> None:
    heard: list[dict[str, Any]] = []
    world.outside.subscribe("*/containers/*/reports", lambda sample: heard.append(json.loads(sample.payload)))
    world.start(stumbles=True)
    world.loop.run_for(1.05)
    (report,) = heard
    assert report["agent"] == "w@team"
    assert report["what"].startswith("step failed: begins again in")
    assert report["error"] == "RuntimeError: over a stone"
    assert report["time"] == pytest.approx(1.0)


def test_what_agents_say_is_heard_on_the_bus_only_while_somebody_listens(world: World) -> None:
    world.start()
    console = Agent("console@lab")
    world.run(world.container.start(console))
    heard: list[Sample] = []
    world.run(console.request("w@team", "walk", seconds=0.0))
    with world.outside.subscribe("*/containers/*/said", heard.append):
        world.run(console.request("w@team", "walk", seconds=0.0))
    world.run(console.request("w@team", "walk", seconds=0.0))
    said = [json.loads(sample.payload) for sample in heard]
    assert [each["message"]["performative"] for each in said] == ["request", "agree", "inform"]
    assert {each["container"] for each in said} == {"yard"}


def test_an_application_that_was_corrected_is_loaded_anew(tmp_path: Path) -> None:
    file = tmp_path / "corrected_for_tests.py"
    kinds = Kinds([tmp_path])
    text = "from agents.platform import Agent\nclass App(Agent):\n    services = ('{}',)\n"
    file.write_text(text.format("first"))
    assert kinds.find("corrected_for_tests:App").services == ("first",)
    file.write_text(text.format("second, and longer"))
    assert kinds.find("corrected_for_tests:App").services == ("second, and longer",)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("import no_such_module", "No module named 'no_such_module'"),
        ("1 / 0", "ZeroDivisionError"),
        ("def", "SyntaxError"),
    ],
)
def test_an_application_that_cannot_be_loaded_is_refused_with_its_mistake(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "broken_for_tests.py").write_text(text)
    with pytest.raises(LookupError, match=f"the module broken_for_tests cannot be loaded: .*{why}"):
        Kinds([tmp_path]).find("broken_for_tests:App")


def test_an_application_named_as_a_module_of_python_is_refused(tmp_path: Path) -> None:
    (tmp_path / "random.py").write_text("")
    with pytest.raises(LookupError, match="'random' is the name of another module of Python"):
        Kinds([tmp_path]).find("random:App")


def test_interface_tells_types_and_defaults_of_what_an_agent_can_be_asked_for(world: World) -> None:
    world.start()
    told = world.order("interface", name="w@team")
    (walk,) = told["requests"]
    assert walk["parameters"] == [{"name": "seconds", "type": "float"}]
    assert told["subscriptions"] == told["answers"] == []

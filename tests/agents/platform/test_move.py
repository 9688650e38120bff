"""Agents that move from one container into another, on a bus in memory and in virtual time."""

import asyncio
import json
import re
from collections.abc import Coroutine, Iterator
from pathlib import Path
from typing import Any

import pytest

from agents.platform import (
    AclMessage,
    Agent,
    AgentName,
    AgentState,
    Container,
    Directory,
    Ending,
    Kinds,
    Outcome,
    Performative,
    Report,
    RequestNotDone,
)
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, Refused
from bus.aio import query

WANDERER = AgentName("wanderer", "team")
KIND = "wanderer_for_tests:Wanderer"
TEXT = """
import asyncio
from agents.platform import Agent, every, request, subscription

class Wanderer(Agent):
    async def setup(self):
        self.count = self.properties.get("first", 0)
        self.read = []
        await asyncio.sleep(self.properties.get("setup", 0.0))
        if self.properties.get("stays in") not in (None, self.home.name):
            raise RuntimeError("only there")

    def pack(self):
        if self.properties.get("cannot pack"):
            raise RuntimeError("too much")
        if self.properties.get("packs nonsense"):
            return {"count": {1, 2}}
        return {"count": self.count, "read": self.read}

    def unpack(self, state):
        self.count, self.read = state["count"], state["read"]

    @request("next")
    async def next(self, seconds: float = 0.0):
        self.count += 1
        mine = self.count
        await asyncio.sleep(seconds)
        return [mine, self.home.name]

    @request("read")
    async def read_all(self):
        while self.mailbox.state.waiting:
            self.read.append((await self.receive()).content)
        return self.read

    @subscription("ticks")
    async def ticks(self):
        while True:
            yield 1
            await asyncio.sleep(1.0)

    @every(1.0)
    async def beat(self):
        self.beats = getattr(self, "beats", 0) + 1
"""


class World:
    """An agent in the container `here`, a container `there`, and somebody who talks to it."""

    def __init__(self, loop: VirtualTimeLoop, folder: Path) -> None:
        (folder / "wanderer_for_tests.py").write_text(TEXT)
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.here, self.there = (self.container(name, Kinds([folder])) for name in ("here", "there"))
        self.lab = self.container("lab", Kinds())
        self.console = Agent("console@lab")
        self.run(self.lab.start(self.console))

    def container(self, name: str, kinds: Kinds) -> Container:
        made = Container(
            MemoryBus(self.network), name, self.reports.append, self.loop.time, platform="team", kinds=kinds
        )

        async def show() -> None:
            made.show()

        self.run(show())
        return made

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return self.loop.run_until_complete(work)

    def begin(self, **properties: object) -> Agent:
        agent = self.here.kinds.make(KIND, WANDERER, properties)
        assert self.run(self.here.start(agent)), self.reports
        return agent

    async def order(self, container: Container, do: str, **given: object) -> dict[str, Any]:
        answers = await query(self.lab.bus, container.called.control_key, {"do": do, **given}, 100.0)
        return answers[0].value

    async def move(self, to: str = "there") -> dict[str, Any]:
        return await self.order(self.here, "move", name=str(WANDERER), to=to)

    def ask(self, name: str, **arguments: Any) -> Outcome:
        outcome: Outcome = self.run(self.console.request(WANDERER, name, **arguments))
        return outcome

    def tell(self, content: object) -> None:
        self.console.send(
            AclMessage(
                performative=Performative.INFORM, sender=self.console.name, receivers=(WANDERER,), content=content
            )
        )

    def lives(self) -> tuple[list[str], list[str]]:
        return [str(each.state) for each in self.here.agents], [str(each.state) for each in self.there.agents]


@pytest.fixture
def world(loop: VirtualTimeLoop, tmp_path: Path) -> Iterator[World]:
    world = World(loop, tmp_path)
    yield world
    for container in (world.here, world.there, world.lab):
        world.run(container.close())
    assert not asyncio.all_tasks(loop), "something is left behind"


def test_an_agent_moves_with_state_properties_and_mailbox(world: World) -> None:
    world.begin(first=7)
    world.ask("next")
    for number in range(3):
        world.tell(number)
    assert world.run(world.move()) == {"name": "wanderer@team", "state": "active", "container": "there"}
    assert world.lives() == ([], ["active"])
    assert world.ask("next").value() == [9, "there"]
    assert world.ask("read").value() == [0, 1, 2]
    assert world.there.agent(WANDERER).properties == {"first": 7}
    world.loop.run_for(2.0)
    assert world.there.agent(WANDERER).beats >= 2  # type: ignore[attr-defined]  # its class is in a file of the test's
    assert world.reports == []


def test_it_is_seen_all_the_time_and_listed_once(world: World) -> None:
    world.begin()
    seen: list[bool] = []
    world.lab.bus.watch_alive(WANDERER.alive_key, lambda key, is_alive: seen.append(is_alive))
    with Directory(world.lab.bus) as directory:
        world.run(world.move())
        (description,) = world.run(directory.search(robot="team"))
    assert seen == [True]
    assert description.container == "there"


def test_what_is_under_way_ends_where_it_began(world: World) -> None:
    world.begin()

    async def main() -> list[Any]:
        asking = asyncio.ensure_future(world.console.request(WANDERER, "next", seconds=3.0))
        await asyncio.sleep(0.1)
        await world.move()
        return [(await asking).value(), (await world.console.request(WANDERER, "next")).value()]

    assert world.run(main()) == [[1, "here"], [2, "there"]]


def test_every_request_during_a_move_is_answered_once(world: World) -> None:
    """They come all the time, while the agent packs, is set up there, and a while after."""
    world.begin(setup=0.3)

    async def main() -> list[Outcome]:
        asking = [asyncio.ensure_future(world.console.request(WANDERER, "next", seconds=0.05))]
        moving = asyncio.ensure_future(world.move())
        while not moving.done():
            await asyncio.sleep(0.007)
            asking.append(asyncio.ensure_future(world.console.request(WANDERER, "next", seconds=0.05)))
        return await asyncio.gather(*asking)

    outcomes = world.run(main())
    assert {outcome.ending for outcome in outcomes} == {Ending.DONE}
    assert sorted(outcome.value()[0] for outcome in outcomes) == list(range(1, len(outcomes) + 1))
    assert {outcome.value()[1] for outcome in outcomes} == {"here", "there"}
    assert len(outcomes) > 100


def test_more_requests_than_may_wait_are_refused_plainly(world: World) -> None:
    world.begin(setup=1.0)

    async def main() -> list[Outcome]:
        moving = asyncio.ensure_future(world.move())
        await asyncio.sleep(0.1)
        asking = [asyncio.ensure_future(world.console.request(WANDERER, "next")) for _ in range(150)]
        await moving
        return await asyncio.gather(*asking)

    outcomes = world.run(main())
    assert [outcome.ending for outcome in outcomes].count(Ending.DONE) == 100
    assert {outcome.why for outcome in outcomes} == {"", "wanderer@team is transit"}


def test_messages_during_a_move_are_neither_lost_nor_doubled_and_keep_their_order(world: World) -> None:
    world.begin(setup=0.2)

    async def main() -> tuple[int, Any]:
        count = 0
        moving = asyncio.ensure_future(world.move())
        while not moving.done():
            for _ in range(3):
                world.tell(count)
                count += 1
            await asyncio.sleep(0.001)
        return count, (await world.console.request(WANDERER, "read")).value()

    count, read = world.run(main())
    assert read == list(range(count))
    assert count > 500


def test_a_foreign_message_without_a_label_comes_in_once(world: World) -> None:
    world.begin(setup=0.2)

    async def main() -> Any:
        moving = asyncio.ensure_future(world.move())
        for number in range(30):
            message = AclMessage(
                performative=Performative.INFORM, sender=world.console.name, receivers=(WANDERER,), content=number
            )
            world.lab.bus.send(WANDERER.acl_key, message.to_dict())
            await asyncio.sleep(0.02)
        await moving
        return (await world.console.request(WANDERER, "read")).value()

    assert world.run(main()) == list(range(30))


def test_a_suspended_agent_arrives_suspended(world: World) -> None:
    world.begin()
    world.here.suspend(WANDERER)
    assert world.run(world.move())["state"] == "suspended"
    assert world.there.agent(WANDERER).state is AgentState.SUSPENDED
    assert world.ask("next").why == "wanderer@team is suspended"
    world.there.resume(WANDERER)
    assert world.ask("next").value() == [1, "there"]


def test_a_subscriber_is_told_to_subscribe_again(world: World) -> None:
    world.begin()

    async def main() -> list[Any]:
        heard: list[Any] = []
        for _ in range(2):
            try:
                async with world.console.subscribe(WANDERER, "ticks") as ticks:
                    async for tick in ticks:
                        heard.append(tick)
                        if len(heard) == 1:
                            moving = asyncio.ensure_future(world.move())
                        if len(heard) == 3:
                            break
            except RequestNotDone as err:
                heard.append(str(err))
        await moving
        return heard

    first, why, *rest = world.run(main())
    assert (first, rest) == (1, [1])
    assert "moves into another container; subscribe again" in why


@pytest.mark.parametrize(
    ("properties", "to", "why"),
    [
        ({}, "here", "it lives in here already"),
        ({}, "nowhere", "there is no container 'nowhere'"),
        ({}, "no/where", "be a part of a container's name"),
        ({"stays in": "here"}, "there", "the setup of wanderer@team failed: RuntimeError: only there"),
        ({"cannot pack": True}, "there", "wanderer@team cannot pack: RuntimeError: too much"),
        ({"packs nonsense": True}, "there", "wanderer@team stays in here: "),
        ({}, "lab", "wanderer@team stays in here: there is no module 'wanderer_for_tests'"),
    ],
)
def test_an_agent_that_cannot_move_goes_on_where_it_is(
    world: World, properties: dict[str, Any], to: str, why: str
) -> None:
    world.begin(**properties)
    world.tell("wait")

    async def main() -> tuple[str, Outcome]:
        moving = asyncio.ensure_future(world.move(to))
        await asyncio.sleep(0)
        asking = asyncio.ensure_future(world.console.request(WANDERER, "next"))
        with pytest.raises(Refused) as refused:
            await moving
        return str(refused.value), await asking

    said, outcome = world.run(main())
    assert why in said
    assert outcome.value() == [1, "here"]
    assert world.ask("read").value() == ["wait"]
    assert world.lives() == (["active"], [])


def test_an_agent_that_does_not_finish_stays_and_says_with_what(world: World) -> None:
    world.begin()

    async def main() -> str:
        asking = asyncio.ensure_future(world.console.request(WANDERER, "next", seconds=8.0))
        await asyncio.sleep(0.1)
        with pytest.raises(Refused) as refused:
            await world.move()
        assert (await asking).value() == [1, "here"]
        return str(refused.value)

    assert world.run(main()) == (
        "wanderer@team stays where it is: it has not finished within 5 s with the request of console@lab"
    )
    assert world.ask("next").value() == [2, "here"]


def test_it_goes_on_where_it_was_when_the_other_container_dies_before_it_lives_there(world: World) -> None:
    world.begin(setup=0.5)
    world.tell("wait")

    async def main() -> tuple[str, Outcome]:
        moving = asyncio.ensure_future(world.move())
        await asyncio.sleep(0.2)
        asking = asyncio.ensure_future(world.console.request(WANDERER, "next"))
        world.there.bus.close()
        with pytest.raises(Refused) as refused:
            await moving
        return str(refused.value), await asking

    said, outcome = world.run(main())
    assert said == "wanderer@team stays in here: there does not answer"
    assert outcome.value() == [1, "here"]
    assert world.ask("read").value() == ["wait"]


def test_two_moves_at_once_are_one(world: World) -> None:
    world.begin()

    async def main() -> Any:
        return await asyncio.gather(world.move(), world.move(), return_exceptions=True)  # both outcomes are looked at

    done, refused = world.run(main())
    assert done["container"] == "there"
    assert str(refused) == "wanderer@team is moving already"
    assert world.ask("next").value() == [1, "there"]


def test_it_lives_on_there_when_the_container_dies_from_which_it_came(world: World) -> None:
    """The order `settle` never comes."""
    world.begin()

    async def main() -> None:
        adopt = {"name": str(WANDERER), "kind": KIND, "properties": {}, "from": "team/containers/gone/control"}
        migration = {"state": {"count": 5, "read": []}, "mailbox": [], "suspended": False}
        await world.here.stop(WANDERER)
        await world.order(world.there, "adopt", **adopt, luggage=migration)
        outcome = await world.console.request(WANDERER, "next", reply_within=30.0)
        assert outcome.value() == [6, "there"]

    world.run(main())
    assert [report.what for report in world.reports] == [
        "the container from which it came has died; what came there last is lost"
    ]


def test_it_is_told_as_moved_and_not_as_stopped(world: World) -> None:
    world.begin()
    told: list[Any] = []
    world.lab.bus.subscribe(
        world.here.called.reports_key, lambda sample: told.append(json.loads(sample.payload)["ended"])
    )
    world.run(world.move())
    assert told == ["moved"]


def test_it_is_let_go_there_when_it_lives_on_where_it_was(world: World) -> None:
    world.begin()

    async def main() -> None:
        adopt = {"name": str(WANDERER), "kind": KIND, "properties": {}, "from": world.here.called.control_key}
        migration = {"state": {"count": 5, "read": []}, "mailbox": [], "suspended": False}
        await world.order(world.there, "adopt", **adopt, luggage=migration)
        assert world.lives() == (["active"], ["transit"])
        await asyncio.sleep(20.0)

    world.run(main())
    assert world.lives() == (["active"], [])
    assert world.ask("next").value() == [1, "here"]


def test_it_lives_there_when_only_the_answer_was_lost_that_says_so(world: World) -> None:
    world.begin()
    settle = world.there._control._settle

    async def mute(given: Any) -> dict[str, Any]:
        await settle(given)
        raise Refused("the answer is lost")

    world.there._control._orders["settle"] = mute
    world.run(world.move())
    assert world.lives() == ([], ["active"])


def test_it_lives_once_when_the_container_that_it_left_was_frozen_and_meets_the_others_later(world: World) -> None:
    world.begin()
    settle, listed = world.there._control._settle, world.there._control._list

    async def mute(given: Any) -> dict[str, Any]:
        await settle(given)
        world.there._control._orders["list"] = not_met
        raise Refused("the answer is lost")

    async def not_met(given: Any) -> dict[str, Any]:
        world.there._control._orders["list"] = listed
        raise Refused("they have not met again")

    world.there._control._orders["settle"] = mute
    world.run(world.move())
    assert world.lives() == ([], ["active"])
    assert world.ask("next").value() == [1, "there"]


def test_messages_follow_once_when_nobody_knows_whether_they_came_along(world: World) -> None:
    """It has begun to live there by itself, and so without what waited here."""
    world.begin()
    settle = world.there._control._settle

    async def without_letters(given: Any) -> dict[str, Any]:
        await settle({**given, "letters": given["letters"][:3]})
        raise Refused("none of this name has arrived")

    world.there._control._orders["settle"] = without_letters

    async def main() -> tuple[int, Any]:
        count = 0
        moving = asyncio.ensure_future(world.move())
        while not moving.done():
            world.tell(count)
            count += 1
            await asyncio.sleep(0.001)
        return count, (await world.console.request(WANDERER, "read")).value()

    count, read = world.run(main())
    assert sorted(read) == list(range(count))


def test_who_was_given_up_lives_once_although_it_had_begun_to_live_there(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other container was frozen: it settles the agent, and hears right after that it lives on here."""
    world.begin()
    settle = world.there._control._settle

    async def too_late(given: Any) -> dict[str, Any]:
        await settle(given)
        raise Refused("the answer is lost")

    async def nobody_knows(*whom: object) -> bool:
        return False

    world.there._control._orders["settle"] = too_late
    monkeypatch.setattr(world.here._control._departures, "_lives", nobody_knows)  # it is cut off
    with pytest.raises(Refused):
        world.run(world.move())
    world.loop.run_for(0.1)
    assert world.lives() == (["active"], [])
    assert world.ask("next").value() == [1, "here"]


def test_an_agent_that_is_stopped_on_the_way_lives_nowhere(world: World) -> None:
    world.begin(setup=1.0)

    async def main() -> None:
        moving = asyncio.ensure_future(world.move())
        await asyncio.sleep(0.2)
        assert world.lives() == (["transit"], ["transit"])
        await world.order(world.here, "stop", name=str(WANDERER))
        with pytest.raises(Refused, match="it has been ended meanwhile"):
            await moving
        await asyncio.sleep(20.0)

    world.run(main())
    assert world.lives() == ([], [])


def test_an_agent_that_is_given_up_while_it_is_set_up_there_is_ended_there(world: World) -> None:
    async def main() -> None:
        origin = world.here.called.control_key
        migration = {"state": {"count": 5, "read": []}, "mailbox": [], "suspended": False}
        adopt = {
            "name": str(WANDERER),
            "kind": KIND,
            "properties": {"setup": 1.0},
            "from": origin,
            "luggage": migration,
        }
        arriving = asyncio.ensure_future(world.order(world.there, "adopt", **adopt))
        await asyncio.sleep(0.5)
        await world.order(world.there, "forsake", name=str(WANDERER), **{"from": "team/containers/another/control"})
        assert world.lives() == ([], ["transit"])
        await world.order(world.there, "forsake", name=str(WANDERER), **{"from": origin})
        with pytest.raises(Refused, match="was ended while it arrived in there"):
            await arriving

    world.run(main())
    assert world.lives() == ([], [])


def test_a_move_that_fails_at_the_last_moment_leaves_nothing_there(world: World) -> None:
    world.begin()

    async def fail(given: Any) -> dict[str, Any]:
        raise Refused("not now")

    world.there._control._orders["settle"] = fail
    with pytest.raises(Refused, match=r"^wanderer@team stays in here: not now$"):
        world.run(world.move())
    world.loop.run_for(0.1)
    assert world.lives() == (["active"], [])
    assert world.ask("next").value() == [1, "here"]


def test_what_no_agent_takes_along_is_refused(world: World) -> None:
    for order in (
        {"do": "adopt", "name": "x@team", "kind": KIND, "luggage": {}, "from": "a"},
        {"do": "adopt", "name": "x@team", "kind": KIND, "luggage": {"state": {}, "mailbox": [{}], "suspended": False}},
        {"do": "settle", "name": "x@team", "letters": []},
        {"do": "deliver", "name": "x@team", "letters": []},
        {"do": "begin", "name": "x@team", "message": {}},
    ):
        with pytest.raises(Refused):
            world.run(world.order(world.there, **order))
    assert world.there.agents == []


# Clones.


@pytest.mark.parametrize("to", ["here", "there"])
def test_a_clone_begins_with_the_state_of_the_original_and_both_go_on(world: World, to: str) -> None:
    world.begin(first=7)
    world.ask("next")
    world.tell("stays with the original")
    answer = world.run(world.order(world.here, "clone", name=str(WANDERER), **{"as": "twin@team", "to": to}))
    assert answer == {"name": "twin@team", "state": "active", "container": to}
    assert world.ask("next").value() == [9, "here"]
    assert world.ask("read").value() == ["stays with the original"]
    twin = AgentName("twin", "team")
    assert world.run(world.console.request(twin, "next")).value() == [9, to]
    assert world.run(world.console.request(twin, "read")).value() == []
    container = world.here if to == "here" else world.there
    assert container.agent(twin).properties == {"first": 7}


def test_an_agent_is_cloned_after_its_conversations_and_tells_its_subscribers(world: World) -> None:
    agent = world.begin()

    async def talk() -> tuple[Outcome, dict[str, Any]]:
        async with world.console.subscribe(WANDERER, "ticks") as values:
            await anext(values)
            asked = world.console.begin_request(WANDERER, "next", seconds=2.0)
            await asyncio.sleep(0.1)
            answer = await world.order(world.here, "clone", name=str(WANDERER), **{"as": "twin@team"})
            with pytest.raises(RequestNotDone, match="is cloned; subscribe again"):
                await asyncio.gather(*(anext(values) for _ in range(10)))
        return await asked, answer

    outcome, answer = world.run(talk())
    assert outcome.value() == [1, "here"]
    assert answer["container"] == "here"
    assert agent.state is AgentState.ACTIVE


@pytest.mark.parametrize(
    ("properties", "given", "says"),
    [
        ({}, {"as": str(WANDERER)}, "wanderer@team"),
        ({}, {"as": "twin"}, "twin"),
        ({}, {}, "this order to a container needs 'as', a text"),
        ({}, {"as": "twin@team", "to": "nowhere"}, "there is no container 'nowhere'"),
        ({"cannot pack": True}, {"as": "twin@team"}, "wanderer@team cannot pack: RuntimeError: too much"),
        ({"packs nonsense": True}, {"as": "twin@team"}, "wanderer@team"),
        ({"stays in": "here"}, {"as": "twin@team", "to": "there"}, "only there"),
    ],
)
def test_a_clone_that_fails_leaves_the_original_at_work(
    world: World, properties: dict[str, Any], given: dict[str, Any], says: str
) -> None:
    agent = world.begin(**properties)
    with pytest.raises(Refused, match=re.escape(says)):
        world.run(world.order(world.here, "clone", name=str(WANDERER), **given))
    assert (agent.state, world.lives()) == (AgentState.ACTIVE, (["active"], []))
    assert world.ask("next").is_done


def test_the_clone_of_a_suspended_agent_is_active_and_the_original_stays_suspended(world: World) -> None:
    agent = world.begin(first=3)
    world.here.suspend(WANDERER)
    answer = world.run(world.order(world.here, "clone", name=str(WANDERER), **{"as": "twin@team"}))
    assert (answer["state"], agent.state) == ("active", AgentState.SUSPENDED)

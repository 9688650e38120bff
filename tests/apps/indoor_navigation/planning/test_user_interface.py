"""What a person asks, and what becomes of missions when planning dies."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Agent, Ending, Outcome
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import query_key, send_key
from apps.indoor_navigation.components.user_interface import MESSAGE_TIMEOUT, UserInterface
from apps.indoor_navigation.data import GoalPoint, LogMessage
from bus import MemoryBus, Sample
from bus.messages import decode_json
from tests.apps.indoor_navigation.planning.house import House
from tests.apps.indoor_navigation.planning.on_a_map import Localization, floor_of
from tests.apps.indoor_navigation.site import ROBOT, Site

FACE = f"user_interface@{ROBOT}"
PROPERTIES = {
    "tells": {"GoalPoint": ["path_planning"]},
    "asks": {"state": "path_planning", "picture": "path_planning"},
}


class Planner:
    """What planning is to the interface. is_slow: it has not taken up a goal yet that it has received."""

    def __init__(self, site: Site) -> None:
        self._site = site
        self.is_slow = False
        self.goals: list[GoalPoint] = []
        self.told: dict[str, Any] = {"mission": "", "state": "idle"}
        self.come()

    def come(self) -> None:
        """It is there, and knows of nothing."""
        self.told = {"mission": "", "state": "idle"}
        self._bus = MemoryBus(self._site.network)
        self._bus.subscribe(send_key(ROBOT, "path_planning", GoalPoint), self._take)
        for what in ("state", "picture"):
            self._bus.serve(query_key(ROBOT, "path_planning", what), lambda arguments: dict(self.told))

    def go(self) -> None:
        """It has died."""
        self._bus.close()

    def _take(self, sample: Sample) -> None:
        goal = GoalPoint.from_json(decode_json(sample.payload))
        self.goals.append(goal)
        if not self.is_slow:
            self.told = {"mission": goal.mission, "state": "going" if goal.x is not None else "cancelled"}


class Person:
    """Somebody who asks."""

    def __init__(self, site: Site) -> None:
        self._site = site
        self.agent = Agent(f"person@{ROBOT}")
        site.start(self.agent)

    def ask(self, action: str, **arguments: Any) -> Outcome:
        return self._site.do(self.agent.request(FACE, action, **arguments))

    def begin(self, action: str, **arguments: Any) -> "asyncio.Task[Outcome]":
        return self._site.loop.create_task(self.agent.request(FACE, action, **arguments))


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    site.start(UserInterface(FACE, PROPERTIES))
    yield site
    site.close()
    loop.close()


@pytest.fixture
def planner(site: Site) -> Planner:
    return Planner(site)


@pytest.fixture
def person(site: Site) -> Person:
    return Person(site)


def tell(site: Site, what: str, mission: str = "m1") -> float:
    """Send a message of path planning; returns its stamp."""
    message = LogMessage(site.time, "path_planning", mission, "info", what)
    site.bus.send(send_key(ROBOT, "user_interface", LogMessage), message.to_json())
    site.run(0.1)
    return message.stamp


def test_a_mission_is_named_at_once_and_waited_for(site: Site, planner: Planner, person: Person) -> None:
    mission = person.ask("go", x=1.0, y=2, heading=0.5).result["mission"]
    assert planner.goals == [GoalPoint(mission, 1.0, 2, 0.5, 0.25)]
    waiting = person.begin("wait", mission=mission)
    site.run(3.0)
    assert not waiting.done()
    planner.told = {"mission": mission, "state": "done", "why": "there"}
    site.run(1.5)
    assert waiting.result().result["state"] == "done"
    assert person.ask("wait", mission=mission).result["why"] == "there"


def test_the_end_of_a_mission_is_answered_after_the_last_message_about_it(
    site: Site, planner: Planner, person: Person
) -> None:
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    waiting = person.begin("wait", mission=mission)
    planner.told = {"mission": mission, "state": "done", "why": "there", "messages": 2}
    tell(site, "going", mission)
    site.run(1.0)
    assert not waiting.done()
    last = tell(site, "done", mission)
    assert waiting.result().result["logged"] == last
    assert [message["what"] for message in person.ask("messages").result] == ["going", "done"]


def test_a_message_that_is_lost_holds_up_the_end_of_a_mission_no_longer_than_two_seconds(
    site: Site, planner: Planner, person: Person
) -> None:
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    planner.told = {"mission": mission, "state": "failed", "why": "a wall", "messages": 1}
    waiting = person.begin("wait", mission=mission)
    site.run(MESSAGE_TIMEOUT + 1.1)
    assert (waiting.result().result["state"], waiting.result().result["logged"]) == ("failed", None)


def test_state_and_picture_are_those_of_planning(site: Site, planner: Planner, person: Person) -> None:
    assert person.ask("state").result == {"mission": "", "state": "idle"}
    assert person.ask("picture").result == {"mission": "", "state": "idle"}
    planner.go()
    assert "path planning of happy does not answer" in person.ask("state").why


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"x": 1.0, "y": 1.0, "heading": True}, "heading must be a number, not True"),
        ({"x": 1.0, "y": 1.0, "heading": "north"}, "heading must be a number, not 'north'"),
        ({"x": 1.0, "y": 1.0, "tolerance": 0.0}, "tolerance must be at least 0.1 m, not 0"),
        ({"x": 1.0, "y": 1.0, "tolerance": 0.09}, "tolerance must be at least 0.1 m, not 0.09"),
        ({"x": "far", "y": 1.0}, "x must be a number, not 'far'"),
    ],
)
def test_what_is_no_goal_is_refused(planner: Planner, person: Person, arguments: dict[str, Any], why: str) -> None:
    assert why in person.ask("go", **arguments).why
    assert planner.goals == []


def test_a_second_mission_replaces_the_first(site: Site, planner: Planner, person: Person) -> None:
    first = person.ask("go", x=1.0, y=2.0).result["mission"]
    waiting = person.begin("wait", mission=first)
    site.run(0.1)
    second = person.ask("go", x=3.0, y=2.0).result["mission"]
    site.run(1.0)
    assert waiting.result().result["state"] == "replaced"
    assert second != first
    assert [goal.mission for goal in planner.goals] == [first, second]


def test_cancelled_planning_is_told_and_who_waits_too(site: Site, planner: Planner, person: Person) -> None:
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    assert person.ask("cancel").result == {"mission": mission}
    assert planner.goals[-1] == GoalPoint(mission, None, None)
    assert person.ask("wait", mission=mission).result["state"] == "cancelled"


def test_what_planning_has_forgotten_it_is_told_again(site: Site, planner: Planner, person: Person) -> None:
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    planner.go()
    site.run(3.0)
    planner.come()
    site.run(2.0)
    assert [goal.mission for goal in planner.goals] == [mission, mission]
    assert planner.told["state"] == "going"


def test_a_mission_of_somebody_else_is_not_fought(site: Site, planner: Planner, person: Person) -> None:
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    planner.told = {"mission": "theirs", "state": "going"}
    site.run(2.0)
    assert len(planner.goals) == 1
    assert person.ask("wait", mission=mission).result["state"] == "replaced"


def test_a_mission_that_planning_has_not_taken_up_yet_is_not_replaced_by_the_one_before(
    site: Site, planner: Planner, person: Person
) -> None:
    site.run(20.0)  # the interface sleeps, and looks as soon as it wakes up
    planner.told, planner.is_slow = {"mission": "before", "state": "done"}, True
    mission = person.ask("go", x=1.0, y=2.0).result["mission"]
    waiting = person.begin("wait", mission=mission)
    site.run(0.3)
    planner.told = {"mission": mission, "state": "going"}
    site.run(2.0)
    assert not waiting.done()
    planner.told = {"mission": mission, "state": "done"}
    site.run(4.0)
    assert waiting.result().result["state"] == "done"


def test_an_interface_begun_anew_waits_for_a_mission_from_before(site: Site, planner: Planner, person: Person) -> None:
    planner.told = {"mission": "before", "state": "going"}
    waiting = person.begin("wait", mission="before")
    site.run(2.0)
    planner.told = {"mission": "before", "state": "failed", "why": "a wall"}
    site.run(1.0)
    assert waiting.result().result["why"] == "a wall"
    assert "there is no mission 'other'; the last one is 'before'" in person.ask("wait", mission="other").why


def test_the_log_is_what_is_kept_and_what_comes(site: Site, planner: Planner, person: Person) -> None:
    heard: list[str] = []

    async def listen() -> None:
        async with person.agent.subscribe(FACE, "log") as messages:
            async for message in messages:
                heard.append(message["what"])

    tell(site, "first")
    listening = site.loop.create_task(listen())
    site.run(0.1)
    tell(site, "second")
    assert heard == ["first", "second"]
    listening.cancel()
    site.run(0.1)


def test_a_goal_of_the_map_is_that_of_the_localization(site: Site, planner: Planner, person: Person) -> None:
    assert "the localization gives no goal" in person.ask("go", place="Lab 2").why
    site.start(Localization(site, floor_of(House([]).box(0.0, 0.0, 9.0, 9.0))))
    named = person.ask("go", place="Lab 2").result["mission"]
    placed = person.ask("go", x=1.0, y=2.0, frame="map").result["mission"]
    assert planner.goals == [
        GoalPoint(named, 4.0, 5.0, 1.5, 0.25, "map"),
        GoalPoint(placed, 1.0, 2.0, None, 0.25, "map"),
    ]
    refusal = person.ask("go", place="Nowhere")
    assert refusal.ending is Ending.REFUSED
    assert 'the map has no goal "Nowhere"' in refusal.why
    assert "not both" in person.ask("go", place="Lab 2", x=1.0, y=2.0).why
    assert "frame must be 'odom' or 'map', not 'base_link'" in person.ask("go", x=1.0, y=2.0, frame="base_link").why

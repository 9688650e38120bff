"""Push, send and query between two components, in virtual time."""

from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Container
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component, Role, answers_query, hears, is_told, push_key
from apps.indoor_navigation.data import GoalPoint, RobotOdometry, WayRequest
from bus import MemoryBus, NoAnswer, Refused


class Base(Component):
    """Says where it is."""

    role = Role.HARDWARE
    gives = (RobotOdometry,)

    def __init__(self, name: str, properties: dict[str, Any]) -> None:
        super().__init__(name, properties)
        self.goals: list[GoalPoint] = []

    @is_told(GoalPoint)
    async def go(self, goal: GoalPoint) -> None:
        """Remember it."""
        self.goals.append(goal)

    @answers_query("goal")
    def goal(self, number: int = -1) -> dict[str, Any]:
        """The last."""
        if not self.goals:
            raise Refused("there is no goal")
        return self.goals[number].to_json()


class Steering(Component):
    """Hears where it is."""

    role = Role.REACTIVE
    tells = (GoalPoint,)
    may_tell = (WayRequest,)

    def __init__(self, name: str, properties: dict[str, Any]) -> None:
        super().__init__(name, properties)
        self.heard: list[RobotOdometry] = []

    @hears(RobotOdometry)
    async def look(self, odometry: RobotOdometry) -> None:
        """Remember it."""
        self.heard.append(odometry)


class Pair:
    """Both in one container."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.bus = MemoryBus()
        self.reports: list[str] = []
        self.loop = loop
        self.container = Container(self.bus, "happy", report=lambda report: self.reports.append(str(report.error)))
        self.base = Base("base_server@happy", {})
        wiring = {
            "hears": [["base_server", "Odometry"]],
            "tells": {"GoalPoint": ["base_server"]},
            "asks": {"goal": "base_server"},
        }
        self.steering = Steering("steering@happy", wiring)
        for agent in (self.base, self.steering):
            loop.run_until_complete(self.container.start(agent))


@pytest.fixture
def pair(loop: VirtualTimeLoop) -> Iterator[Pair]:
    pair = Pair(loop)
    yield pair
    loop.run_until_complete(pair.container.close())


def test_what_is_pushed_is_heard_by_who_is_wired(pair: Pair) -> None:
    odometry = RobotOdometry(1.0, 2.0, 3.0, 0.5, 0.1, 0.0)
    pair.base.push(odometry)
    pair.loop.run_for(0.01)
    assert pair.steering.heard == [odometry]


def test_of_what_is_pushed_faster_than_it_is_heard_the_newest_counts(pair: Pair) -> None:
    for number in range(10):
        pair.base.push(RobotOdometry(float(number), 0.0, 0.0, 0.0, 0.0, 0.0))
    pair.loop.run_for(0.01)
    assert pair.steering.heard[-1].stamp == 9.0
    assert len(pair.steering.heard) <= 2


def test_what_is_sent_arrives_complete_and_in_order(pair: Pair) -> None:
    goals = [GoalPoint(f"m{number}", 1.0, 2.0) for number in range(20)]
    for goal in goals:
        pair.steering.tell(goal)
    pair.loop.run_for(0.01)
    assert pair.base.goals == goals


def test_what_the_wiring_does_not_send_to_anybody_is_not_sent_if_it_may_be_left_out(pair: Pair) -> None:
    pair.steering.tell(WayRequest(1.0, "m1"))
    pair.loop.run_for(0.01)
    assert not pair.reports


def test_a_query_is_answered_or_refused_or_nobody_is_there(pair: Pair) -> None:
    ask = pair.steering.ask
    with pytest.raises(Refused, match="there is no goal"):
        pair.loop.run_until_complete(ask("goal"))
    pair.steering.tell(GoalPoint("m1", 1.0, 2.0))
    pair.loop.run_for(0.01)
    assert pair.loop.run_until_complete(ask("goal", number=0))["mission"] == "m1"
    with pytest.raises(Refused, match="base_server@happy cannot answer goal with these arguments"):
        pair.loop.run_until_complete(ask("goal", colour="red"))
    pair.loop.run_until_complete(pair.container.stop("base_server@happy"))
    with pytest.raises(NoAnswer):
        pair.loop.run_until_complete(ask("goal"))


def test_nonsense_is_reported_and_the_next_is_heard(pair: Pair) -> None:
    pair.bus.put(push_key("happy", "base_server", RobotOdometry), {"stamp": 1.0})
    pair.loop.run_for(0.01)
    assert len(pair.reports) == 1
    assert "this is not a valid Odometry" in pair.reports[0]
    pair.base.push(RobotOdometry(1.0, 2.0, 3.0, 0.5, 0.1, 0.0))
    pair.loop.run_for(0.01)
    assert len(pair.steering.heard) == 1


def test_the_directory_says_what_a_component_is(pair: Pair) -> None:
    about = pair.base.describe()
    assert about["role"] == "hardware"
    assert about["gives"] == ["Odometry"]
    assert "navigation" in about["services"]

"""The base moves the robot, and every request that does so ends as it should: done, failed with a reason, cancelled."""

import asyncio
from math import hypot, pi
from typing import Any

import pytest

from agents.components.base import BaseAgent
from agents.components.wheels import STANDING
from agents.platform import Agent, AgentName, Container, Ending, Performative
from agents.platform.conversations.fipa_request import Request
from bus import keys, messages
from bus.keys import Topic
from tests.agents.components.conftest import Lab

MOTIONS: list[tuple[str, dict[str, Any]]] = [
    ("move", {"distance": 2.0}),
    ("drive", {"linear": 0.3, "seconds": 9.0}),
    ("go_to", {"x": 2.0, "y": 0.0}),
]
NEWER: list[tuple[str, dict[str, Any]]] = [
    ("move", {"distance": -0.2}),
    ("drive", {"linear": -0.2, "seconds": 1.0}),
    ("go_to", {"x": 0.3, "y": 0.3}),
]
STOPS: list[tuple[tuple[str, dict[str, Any]], str]] = [
    (("estop", {"on": True}), "the e-stop"),
    (("stop", {}), "stopped by app@lab"),
    (("enable", {"on": False}), "motors"),
]


ENDS = [
    (("stop", {}), "stopped by app@lab"),
    (("enable", {"on": True}), "the motors were switched on by app@lab"),
]


def hold_back(lab: Lab, monkeypatch: pytest.MonkeyPatch, topic: Topic) -> asyncio.Event:
    """Have a command of the base's agent reach the gateway only after the returned event is set."""
    base, release = lab.container.agent(AgentName("base", "happy")), asyncio.Event()
    assert isinstance(base, BaseAgent)
    command = base.command

    async def late(given: Topic, /, **arguments: Any) -> dict[str, Any]:
        if given is topic:
            await release.wait()
        return await command(given, **arguments)

    monkeypatch.setattr(base, "command", late)
    return release


@pytest.fixture
def lab(lab: Lab) -> Lab:
    lab.run(1.0)  # the motors are on
    return lab


def speed(lab: Lab) -> float:
    """m/s that the robot really moves, on the average over a tenth of a second."""
    before = lab.lockstep.truth("happy")
    lab.run(0.1)
    after = lab.lockstep.truth("happy")
    return hypot(after.x - before.x, after.y - before.y) / 0.1


def stands_within(lab: Lab, seconds: float) -> bool:
    lab.run(seconds)
    return speed(lab) < 0.002


def take(lab: Lab, holder: str, priority: int = 0) -> str:
    """The token of a new lease on the base."""
    wanted = {"do": "take", "holder": holder, "priority": priority, "seconds": 60.0, "element": "base"}
    (answer,) = lab.bus.query("happy/lease", wanted)
    return str(answer.value["token"])


class TestDone:
    def test_a_metre_is_a_metre(self, lab: Lab) -> None:
        start = lab.lockstep.truth("happy")
        end = lab.value("base", "move", distance=1.0)
        assert (end["x"], end["y"]) == pytest.approx((1.0, 0.0), abs=0.04)
        assert end["linear"] == 0.0
        assert end["stamp"] == pytest.approx(lab.lockstep.time, abs=0.3)
        assert start.locate(lab.lockstep.truth("happy").x, lab.lockstep.truth("happy").y)[0] == pytest.approx(
            1.0, abs=0.05
        )

    @pytest.mark.parametrize("distance", [0.6, -0.6])
    def test_a_metre_at_a_speed_is_driven_at_that(self, lab: Lab, distance: float) -> None:
        moving = lab.begin("base", "move", distance=distance, speed=0.15)
        fastest = 0.0
        while not moving.done():
            fastest = max(fastest, speed(lab))
        end = moving.result().value()
        assert (end["x"], end["y"]) == pytest.approx((distance, 0.0), abs=0.04)
        assert fastest == pytest.approx(0.15, abs=0.03)

    def test_turns_add_up_and_headings_are_kept(self, lab: Lab) -> None:
        assert lab.value("base", "turn", angle=pi / 2)["heading"] == pytest.approx(pi / 2, abs=0.06)
        assert lab.value("base", "turn", angle=-pi)["heading"] == pytest.approx(-pi / 2, abs=0.08)
        assert lab.value("base", "heading", heading=0.5)["heading"] == pytest.approx(0.5, abs=0.06)

    def test_driving_lasts_as_long_as_asked(self, lab: Lab) -> None:
        began = lab.loop.time()
        end = lab.value("base", "drive", linear=0.3, seconds=2.0)
        assert 2.0 <= lab.loop.time() - began < 4.0
        assert end["x"] == pytest.approx(0.55, abs=0.12)
        assert abs(end["linear"]) <= STANDING.linear
        assert stands_within(lab, 0.0)

    @pytest.mark.parametrize("goal", [(1.0, 0.8, 0.0), (-0.5, 0.3, pi / 2), (0.0, 0.0, pi)])
    def test_a_pose_is_reached_in_odom(self, lab: Lab, goal: tuple[float, float, float]) -> None:
        x, y, heading = goal
        end = lab.value("base", "go_to", x=x, y=y, heading=heading)
        assert hypot(end["x"] - x, end["y"] - y) < 0.1
        assert abs((end["heading"] - heading + pi) % (2 * pi) - pi) < 0.08
        assert stands_within(lab, 0.0)

    def test_a_place_without_a_heading_is_reached_as_it_comes(self, lab: Lab) -> None:
        end = lab.value("base", "go_to", x=0.5, y=0.5, speed=0.3)
        assert hypot(end["x"] - 0.5, end["y"] - 0.5) < 0.08

    def test_reading_tells_where_the_robot_is(self, lab: Lab) -> None:
        assert lab.value("base", "read") == {
            "stamp": pytest.approx(lab.lockstep.time, abs=0.2),
            "x": 0.0,
            "y": 0.0,
            "heading": 0.0,
            "linear": 0.0,
            "angular": 0.0,
        }

    def test_results_come_with_every_sip(self, lab: Lab) -> None:
        heard = lab.results("base")
        lab.run(2.0)
        assert len(heard) == pytest.approx(20, abs=1)
        assert heard[-1]["x"] == 0.0


class TestFailure:
    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    def test_blocked_wheels_are_a_stall(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        moving = lab.begin("base", name, **arguments)
        lab.run(1.5)
        lab.lockstep.fault("wheel-stalled")
        lab.until(moving.done, 6.0)
        outcome = moving.result()
        assert outcome.ending is Ending.FAILED
        assert "stalled" in outcome.why
        assert "wheel is stalled" in outcome.why
        assert stands_within(lab, 1.0)

    def test_a_short_drive_against_something_is_no_drive(self, lab: Lab) -> None:
        lab.lockstep.fault("wheel-stalled")
        moving = lab.begin("base", "drive", linear=0.3, seconds=1.0)
        lab.until(moving.done, 3.0)
        outcome = moving.result()
        assert outcome.ending is Ending.FAILED
        assert "has not moved for" in outcome.why
        assert "wheel is stalled" in outcome.why

    @pytest.mark.parametrize("arguments", [{"linear": 0.2}, {"linear": 0.0, "angular": 0.5}, {"linear": 0.0}])
    def test_a_short_drive_where_the_way_is_free_is_done(self, lab: Lab, arguments: dict[str, float]) -> None:
        assert lab.value("base", "drive", seconds=1.0, **arguments)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    @pytest.mark.parametrize(
        ("stopping", "why"),
        [
            (("estop", {"on": True}), "the e-stop"),
            (("stop", {}), "stopped by app@lab"),
            (("enable", {"on": False}), "motors"),
        ],
    )
    def test_whoever_stops_the_robot_is_named(
        self, lab: Lab, name: str, arguments: dict[str, Any], stopping: tuple[str, dict[str, Any]], why: str
    ) -> None:
        moving = lab.begin("base", name, **arguments)
        lab.run(1.5)
        assert speed(lab) > 0.1
        lab.value("base", stopping[0], **stopping[1])
        lab.until(moving.done, 1.0)
        outcome = moving.result()
        assert (outcome.ending, outcome.agreed) == (Ending.FAILED, True)
        assert why in outcome.why
        assert stands_within(lab, 1.5)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    @pytest.mark.parametrize(("suffix", "arguments_of_it"), [("stop", {}), ("estop", {"on": True})])
    def test_a_stop_past_the_agent_ends_the_request_too(
        self, lab: Lab, name: str, arguments: dict[str, Any], suffix: str, arguments_of_it: dict[str, Any]
    ) -> None:
        moving = lab.begin("base", name, **arguments)
        lab.run(1.5)
        lab.bus.query(f"happy/command/{suffix}", arguments_of_it)
        lab.until(moving.done, 1.0)
        assert moving.result().ending is Ending.FAILED
        assert "stop" in moving.result().why
        if suffix == "estop":
            assert "the e-stop is latched" in moving.result().why
        assert stands_within(lab, 1.5)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    def test_a_cable_that_is_cut_is_a_lost_connection(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        moving = lab.begin("base", name, **arguments)
        lab.run(1.5)
        lab.lockstep.fault("line-cut@0+30")
        lab.until(moving.done, 6.0)
        outcome = moving.result()
        assert outcome.ending is Ending.FAILED
        assert any(reason in outcome.why for reason in ("lost", "not connected", "no odometry"))

    def test_the_red_button_is_told(self, lab: Lab) -> None:
        moving = lab.begin("base", "move", distance=2.0)
        lab.run(1.5)
        lab.lockstep.fault("stop-pressed")
        lab.until(moving.done, 3.0)
        assert "the STOP button is pressed" in moving.result().why

    def test_while_the_e_stop_is_latched_nothing_moves_until_it_is_released(self, lab: Lab) -> None:
        lab.value("base", "estop", on=True)
        for name, arguments in (
            ("move", {"distance": 1.0}),
            ("drive", {"linear": 0.2}),
            ("go_to", {"x": 1.0, "y": 0.0}),
        ):
            outcome = lab.ask("base", name, **arguments)
            assert (outcome.ending, outcome.agreed) == (Ending.REFUSED, False)
            assert "the e-stop is latched" in outcome.why
        lab.value("base", "estop", on=False)
        lab.value("base", "enable", on=True)
        lab.value("base", "move", distance=0.2)

    @pytest.mark.parametrize(
        ("name", "arguments"),
        [
            ("move", {"distance": 1000.0}),
            ("move", {"distance": 1.0, "speed": 0.0}),
            ("move", {"distance": 1.0, "speed": "fast"}),
            ("go_to", {"x": 1.0, "y": 0.0, "heading": "north"}),
        ],
    )
    def test_what_makes_no_sense_is_refused(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        assert lab.ask("base", name, **arguments).ending is Ending.REFUSED
        assert lab.reports == []


class TestOneAtATime:
    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    @pytest.mark.parametrize(("newer", "its_arguments"), NEWER)
    def test_a_newer_request_takes_the_place_of_the_one_before(
        self, lab: Lab, name: str, arguments: dict[str, Any], newer: str, its_arguments: dict[str, Any]
    ) -> None:
        older = lab.begin("base", name, **arguments)
        lab.run(1.0)
        lab.value("base", newer, **its_arguments)
        assert older.result().ending is Ending.FAILED
        assert older.result().why == f"replaced by {newer}, asked by app@lab"

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    @pytest.mark.parametrize(("newer", "its_arguments"), NEWER)
    def test_one_that_the_gateway_refuses_leaves_the_one_before_alone(
        self, lab: Lab, name: str, arguments: dict[str, Any], newer: str, its_arguments: dict[str, Any]
    ) -> None:
        older = lab.begin("base", name, **arguments, token=take(lab, "app"))
        lab.run(1.0)
        outcome = lab.ask("base", newer, **its_arguments)
        assert outcome.ending is Ending.REFUSED
        assert "lease" in outcome.why
        lab.run(0.5)
        assert speed(lab) > 0.1
        assert not older.done()

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    def test_who_loses_the_lease_stops_and_hears_it(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        older = lab.begin("base", name, **arguments, token=take(lab, "app"))
        lab.run(1.0)
        lab.bus.query(
            "happy/lease", {"do": "take", "holder": "boss", "priority": 9, "seconds": 60.0, "element": "base"}
        )
        lab.until(older.done, 2.0)
        assert older.result().ending is Ending.FAILED
        assert "boss" in older.result().why
        assert stands_within(lab, 1.5)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    def test_a_robot_whose_commander_dies_stops(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        mortal = Agent(AgentName("mortal", "lab"))
        home = Container(lab.lockstep.bus(), "deathbed")
        lab.do(home.start(mortal))
        asking = lab.loop.create_task(mortal.request("base@happy", name, reply_within=60.0, **arguments))
        lab.run(1.5)
        assert speed(lab) > 0.1
        home.bus.close()  # as a process that is killed
        assert stands_within(lab, 3.0)
        asking.cancel()
        lab.run(0.1)
        assert lab.value("base", "move", distance=0.1)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    @pytest.mark.parametrize("after", [0.0, 1.5])
    def test_a_request_that_is_cancelled_stops_the_robot(
        self, lab: Lab, name: str, arguments: dict[str, Any], after: float
    ) -> None:
        async def begin() -> Request:
            return lab.app.begin_request("base@happy", name, **arguments)

        moving = lab.do(begin())
        lab.run(after)
        assert lab.do(moving.cancel()).ending is Ending.CANCELLED
        assert stands_within(lab, 3.0)
        lab.value("base", "move", distance=0.1)

    @pytest.mark.parametrize(("name", "arguments"), MOTIONS)
    def test_an_agent_that_ends_leaves_no_robot_rolling(self, lab: Lab, name: str, arguments: dict[str, Any]) -> None:
        asking = lab.begin("base", name, **arguments)
        lab.run(1.0)
        lab.do(lab.container.stop("base@happy"))
        assert stands_within(lab, 1.2)
        assert asking.result().ending in (Ending.FAILED, Ending.DIED)

    @pytest.mark.parametrize(("stop", "arguments", "why"), [(*stop, why) for stop, why in ENDS])
    def test_a_stop_ends_a_motion_that_the_gateway_begins_after_it(
        self, lab: Lab, monkeypatch: pytest.MonkeyPatch, stop: str, arguments: dict[str, Any], why: str
    ) -> None:
        release = hold_back(lab, monkeypatch, keys.MOVE)
        moving = lab.begin("base", "move", distance=2.0)
        lab.run(0.1)
        lab.value("base", stop, **arguments)
        release.set()
        lab.until(moving.done, 2.0)
        assert moving.result().ending is Ending.REFUSED
        assert why in moving.result().why
        assert stands_within(lab, 1.5)
        assert lab.value("base", "move", distance=0.1)

    @pytest.mark.parametrize(("name", "arguments"), [*MOTIONS, ("turn", {"angle": pi})])
    def test_a_stop_ends_a_request_that_waits_for_the_one_before_to_begin(
        self, lab: Lab, monkeypatch: pytest.MonkeyPatch, name: str, arguments: dict[str, Any]
    ) -> None:
        release = hold_back(lab, monkeypatch, keys.HEADING)
        first = lab.begin("base", "heading", heading=1.0)
        lab.run(0.1)
        waiting = lab.begin("base", name, **arguments)
        lab.run(0.1)
        lab.value("base", "stop")
        release.set()
        lab.until(lambda: first.done() and waiting.done(), 2.0)
        assert waiting.result().ending is Ending.REFUSED
        assert waiting.result().why == "stopped by app@lab"
        assert stands_within(lab, 1.5)

    def test_a_stop_ends_a_request_that_waits_until_the_stop_before_no_longer_holds(self, lab: Lab) -> None:
        lab.value("base", "stop")
        driving = lab.begin("base", "drive", linear=0.2, seconds=1.0)
        lab.run(0.05)
        lab.value("base", "stop")
        lab.until(driving.done, 1.0)
        assert driving.result().ending is Ending.REFUSED
        assert driving.result().why == "stopped by app@lab"

    def test_velocities_of_somebody_else_end_a_motion(self, lab: Lab) -> None:
        moving = lab.begin("base", "move", distance=2.0)
        lab.run(1.0)
        lab.bus.put("happy/cmd_vel", messages.twist(0.1, 0.0))
        lab.until(moving.done, 1.0)
        assert moving.result().why.startswith("another command took its place after 0.")

    def test_a_stop_is_agreed_to_when_the_gateway_has_obeyed_and_done_when_the_robot_stands(self, lab: Lab) -> None:
        lab.begin("base", "move", distance=2.0)
        lab.run(2.0)
        stopping = lab.app.initiator.conversation(Performative.REQUEST, "base@happy", "stop", {}, 10.0, 10.0)
        stands = lab.loop.create_task(stopping.outcome())
        lab.until(lambda: stopping.agreed, 1.0)
        assert not stands.done()
        assert speed(lab) > 0.1
        lab.until(stands.done, 3.0)
        assert speed(lab) < 0.01

    def test_a_drive_right_after_a_stop_waits_until_the_stop_no_longer_holds(self, lab: Lab) -> None:
        lab.value("base", "stop")
        lab.value("base", "drive", linear=0.2, seconds=0.5)

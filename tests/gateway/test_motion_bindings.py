"""Motions that are bound to the heartbeat of their commander, under a virtual clock."""

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bus.heartbeat import LONGEST_PERIOD, SILENCE
from gateway.accelerations import travel_time
from gateway.settings import Settings
from tests.gateway.test_arm_on_bus import office as office_with_arm
from tests.gateway.test_elements_on_bus import MakeFitted, make_fitted
from tests.gateway.test_robot_on_bus import Office, make_office, office

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["make_fitted", "make_office", "office", "office_with_arm"]  # fixtures

KEY = "tour/heartbeat"


class Commander:
    """A program that beats as often as it must, and not more often."""

    def __init__(self, office: Office, key: str = KEY) -> None:
        self._office = office
        self._key = key
        self._next = office.bench.now
        self.is_alive = True

    def beat(self) -> None:
        if self.is_alive and self._office.bench.now >= self._next:
            self._next = self._office.bench.now + LONGEST_PERIOD
            self._office.bus.put(self._key, {})


def ends(office: Office, motion_id: str) -> list[str]:
    return [end["result"] for end in office.objects(f"command/result/{motion_id}")]


def test_a_long_motion_without_a_heartbeat_is_refused_with_the_reason_and_the_way(office: Office) -> None:
    why = office.refusal("command/move", distance=6.0)
    assert "it would not stop when its commander dies" in why
    assert '"heartbeat"' in why
    assert '"detach": true' in why
    assert not office.bench.driver.is_asked_to_move


def test_a_short_motion_needs_no_heartbeat(office: Office) -> None:
    assert ends(office, office.ask("command/move", distance=0.5)["id"]) == []
    office.run(6.0)
    assert office.last("odom").pose.pose.position.x == pytest.approx(0.5, abs=0.03)


def test_how_long_a_motion_without_a_heartbeat_may_take_is_a_setting(
    make_office: "Callable[[Settings], Office]",
) -> None:
    office = make_office(Settings(unbound_motion_s=0.0))
    assert "at most 0 s" in office.refusal("command/turn", angle=0.1)
    assert make_office(Settings(unbound_motion_s=60.0)).ask("command/move", distance=6.0)["accepted"]


def test_a_detached_motion_goes_on_and_its_answer_says_that_nobody_stops_it(office: Office) -> None:
    answer = office.ask("command/move", distance=3.0, detach=True)
    assert "it does not stop" in answer["warning"]
    office.run(20.0)
    assert ends(office, answer["id"]) == ["reached"]


def test_a_bound_motion_goes_on_to_its_end_while_its_commander_beats(office: Office) -> None:
    answer = office.ask("command/move", distance=3.0, heartbeat=KEY)
    assert "warning" not in answer
    office.run(20.0, Commander(office).beat)
    assert ends(office, answer["id"]) == ["reached"]


@pytest.mark.parametrize(
    ("command", "arguments"),
    [("move", {"distance": 6.0}), ("turn", {"angle": 20.0}), ("heading", {"heading": 3.0})],
)
def test_the_wheels_are_told_to_stop_when_the_commander_of_a_motion_falls_silent(
    office: Office, command: str, arguments: dict[str, float]
) -> None:
    commander = Commander(office)
    answer = office.ask(f"command/{command}", **arguments, heartbeat=KEY)
    office.run(1.3, commander.beat)
    assert office.bench.body.is_turning()
    commander.is_alive = False
    office.run(SILENCE + 0.1)
    assert ends(office, answer["id"]) == ["commander lost"]
    assert any(f"heartbeat {KEY}, was silent" in fault for fault in office.last("state").faults)
    office.run(3.0)
    assert not office.bench.body.is_turning()


def test_a_commander_that_never_beats_is_silent_from_the_beginning(office: Office) -> None:
    answer = office.ask("command/move", distance=6.0, heartbeat=KEY)
    office.run(SILENCE + 0.1)
    assert ends(office, answer["id"]) == ["commander lost"]


def test_a_commander_that_beats_again_does_not_wake_the_motion(office: Office) -> None:
    commander = Commander(office)
    answer = office.ask("command/move", distance=6.0, heartbeat=KEY)
    office.run(1.0, commander.beat)
    commander.is_alive = False
    office.run(2.5)
    commander.is_alive = True
    office.run(2.0, commander.beat)
    assert not office.bench.body.is_turning()
    assert ends(office, answer["id"]) == ["commander lost"]


def test_only_the_heartbeat_of_the_motion_under_way_counts(office: Office) -> None:
    first = office.ask("command/move", distance=6.0, heartbeat=KEY)
    office.run(0.3, Commander(office).beat)
    second = office.ask("command/move", distance=-1.0, heartbeat="other/heartbeat")
    office.run(12.0, Commander(office, "other/heartbeat").beat)
    assert (ends(office, first["id"]), ends(office, second["id"])) == (["replaced"], ["reached"])


def test_a_commander_that_leaves_after_the_end_of_its_motion_stops_nothing(office: Office) -> None:
    commander = Commander(office)
    office.ask("command/move", distance=0.2, heartbeat=KEY)
    office.run(5.0, commander.beat)
    commander.is_alive = False
    office.run(1.0, lambda: office.drive(0.3))
    assert office.bench.body.is_turning()
    assert not any("silent" in fault for fault in office.last("state").faults)


@pytest.mark.parametrize("key", ["tour", "*/heartbeat", "/heartbeat", "a//heartbeat", "", "@x/heartbeat"])
def test_what_is_no_key_of_a_heartbeat_is_refused(office: Office, key: str) -> None:
    assert "heartbeat" in office.refusal("command/move", distance=1.0, heartbeat=key)
    assert not office.bench.driver.is_asked_to_move


def test_a_command_that_sets_nothing_going_takes_no_heartbeat(office: Office) -> None:
    assert "does not take 'heartbeat'" in office.refusal("command/enable", on=True, heartbeat=KEY)


def test_a_lift_stops_when_its_commander_falls_silent(make_fitted: MakeFitted) -> None:
    office = make_fitted("gripper")
    office.run(1.0)
    commander = Commander(office)
    office.ask("command/gripper", do="up", heartbeat=KEY)
    office.run(0.7, commander.beat)
    assert office.last("gripper").lift_moving
    commander.is_alive = False
    office.run(SILENCE + 0.3)
    assert not office.last("gripper").lift_moving
    assert not office.last("gripper").lift_up


def test_a_camera_head_stops_when_its_commander_falls_silent(make_fitted: MakeFitted) -> None:
    office = make_fitted("ptz:evid30")
    office.run(6.0)
    commander = Commander(office)
    office.ask("command/ptz", pan=1.5, heartbeat=KEY)
    office.run(0.3, commander.beat)
    commander.is_alive = False
    office.run(SILENCE + 3.0)
    assert office.last("ptz").pan < 1.4
    assert not office.last("ptz").moving


def test_an_arm_stops_when_its_commander_falls_silent(office_with_arm: Office) -> None:
    office = office_with_arm
    office.ask("command/arm", do="power", on=True)
    office.run(4.0)
    commander = Commander(office)
    assert "heartbeat" in office.refusal("command/arm", do="move", joints={"1": 1.5}, speed=0.2)
    office.ask("command/arm", do="move", joints={"1": 1.5}, speed=0.2, heartbeat=KEY)
    office.run(1.5, commander.beat)
    assert office.last("arm").moving[0]
    commander.is_alive = False
    office.run(SILENCE + 0.5)
    assert not any(office.last("arm").moving)
    assert office.last("joint_states").position[0] < 1.0


@given(way=st.floats(-30.0, 30.0), speed=st.floats(0.01, 3.0), up=st.floats(0.05, 5.0), down=st.floats(0.05, 5.0))
def test_time_for_a_way_is_that_of_the_profile_stepped_through(
    way: float, speed: float, up: float, down: float
) -> None:
    expected = travel_time(way, speed, up, down)
    reached = 0.0
    steps = 2000
    dt = expected / steps
    for step in range(steps):
        at = (step + 0.5) * dt
        reached += min(speed, up * at, down * (expected - at)) * dt
    assert reached == pytest.approx(abs(way), rel=0.01, abs=1e-3)

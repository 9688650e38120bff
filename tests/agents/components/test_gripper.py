"""The gripper's agent, from request to world and back, in virtual time."""

from typing import TYPE_CHECKING

import pytest

from agents.platform import Ending
from p2os_emu.world.gripper import RobotGripper

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

WAY_TO_THE_BOX = 1.2  # m, a little more than it takes


@pytest.fixture
def lab(make_lab: "MakeLab") -> "Lab":
    lab = make_lab("gripper", world="gripper-lab")
    lab.until(lambda: "gripper" in lab.elements)
    return lab


def test_gripper_opens_closes_rises_and_sinks_and_answers_when_it_is_there(lab: "Lab") -> None:
    assert lab.value("gripper", "open")["paddles"] == "open"
    assert lab.value("gripper", "up")["lift"] == "up"
    began = lab.loop.time()
    closed = lab.value("gripper", "close")
    assert closed["paddles"] == "closed"
    assert not closed["holds"]
    assert lab.loop.time() - began > 1.5  # s; paddles need two
    assert lab.value("gripper", "down")["lift"] == "down"
    stored = lab.value("gripper", "store")
    assert (stored["paddles"], stored["lift"]) == ("closed", "up")
    deployed = lab.value("gripper", "deploy")
    assert (deployed["paddles"], deployed["lift"]) == ("open", "down")


def test_gripper_that_is_there_already_answers_soon(lab: "Lab") -> None:
    lab.value("gripper", "open")
    began = lab.loop.time()
    assert lab.value("gripper", "open")["paddles"] == "open"
    assert lab.loop.time() - began < 1.0


def test_gripper_takes_a_box_carries_it_and_puts_it_down(lab: "Lab") -> None:
    lab.value("gripper", "deploy")
    lab.bus.query("happy/command/move", {"distance": WAY_TO_THE_BOX})
    seen = lab.results("gripper")
    lab.until(lambda: seen and seen[-1]["inner_beam"])
    lab.bus.query("happy/command/stop")
    held = lab.value("gripper", "close")
    assert held["holds"]
    assert held["paddles"] == "closed"
    assert held["inner_beam"]
    assert lab.value("gripper", "up")["holds"]
    assert lab.value("gripper", "down")["holds"]
    assert not lab.value("gripper", "open")["holds"]


def test_request_that_is_cancelled_stops_the_gripper(lab: "Lab") -> None:
    asking = lab.begin("gripper", "up")
    lab.run(1.0)
    asking.cancel()
    lab.run(0.5)
    assert lab.value("gripper", "read")["lift"] == "between"


def test_estop_ends_a_motion_and_is_the_reason(lab: "Lab") -> None:
    asking = lab.begin("gripper", "up")
    lab.run(1.0)
    lab.ask("base", "estop", on=True)
    outcome = lab.do(asking)
    assert outcome.ending is Ending.FAILED
    assert outcome.why == "gripper up has stopped on its way: the e-stop is latched"
    refused = lab.ask("gripper", "up")
    assert refused.ending is Ending.REFUSED
    assert "e-stop" in refused.why


def test_newer_request_takes_the_place_of_an_older_one_for_the_same_part(lab: "Lab") -> None:
    up = lab.begin("gripper", "up")
    opening = lab.begin("gripper", "open")
    lab.run(1.0)
    assert lab.value("gripper", "down")["lift"] == "down"
    assert lab.do(up).why == "gripper down took the place of gripper up"
    assert lab.do(opening).is_done


def test_only_the_holder_of_the_lease_moves_the_gripper(lab: "Lab") -> None:
    (lease,) = lab.bus.query("happy/lease", {"do": "take", "holder": "somebody", "seconds": 60.0, "element": "gripper"})
    refused = lab.ask("gripper", "open")
    assert refused.ending is Ending.REFUSED
    assert "somebody holds the lease" in refused.why
    assert lab.value("gripper", "open", token=lease.value["token"])["paddles"] == "open"


def test_lease_that_somebody_takes_ends_a_motion_and_is_the_reason(lab: "Lab") -> None:
    asking = lab.begin("gripper", "up")
    lab.run(1.0)
    lab.bus.query("happy/lease", {"do": "take", "holder": "somebody", "seconds": 60.0, "element": "gripper"})
    outcome = lab.do(asking)
    assert outcome.ending is Ending.FAILED
    assert outcome.why == "gripper up has stopped on its way: the lease passed to somebody"


def test_gripper_that_is_stuck_fails_with_what_the_robot_says(lab: "Lab", monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RobotGripper, "drive", lambda self, paddles, lift: None)
    outcome = lab.ask("gripper", "up")
    assert outcome.ending is Ending.FAILED
    assert "the gripper reports an error" in outcome.why


def test_gripper_stops_where_it_is(lab: "Lab") -> None:
    asking = lab.begin("gripper", "up")
    lab.run(1.0)
    assert lab.value("gripper", "stop")["lift"] == "between"
    assert lab.do(asking).why == "gripper stop took the place of gripper up"


def test_motion_that_nobody_waits_for_goes_on(lab: "Lab") -> None:
    lab.value("gripper", "up", wait=False)
    lab.run(6.0)
    assert lab.value("gripper", "read")["lift"] == "up"

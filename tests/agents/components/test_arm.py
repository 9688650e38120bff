"""The agents of both arms, from request to world and back, in virtual time."""

from math import pi
from typing import TYPE_CHECKING, Any

import pytest

from agents.platform import Ending

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

ARMS = {"pioneer": ("p3dx-sh", 6), "powercube": ("powerbot", 7)}  # model and joints, the gripper's among them
HALF_A_DEGREE = 0.01  # rad


@pytest.fixture(params=ARMS)
def lab(request: pytest.FixtureRequest, make_lab: "MakeLab") -> "Lab":
    model, _ = ARMS[request.param]
    lab = make_lab("arm", model=model)
    lab.until(lambda: "arm" in lab.elements)
    return lab


@pytest.fixture
def powered(lab: "Lab") -> "Lab":
    assert lab.value("arm", "power", on=True)["powered"]
    assert lab.value("arm", "home")["homed"]
    return lab


def joints(result: Any) -> dict[str, float]:
    places = result["joints"]
    assert isinstance(places, dict)
    return places


def test_arm_goes_where_it_is_sent_and_answers_when_it_is_there(powered: "Lab") -> None:
    reached = powered.value("arm", "move", joints={"1": 0.5, "2": 0.4}, speed=0.4)
    assert not reached["moving"]
    assert (joints(reached)["1"], joints(reached)["2"]) == pytest.approx((0.5, 0.4), abs=HALF_A_DEGREE)
    last = str(len(joints(reached)))
    gripper = powered.value("arm", "move", joints={last: 0.02})
    assert joints(gripper)[last] == pytest.approx(0.02, abs=0.001)
    assert joints(powered.value("arm", "home"))["1"] == pytest.approx(0.0, abs=HALF_A_DEGREE)


def test_arm_parks_and_has_no_power_then(powered: "Lab") -> None:
    powered.value("arm", "move", joints={"1": 0.5})
    parked = powered.value("arm", "park")
    assert not parked["powered"]
    assert joints(parked)["1"] == pytest.approx(0.0, abs=HALF_A_DEGREE)
    refused = powered.ask("arm", "move", joints={"1": 0.5})
    assert refused.ending is Ending.REFUSED
    assert '{"do": "power", "on": true}' in refused.why
    assert powered.value("arm", "power", on=True)["powered"]
    assert powered.ask("arm", "move", joints={"1": 0.3}).is_done


def test_tip_is_brought_to_a_point(powered: "Lab") -> None:
    model = powered.value("arm", "move", joints={"2": 0.5, "4": 0.3})
    x, y, z = powered.value("arm", "reach", **dict(zip("xyz", TIP[len(joints(model))], strict=True)))["tip"]
    assert (x, y, z) == pytest.approx(TIP[len(joints(model))], abs=0.01)


TIP = {6: (0.45, 0.1, 0.4), 8: (0.5, 0.2, 0.7)}  # m, by the joints of the arm


def test_hand_is_turned_down_at_a_point(powered: "Lab") -> None:
    tip = {6: (0.45, 0.0, 0.2), 8: (0.53, 0.0, 0.4)}[len(joints(powered.value("arm", "read")))]
    reached = powered.value("arm", "reach", **dict(zip("xyz", tip, strict=True)), pitch=0.6, yaw=0.0)
    assert reached["tip"] == pytest.approx(tip, abs=0.01)
    places = joints(reached)
    bend = (
        sum(places[name] for name in ("2", "4", "6")) - pi / 2
        if len(places) == 8
        else -sum(places[name] for name in ("2", "3", "5"))
    )
    assert bend == pytest.approx(0.6, abs=0.03)


@pytest.mark.parametrize(
    ("point", "why"),
    [
        ((3.0, 0.0, 0.5), "out of the arm's reach; the nearest point that it reaches is "),
        ((0.3, 0.0, -0.2), "below the floor; the nearest one is 0.2 m above it"),
        ((0.0, 0.0, 0.1), "inside the robot's own body"),
    ],
)
def test_point_that_the_tip_cannot_get_to_is_refused_before_anything_moves(
    powered: "Lab", point: tuple[float, float, float], why: str
) -> None:
    before = joints(powered.value("arm", "read"))
    refused = powered.ask("arm", "reach", **dict(zip("xyz", point, strict=True)))
    assert refused.ending is Ending.REFUSED
    assert why in refused.why
    assert joints(powered.value("arm", "read")) == pytest.approx(before, abs=0.001)


def test_reaching_that_is_cancelled_stops_the_arm(powered: "Lab") -> None:
    asking = powered.begin(
        "arm", "reach", **dict(zip("xyz", TIP[len(joints(powered.value("arm", "read")))], strict=True)), speed=0.1
    )
    powered.run(2.0)
    asking.cancel()
    powered.run(1.0)
    stopped = powered.value("arm", "read")
    assert not stopped["moving"]
    powered.run(1.0)
    assert powered.value("arm", "read")["joints"] == joints(stopped)


@pytest.mark.parametrize(
    ("name", "given", "why"),
    [
        ("move", {"joints": {"1": 9.0}}, "joint 1 goes from"),
        ("move", {"joints": {"99": 0.1}}, "the arm has no joint '99'"),
        ("move", {"joints": {"one": 0.1}}, "the arm has no joint 'one'"),
        ("move", {"joints": {"1": "far"}}, "joint 1 needs a number"),
        ("move", {"joints": {}}, "arm move needs joints"),
        ("move", {"joints": [1]}, "joints of arm must be an object"),
        ("move", {"joints": {"1": 0.1}, "speed": 99.0}, "the joints turn at"),
        ("move", {"joints": {"1": 0.1}, "speed": "fast"}, "speed of arm must be a number"),
    ],
)
def test_gateways_limits_are_the_refusals(powered: "Lab", name: str, given: dict[str, Any], why: str) -> None:
    refused = powered.ask("arm", name, **given)
    assert refused.ending is Ending.REFUSED
    assert why in refused.why


def test_request_that_is_cancelled_stops_the_arm(powered: "Lab") -> None:
    asking = powered.begin("arm", "move", joints={"1": 1.2}, speed=0.2)
    powered.run(2.0)
    asking.cancel()
    powered.run(1.0)
    stopped = powered.value("arm", "read")
    assert not stopped["moving"]
    assert 0.1 < joints(stopped)["1"] < 1.0
    powered.run(1.0)
    assert powered.value("arm", "read")["joints"] == joints(stopped)


def test_estop_ends_a_motion_and_is_the_reason(powered: "Lab") -> None:
    asking = powered.begin("arm", "move", joints={"1": 1.2}, speed=0.2)
    powered.run(2.0)
    powered.bus.query("happy/command/estop", {"on": True})
    outcome = powered.do(asking)
    assert outcome.ending is Ending.FAILED
    assert "arm move has stopped on its way" in outcome.why
    assert "the e-stop is latched" in outcome.why


def test_motion_of_some_joints_lets_another_go_on(powered: "Lab") -> None:
    first = powered.begin("arm", "move", joints={"1": 0.6}, speed=0.3)
    powered.run(0.5)
    second = powered.begin("arm", "move", joints={"2": 0.5})
    powered.run(0.5)
    third = powered.value("arm", "move", joints={"2": 0.2})
    assert joints(third)["2"] == pytest.approx(0.2, abs=HALF_A_DEGREE)
    assert powered.do(second).why == "arm move took the place of arm move"
    assert joints(powered.do(first).value())["1"] == pytest.approx(0.6, abs=HALF_A_DEGREE)


def test_arm_tells_how_it_is(powered: "Lab") -> None:
    results = powered.results("arm")
    powered.run(1.0)
    assert len(results) > 3
    assert {"stamp", "joints", "powered", "homed", "moving"} == results[-1].keys()

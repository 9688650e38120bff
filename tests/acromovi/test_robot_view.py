"""What teleoperation shows, for terminals of any size."""

from typing import Any

import pytest

from acromovi.robot_view import RobotView, in_keys, joined
from bus.messages import RobotState, header
from tests.acromovi.test_teleop import battery, odometry


def state(connection: str = "connected", *, motors: bool = True, estop: bool = False, faults: Any = ()) -> RobotState:
    return RobotState(header(0, ""), connection, motors=motors, estop=estop, faults=list(faults))


def view(**known: Any) -> RobotView:
    return RobotView("happy", **{"state": state(), "odom": odometry(), "battery": battery(12.6), **known})


def test_the_state_comes_first_and_whole_in_80_columns() -> None:
    latched = state(motors=False, estop=True, faults=["the e-stop is latched"])
    shown = view(state=latched, note="e-stop latched; press c to release it, then e for the motors").screen(80, 24)
    assert shown == [
        "happy | E-STOP | connected | motors off | 12.6 V",
        "e-stop latched; press c to release it, then e for the motors",
        "+0.30 m/s | -0.10 rad/s | x 1.00 m | y -2.00 m | heading 0.50 rad",
        "arrows or w a s d drive · space stops · e motors on or off · x e-stop",
        "c clears it · q quits",
    ]


@pytest.mark.parametrize("width", range(1, 121))
def test_nothing_is_wider_than_the_terminal_and_nothing_is_lost(width: int) -> None:
    note = view(state=state("connecting", faults=["no answer at 9600 bit/s"])).obstacle()
    shown = view(state=state("connecting", estop=True, faults=["the gyro has failed"]), note=note).screen(width, 1000)
    assert max(map(len, shown)) <= width
    letters = "".join(shown).replace(" ", "").replace("|", "")
    for part in ("happyE-STOPconnectingmotorson12.6V", note, "the gyro has failed", "heading 0.50 rad", "q quits"):
        assert part.replace(" ", "") in letters


def test_what_does_not_fit_below_is_left_out_and_the_state_stays() -> None:
    assert view(state=state(estop=True)).screen(40, 2) == ["happy | E-STOP | connected | motors on", "12.6 V"]
    assert view().screen(80, 1) == ["happy | connected | motors on | 12.6 V"]
    assert len(view().screen(0, 0)) == 1


@pytest.mark.parametrize(
    ("known", "why"),
    [
        ({}, ""),
        ({"is_there": False}, "no effect: happy is gone; its gateway does not run"),
        ({"state": None}, "no effect yet: happy has not reported its state"),
        (
            {"state": state("connecting", faults=["the robot is not connected", "no answer at any rate"])},
            "no effect: the gateway is not connected to the robot (connecting); no answer at any rate",
        ),
        ({"state": state("disconnected")}, "no effect: the gateway is not connected to the robot (disconnected)"),
        (
            {"state": state(estop=True, motors=False, faults=["the e-stop is latched"])},
            "no effect: the e-stop is latched; press c to release it, then e to switch the motors on",
        ),
        (
            {"state": state(estop=True, motors=False, faults=["the STOP button is pressed"])},
            "no effect: the STOP button is pressed; release it at the robot, then press e",
        ),
        ({"state": state(motors=False)}, "no effect: the motors are off; press e to switch them on"),
        (
            {"lease": {"holder": "anna@lab", "priority": 0, "elements": {}}},
            "no effect: anna@lab holds the lease on the robot; only its holder drives the robot until it ends",
        ),
        (
            {"lease": {"holder": None, "elements": {"gripper": {"holder": "x"}, "base": {"holder": "anna@lab"}}}},
            "no effect: anna@lab holds the lease on the base; only its holder drives the robot until it ends",
        ),
        ({"lease": {"holder": None, "elements": {"gripper": {"holder": "x"}}}}, ""),
        ({"lease": {"holder": 3, "elements": "nonsense"}}, ""),
    ],
)
def test_what_keeps_a_robot_from_driving_is_told(known: dict[str, Any], why: str) -> None:
    assert view(**known).obstacle() == why


def test_faults_are_shown_once_and_in_keys() -> None:
    faults = ["the e-stop is latched", 'cmd_vel was refused: the motors are off; send enable {"on": true}']
    shown = view(state=state(faults=faults), odom=None, note="stopped").screen(200, 24)
    assert shown[1:3] == ["stopped", "cmd_vel was refused: the motors are off; press e"]


@pytest.mark.parametrize("known", [{}, {"odom": None, "state": {"motors": False}}])
def test_a_refusal_that_is_over_or_explained_is_not_shown(known: dict[str, Any]) -> None:
    faults = ["the gyro has failed", "cmd_vel was refused: the motors are off"]
    shown = view(**{**known, "state": state(**known.get("state", {}), faults=faults)}).screen(200, 24)
    assert "the gyro has failed" in shown
    assert not any("refused" in line for line in shown)


@pytest.mark.parametrize(
    ("why", "keys"),
    [
        ('the e-stop is latched; send estop {"on": false} first', "the e-stop is latched; press c first"),
        ('latched; send estop {"on": false} and then enable {"on": true}', "latched; press c and then e"),
        ("anna holds it", "anna holds it"),
    ],
)
def test_advice_names_keys(why: str, keys: str) -> None:
    assert in_keys(why) == keys


def test_parts_are_kept_together_where_they_fit() -> None:
    assert joined(["aa", "bb", "cc"], 7) == ["aa | bb", "cc"]
    assert joined(["aa bb cc"], 5) == ["aa bb", "cc"]
    assert joined([], 5) == []

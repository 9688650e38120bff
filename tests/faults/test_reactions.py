"""Every fault, and what the gateway does about it: what it publishes, what it refuses, when all is well again.

One table, one test for all rows: the robot is driven, the fault begins in mid-drive and the Twists go on; then it ends,
nobody commands for a while, and the robot is driven again.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from bus import keys
from p2os_emu.fault_spec import parse_fault
from p2os_emu.faults.board import FAULTS

if TYPE_CHECKING:
    from tests.faults.conftest import Mission

SPEED = 0.2  # m/s of the Twists
MEANWHILE = 4.0  # s that a fault lasts: longer than the firmware's watchdog
NOT_CONNECTED = "the robot is not connected"
MOTORS_OFF = "the motors are off"


class Reaction(NamedTuple):
    """What must be seen while a fault of the fourth second lasts, and after it.

    fit: accessories of the robot. connection, says: in `<robot>/state`; a part of one of its faults,
    None for no fault at all. refuses: part of the refusal of a move; None accepts it. goes_on: the robot keeps rolling.
    odometry: poses are published. needs_enable: after it the robot drives only once it is enabled again.
    """

    connection: str = "connected"
    says: str | None = None
    refuses: str | None = None
    goes_on: bool = True
    odometry: bool = True
    needs_enable: bool = False
    fit: str = ""


LOST = Reaction(connection="connecting", says=NOT_CONNECTED, refuses=NOT_CONNECTED, goes_on=False, odometry=False)
"""The gateway loses the robot within a second, and the watchdog stops it."""


REACTIONS = {
    # What no gateway can notice: the values are published as they come.
    "sonar-dead": Reaction(),
    "sonar-stuck": Reaction(),
    "sonar-noisy": Reaction(),
    "wheel-slipping": Reaction(),
    # What the robot says itself.
    "wheel-stalled:side=left": Reaction(says="the left wheel is stalled", goes_on=False),
    "wheel-stalled:side=both": Reaction(says="the right wheel is stalled", goes_on=False),
    "bumper-stuck:segment=front2": Reaction(says="wheel is stalled", goes_on=False),
    "bumper-stuck:segment=rear1": Reaction(),
    "stop-pressed": Reaction(says="the STOP button is pressed", refuses=MOTORS_OFF, goes_on=False, needs_enable=True),
    "low-battery:volts=21": Reaction(says="the battery is low, below 22.0 V"),
    "charger-plugged": Reaction(),
    "docked": Reaction(),
    "gyro-failed": Reaction(says="the gyro has failed", fit="gyro"),
    "laser-dirty": Reaction(says="the laser's window is dirty", fit="laser"),
    # Silence, and what is as good as silence.
    "brown-out@0+1000": LOST,
    "frozen-firmware": LOST._replace(goes_on=True),  # nobody on this side of the cable can stop it
    "line-cut": LOST,
    "line-frozen": LOST,
    "line-garbled": LOST,
    "line-half-duplex:toward=host": LOST,
    "line-half-duplex:toward=robot": Reaction(says="the robot stands although it is told to drive", goes_on=False),
    "line-noisy:rate=0.0001": Reaction(),
}
ELSEWHERE = {
    "hang-up": "test_hang_up.py",  # a port that vanishes takes a port of the operating system
}
"""Faults whose reaction has a module of its own."""


def test_no_fault_is_forgotten() -> None:
    assert {parse_fault(spec).name for spec in REACTIONS} | ELSEWHERE.keys() == FAULTS.keys()
    assert all(Path(__file__).with_name(module).exists() for module in ELSEWHERE.values())


@pytest.mark.parametrize("spec", REACTIONS)
def test_gateway_reacts_to_the_fault_and_is_back_after_it(make_mission: "Callable[[str], Mission]", spec: str) -> None:
    reaction = REACTIONS[spec]
    mission = make_mission(reaction.fit)
    assert mission.drive(2.0, SPEED) > 0.1
    end = mission.fault(spec)
    mission.drive(MEANWHILE - 1.0, SPEED)
    mission.forget()
    rolled = mission.drive(1.0, SPEED)
    seen = [state.connection for state in mission.all(keys.STATE)]
    assert set(seen) == {reaction.connection}
    said = {claim for state in mission.all(keys.STATE) for claim in state.faults if "refused" not in claim}
    assert any(reaction.says in claim for claim in said) if reaction.says else said == set()
    assert (mission.count(keys.ODOM) > 0) is reaction.odometry
    assert (rolled > 0.02) is reaction.goes_on
    why = mission.move()
    assert why is None if reaction.refuses is None else reaction.refuses in str(why)

    end()
    mission.run(1.0)  # a Twist has its half second, a robot its way of braking
    assert mission.run(3.0) < 0.02, "nobody asked it to move"
    assert mission.last(keys.STATE).connection == "connected"
    if reaction.needs_enable:
        assert mission.drive(1.0, SPEED) < 0.01
        mission.enable()
    assert mission.drive(2.0, SPEED) > 0.1
    mission.run(2.0)
    assert mission.last(keys.STATE).faults == []

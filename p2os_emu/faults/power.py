"""Faults of the controller, of what feeds it, and of accessories: buttons, battery, charger, power, gyro, laser."""

from collections.abc import Sequence

from p2os_emu.accessories.lms200 import Lms200
from p2os_emu.emulator import EmulatedRobot
from p2os_emu.faults.kind import Arguments, FaultKind, FaultParameter, Requirement, number

_LOW = 0.9  # of the nominal voltage: a lead-acid battery that should be charged
_GYRO = Requirement("gyro", lambda robot: robot.fit.has("gyro"))
_LASER = Requirement("laser", lambda robot: robot.fit.has("laser"))


def _volts(text: str, robot: EmulatedRobot) -> float:
    """What a battery of the robot's kind may show, V."""
    return number(2 * robot.model.battery_nominal, "volts")(text, robot)


def _press_stop(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.microcontroller.panel.stop_button = bool(active)


def _drain(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    low = _LOW * robot.model.battery_nominal
    shown = [low if each["volts"] is None else each["volts"] for each in active]
    robot.microcontroller.panel.battery = min(shown, default=None)


def _plug_charger(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.microcontroller.panel.charger_plugged = bool(active)


def _dock(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.microcontroller.panel.docked = bool(active)


def _cut_power(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    if active:
        robot.power_off()
    else:
        robot.power_on()


def _freeze(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.is_frozen = bool(active)


def _break_gyro(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.microcontroller.panel.gyro_failed = bool(active)


def _soil_laser(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    scanner = robot.cables["laser"].device
    assert isinstance(scanner, Lms200)
    scanner.dirt = max((each["dirt"] for each in active), default=0.0)


KINDS = (
    FaultKind(
        "stop-pressed",
        "someone presses the red STOP button",
        "the button is pulled out; the motors stay off until a client enables them",
        _press_stop,
    ),
    FaultKind(
        "low-battery",
        "the battery shows a low voltage",
        "the battery's own voltage shows again",
        _drain,
        {"volts": FaultParameter("what it shows, V; nine tenths of the nominal voltage if not given", _volts)},
    ),
    FaultKind(
        "charger-plugged",
        "the charger is plugged in",
        "the charger is pulled out",
        _plug_charger,
    ),
    FaultKind(
        "docked",
        "the robot stands at its dock: charging contacts that it lowers find power",
        "it stands elsewhere",
        _dock,
    ),
    FaultKind(
        "brown-out",
        "controller and accessories lose power; the wheels roll free",
        "power returns and everything is as after the power switch; at once unless a duration is given",
        _cut_power,
        is_momentary=True,
    ),
    FaultKind(
        "frozen-firmware",
        "the firmware hangs: it hears and says nothing, and the wheels keep their last speed",
        "the firmware goes on where it stood; what was sent to it meanwhile is lost",
        _freeze,
    ),
    FaultKind(
        "gyro-failed",
        "the gyro gives nothing any more",
        "it measures again",
        _break_gyro,
        needs=_GYRO,
    ),
    FaultKind(
        "laser-dirty",
        "dirt on the window of the laser scanner",
        "somebody wipes it",
        _soil_laser,
        {"dirt": FaultParameter("the part of the light that it takes, 0 to 1", number(1.0), "0.5")},
        _LASER,
    ),
)

"""The queryables under `<robot>/command/`: what each takes, and what it asks of the driver.

Every one carries a JSON object; a key that a command does not know, a missing one and a wrong type are refused with a
sentence. `token` is always allowed: the lease's.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

from bus import MessageError, keys
from bus.keys import Topic
from bus.validation import check_line, quoted
from configs.suggestion import not_taken
from gateway.driver import Driver
from gateway.elements.ports import UserPorts
from gateway.elements.sonar import SonarElement
from gateway.errors import CommandRefused
from geometry import wrap_angle

TOKEN = "token"
BASE = "base"
NOTHING = ""
HEARTBEAT = "heartbeat"
DETACH = "detach"
BINDING = {HEARTBEAT: str, DETACH: bool}
"""Arguments by which a motion is bound to its commander, or is not."""
LARGEST_EXACT = 2**53

Arguments = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class CommandRow:
    """One command.

    topic: its key. takes: argument to type (a type of JSON). may_take: those that may be left out. give: to the driver;
    what it returns goes into the answer. moves: the element whose lease it needs while somebody holds that,
    or `NOTHING`. duration: of a motion that goes on by itself, its expected duration, s; such a command may be bound to
    a heartbeat. None where nothing goes on.
    """

    topic: Topic
    takes: Mapping[str, type]
    give: Callable[[Driver, Arguments, float], dict[str, Any] | None]
    moves: str
    may_take: Mapping[str, type] = field(default_factory=dict)
    duration: Callable[[Driver, Arguments, float], float] | None = None

    @property
    def optional(self) -> dict[str, type]:
        """All arguments that may be left out, with their types."""
        return {TOKEN: str, **(BINDING if self.duration else {}), **self.may_take}


def _stop(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.stop(now)


def _estop(driver: Driver, arguments: Arguments, now: float) -> dict[str, Any]:
    driver.emergency_stop(arguments["on"], now)
    return {"estop": driver.is_estopped}


def _enable(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.enable(arguments["on"], now)


def _drive(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.set_velocity(arguments["linear"], arguments["angular"], now)


def _move(driver: Driver, arguments: Arguments, now: float) -> dict[str, Any]:
    return {"id": driver.move(arguments["distance"], now)}


def _turn(driver: Driver, arguments: Arguments, now: float) -> dict[str, Any]:
    return {"id": driver.turn(arguments["angle"], now)}


def _heading(driver: Driver, arguments: Arguments, now: float) -> dict[str, Any]:
    return {"id": driver.turn_to(arguments["heading"], now)}


def _sonar(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.element(SonarElement, now).switch(arguments["on"])


def _output(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.element(UserPorts, now).set_outputs(arguments["mask"], arguments["value"])


def _move_time(driver: Driver, arguments: Arguments, now: float) -> float:
    return driver.time_to_move(arguments["distance"])


def _turn_time(driver: Driver, arguments: Arguments, now: float) -> float:
    return driver.time_to_turn(arguments["angle"])


def _heading_time(driver: Driver, arguments: Arguments, now: float) -> float:
    return driver.time_to_turn(wrap_angle(arguments["heading"] - driver.odometry.pose.heading))


COMMANDS = (
    CommandRow(keys.ENABLE, {"on": bool}, _enable, BASE),
    CommandRow(keys.STOP, {}, _stop, NOTHING),  # anyone may stop a robot
    CommandRow(keys.ESTOP, {"on": bool}, _estop, NOTHING),
    CommandRow(keys.DRIVE, {"linear": float, "angular": float}, _drive, BASE),
    CommandRow(keys.MOVE, {"distance": float}, _move, BASE, duration=_move_time),
    CommandRow(keys.TURN, {"angle": float}, _turn, BASE, duration=_turn_time),
    CommandRow(keys.HEADING, {"heading": float}, _heading, BASE, duration=_heading_time),
    CommandRow(keys.SONAR_POWER, {"on": bool}, _sonar, NOTHING),
    CommandRow(keys.OUTPUT, {"mask": int, "value": int}, _output, NOTHING),
)

_KINDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    list: "a list",
    dict: "an object",
}


def check_arguments(name: str, given: Arguments, takes: Mapping[str, type], optional: Mapping[str, type]) -> Arguments:
    """Give back the arguments with whole numbers made floats where floats are meant.

    Raises:
        CommandRefused: One is unknown, missing, of the wrong type, not finite, or text that is not one printable line.
    """
    unknown = [key for key in given if key not in takes and key not in optional]
    if unknown:
        raise CommandRefused(not_taken(name, unknown, (*takes, *optional)))
    missing = [key for key in takes if key not in given]
    if missing:
        raise CommandRefused(f"{name} needs {missing[0]}: {_KINDS[takes[missing[0]]]}")
    return {key: _as(name, key, value, {**takes, **optional}[key]) for key, value in given.items()}


def _as(name: str, key: str, value: Any, kind: type) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value) if abs(value) < LARGEST_EXACT else inf
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise CommandRefused(f"{key} of {name} must be {_KINDS[kind]}, not {quoted(value)}")
    if isinstance(value, str):
        try:
            check_line(value, f"{key} of {name}")
        except MessageError as err:
            raise CommandRefused(str(err)) from err
    if isinstance(value, float) and not isfinite(value):
        raise CommandRefused(f"{key} of {name} must be finite, not {value}")
    return value

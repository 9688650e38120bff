"""Faults by name: what each one does to a robot, how it ends, and the board that lets them come and go.

Every fault takes `robot=NAME`; without it, it befalls every robot. All times are emulated time.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from p2os_emu.emulator import EmulatedRobot, PressedBumpers
from p2os_emu.fault_spec import FaultError, FaultSpec
from p2os_emu.hints import nearest

Arguments = Mapping[str, Any]
_ROUNDING = 1e-9  # s; times are sums of steps
_LOW = 0.9  # of the nominal voltage: a lead-acid battery that should be charged


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a fault: its meaning for people, and how its text becomes a value.

    read: Raises ValueError with what it should be.
    default: What is read when nothing is given; None leaves the choice to the fault.
    """

    meaning: str
    read: Callable[[str, EmulatedRobot], Any]
    default: str | None = None


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One fault.

    ending: how it ends, for people.
    begin, end: what happens to the robot; `begin` may be called again after another fault of the same kind has ended.
    is_momentary: without a duration it ends in the moment it begins, else it lasts until it is cleared.
    """

    name: str
    meaning: str
    ending: str
    begin: Callable[[EmulatedRobot, Arguments], None]
    end: Callable[[EmulatedRobot], None]
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    is_momentary: bool = False


@dataclass(slots=True)
class Fault:
    """A fault on its way, or at work. start, end: s of emulated time, end may be inf. arguments: by robot."""

    number: int
    spec: FaultSpec
    kind: FaultKind
    start: float
    end: float
    arguments: dict[str, Arguments]
    is_active: bool = False


class FaultBoard:
    """The faults of a run: those to come and those at work.

    Call `advance` before every step.
    """

    def __init__(self, robots: Mapping[str, EmulatedRobot]) -> None:
        self._robots = robots
        self._faults: dict[int, Fault] = {}
        self._last_number = 0

    @property
    def faults(self) -> list[Fault]:
        """Those to come and those at work, in the order they were asked for."""
        return list(self._faults.values())

    def schedule(self, spec: FaultSpec, now: float) -> Fault:
        """Let a fault happen.

        Args:
            spec: What somebody asked for; its start counts from now.
            now: Emulated time, s.
        Raises:
            FaultError: There is no such fault, parameter or robot, or a value does not fit.
        """
        kind = FAULTS.get(spec.name)
        if kind is None:
            raise FaultError(f"there is no fault {spec.name!r}; {nearest(spec.name, FAULTS)}")
        given = dict(spec.parameters)
        names = self._robots_meant(given.pop("robot", None))
        arguments = {name: _arguments(kind, given, self._robots[name]) for name in names}
        start = now + spec.start
        duration = spec.duration
        if duration is None:
            duration = 0.0 if kind.is_momentary else math.inf
        self._last_number += 1
        fault = Fault(self._last_number, spec, kind, start, start + duration, arguments)
        self._faults[fault.number] = fault
        return fault

    def advance(self, now: float) -> None:
        """Let begin and end what is due at emulated time `now`, s."""
        for fault in self.faults:
            if not fault.is_active and fault.start <= now + _ROUNDING:
                fault.is_active = True
                self._begin(fault)
            if fault.is_active and fault.end <= now + _ROUNDING:
                self.clear(fault.number)

    def clear(self, number: int) -> None:
        """End a fault, or call off one that has not begun.

        Raises:
            FaultError: There is no fault of this number.
        """
        fault = self._faults.pop(number, None)
        if fault is None:
            raise FaultError(f"there is no fault number {number}; ask for the faults to see those there are")
        if not fault.is_active:
            return
        for name in fault.arguments.keys() & self._robots.keys():
            fault.kind.end(self._robots[name])
        for other in self.faults:
            # What two faults hold together, one must not let go.
            if other.is_active and other.kind is fault.kind:
                self._begin(other)

    def _begin(self, fault: Fault) -> None:
        for name, arguments in fault.arguments.items():
            if name in self._robots:
                fault.kind.begin(self._robots[name], arguments)

    def _robots_meant(self, name: str | None) -> list[str]:
        if name is None:
            return list(self._robots)
        if name not in self._robots:
            raise FaultError(f"there is no robot {name!r}; {nearest(name, self._robots)}")
        return [name]


def _arguments(kind: FaultKind, given: Mapping[str, str], robot: EmulatedRobot) -> Arguments:
    for key in given:
        if key not in kind.parameters:
            raise FaultError(f"fault {kind.name} has no parameter {key!r}; {nearest(key, ['robot', *kind.parameters])}")
    values: dict[str, Any] = {}
    for key, parameter in kind.parameters.items():
        text = given.get(key, parameter.default)
        try:
            values[key] = None if text is None else parameter.read(text, robot)
        except ValueError as error:
            raise FaultError(f"fault {kind.name}: {key}={text} will not do; {error}") from error
    return values


def _read_volts(text: str, robot: EmulatedRobot) -> float:
    volts = float(text) if text.replace(".", "", 1).isdecimal() else math.nan
    if not 0 <= volts <= 2 * robot.model.battery_nominal:
        raise ValueError(f"give volts from 0 to {2 * robot.model.battery_nominal:g}")
    return volts


def _read_segment(text: str, robot: EmulatedRobot) -> tuple[int, int]:
    """The bits of a segment, front and rear."""
    model = robot.model
    fitted = {f"front{i + 1}": (1 << i, 0) for i in range(model.front_bumpers)}
    fitted |= {f"rear{i + 1}": (0, 1 << i) for i in range(model.rear_bumpers)}
    if text not in fitted:
        raise ValueError(f"{robot.name} has {', '.join(fitted) or 'no bumpers'}")
    return fitted[text]


def _press_stop(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.microcontroller.panel.stop_button = True


def _pull_stop(robot: EmulatedRobot) -> None:
    robot.microcontroller.panel.stop_button = False


def _drain(robot: EmulatedRobot, arguments: Arguments) -> None:
    volts = arguments["volts"]
    robot.microcontroller.panel.battery = _LOW * robot.model.battery_nominal if volts is None else volts


def _recover(robot: EmulatedRobot) -> None:
    robot.microcontroller.panel.battery = None


def _plug_charger(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.microcontroller.panel.charger_plugged = True


def _unplug_charger(robot: EmulatedRobot) -> None:
    robot.microcontroller.panel.charger_plugged = False


def _power_off(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.is_powered = False
    robot.body.release()


def _power_on(robot: EmulatedRobot) -> None:
    robot.is_powered = True
    robot.microcontroller.power_cycle()


def _freeze(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.is_frozen = True


def _thaw(robot: EmulatedRobot) -> None:
    robot.is_frozen = False


def _hold_bumper(robot: EmulatedRobot, arguments: Arguments) -> None:
    front, rear = arguments["segment"]
    if isinstance(robot.body, PressedBumpers):
        robot.body.front |= front
        robot.body.rear |= rear
    else:
        robot.body = PressedBumpers(robot.body, front, rear)


def _free_bumpers(robot: EmulatedRobot) -> None:
    if isinstance(robot.body, PressedBumpers):
        robot.body = robot.body.body


def _cut_line(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.line.is_cut = True


def _mend_line(robot: EmulatedRobot) -> None:
    robot.line.is_cut = False


def _hang_up(robot: EmulatedRobot, arguments: Arguments) -> None:
    robot.line.link.unplug()


def _come_back(robot: EmulatedRobot) -> None:
    robot.line.link.plug_in()


FAULTS: Mapping[str, FaultKind] = {
    kind.name: kind
    for kind in (
        FaultKind(
            "stop-pressed",
            "someone presses the red STOP button",
            "the button is pulled out; the motors stay off until a client enables them",
            _press_stop,
            _pull_stop,
        ),
        FaultKind(
            "low-battery",
            "the battery shows a low voltage",
            "the battery's own voltage shows again",
            _drain,
            _recover,
            {"volts": Parameter("what it shows, V; nine tenths of the nominal voltage if not given", _read_volts)},
        ),
        FaultKind(
            "charger-plugged",
            "the charger is plugged in",
            "the charger is pulled out",
            _plug_charger,
            _unplug_charger,
        ),
        FaultKind(
            "brown-out",
            "the controller loses power; the wheels roll free",
            "power returns and everything is as after the power switch; at once unless a duration is given",
            _power_off,
            _power_on,
            is_momentary=True,
        ),
        FaultKind(
            "frozen-firmware",
            "the firmware hangs: it hears and says nothing, and the wheels keep their last speed",
            "the firmware goes on where it stood; what was sent to it meanwhile is lost",
            _freeze,
            _thaw,
        ),
        FaultKind(
            "bumper-stuck",
            "a bumper segment stays pressed",
            "the segment springs back",
            _hold_bumper,
            _free_bumpers,
            {"segment": Parameter("such as rear2, counted from 1, from right to left", _read_segment, "front1")},
        ),
        FaultKind(
            "line-cut",
            "the cable delivers nothing, either way",
            "the cable carries bytes again; what was sent meanwhile is lost",
            _cut_line,
            _mend_line,
        ),
        FaultKind(
            "hang-up",
            "the port vanishes, as an adapter pulled out of its socket",
            "the port returns, at once unless a duration is given",
            _hang_up,
            _come_back,
            is_momentary=True,
        ),
    )
}

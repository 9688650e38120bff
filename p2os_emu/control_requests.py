"""Requests of the control socket: every `do`, its keys and its answer. SI and radians."""

import difflib
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from configs import ConfigError
from geometry import Pose2D
from p2os_emu.control import RequestError
from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.fault_spec import FaultError, parse_fault
from p2os_emu.faults.board import FAULTS, Fault, FaultBoard
from p2os_emu.faults.kind import FaultKind
from p2os_emu.hints import nearest
from p2os_emu.links.link import PortError
from p2os_emu.pacing import FASTEST, SLOWEST
from p2os_emu.runner import Runner
from p2os_emu.team import EmulatedTeam
from p2os_emu.truth_rows import robot_row

Fields = Mapping[str, Any]
_LONGEST_QUOTE = 80  # characters of a value in an error
_MOST_STEPS = 72_000  # ten minutes of emulated time


@dataclass(frozen=True, slots=True)
class _Request:
    meet: "Callable[[ControlRequestHandler, Fields], Mapping[str, Any]]"
    keys: Mapping[str, type]
    needed: tuple[str, ...] = ()


class ControlRequestHandler:
    """Carries out the requests of the control socket.

    Args:
        team: The robots and how more of them are made.
        faults: The faults of this run.
        runner: The loop.
    """

    def __init__(self, team: EmulatedTeam, faults: FaultBoard, runner: Runner) -> None:
        self.team = team
        self.faults = faults
        self.runner = runner

    @property
    def emulator(self) -> Emulator:
        """The emulator."""
        return self.team.emulator

    def answer(self, request: Fields) -> Mapping[str, Any]:
        """Carry out one request.

        Raises:
            RequestError: It cannot be met; the message says why.
        """
        do = request.get("do")
        if not isinstance(do, str) or do not in REQUESTS:
            hint = nearest(do if isinstance(do, str) else "", REQUESTS)
            raise RequestError(f'there is no "do": {_shown(do)}; {hint}')
        kind = REQUESTS[do]
        fields = {key: value for key, value in request.items() if key != "do"}
        for key, value in fields.items():
            fields[key] = _checked(do, kind, key, value)
        for key in kind.needed:
            if key not in fields:
                raise RequestError(f'{do} needs "{key}"')
        return kind.meet(self, fields)

    def robot(self, fields: Fields) -> EmulatedRobot:
        """Return the robot of a request: the one it names, or the only one."""
        robots = self.emulator.robots
        if "robot" in fields:
            return self._named(fields["robot"])
        if len(robots) != 1:
            raise RequestError(f'say which "robot": {", ".join(robots) or "there is none"}')
        return next(iter(robots.values()))

    def robots(self, fields: Fields) -> Iterable[EmulatedRobot]:
        """Return the robots of a request: the one it names, or all."""
        return [self._named(fields["robot"])] if "robot" in fields else list(self.emulator.robots.values())

    def _named(self, name: str) -> EmulatedRobot:
        if name not in self.emulator.robots:
            raise RequestError(f"there is no robot {name!r}; {nearest(name, self.emulator.robots)}")
        return self.emulator.robots[name]


def _checked(do: str, kind: _Request, key: str, value: Any) -> Any:
    """A value of the type that the key takes."""
    if key not in kind.keys:
        close = difflib.get_close_matches(key, kind.keys, 1, 0)
        hint = f'did you mean "{close[0]}"?' if close else "it takes none"
        raise RequestError(f'{do} has no key "{key}"; {hint}')
    wanted: type = kind.keys[key]
    if wanted is float and type(value) is int and abs(value) < 2**53:
        value = float(value)
    if type(value) is not wanted or (isinstance(value, float) and not math.isfinite(value)):
        raise RequestError(f'"{key}" must be {_TYPE_NAMES[wanted]}, not {_shown(value)}')
    return value


def _shown(value: Any) -> str:
    """A value as an error quotes it."""
    text = repr(value)
    return text if len(text) <= _LONGEST_QUOTE else text[: _LONGEST_QUOTE - 1] + "…"


def _truth(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    rows = {robot.name: robot_row(handler.emulator, robot) for robot in handler.robots(fields)}
    answer = {"robots": rows, **_surroundings(handler.emulator), "time": handler.emulator.time, **_pace(handler)}
    if len(rows) == 1:  # meant or alone: spares the asker a level
        answer |= {key: next(iter(rows.values()))[key] for key in ("x", "y", "heading")}
    return answer


def _pose(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    robot = handler.robot(fields)
    here = handler.emulator.world.truth(robot.name).pose
    there = Pose2D(fields.get("x", here.x), fields.get("y", here.y), fields.get("heading", here.heading))
    if fields.keys() - {"robot"}:
        try:
            handler.emulator.place(robot.name, there)
        except ValueError as error:
            raise RequestError(str(error)) from error
    pose = handler.emulator.world.truth(robot.name).pose
    return {"robot": robot.name, "x": pose.x, "y": pose.y, "heading": pose.heading}


def _door(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    try:
        handler.emulator.world.set_door(fields["name"], fields["open"])
    except ValueError as error:
        raise RequestError(str(error)) from error
    return {"door": fields["name"], "open": fields["open"]}


def _fault(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    try:
        fault = handler.faults.schedule(parse_fault(fields["fault"]), handler.emulator.time)
    except FaultError as error:
        raise RequestError(str(error)) from error
    return _fault_row(fault)


def _clear(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    numbers = [fields["number"]] if "number" in fields else [fault.number for fault in handler.faults.faults]
    try:
        for number in numbers:
            handler.faults.clear(number)
    except FaultError as error:
        raise RequestError(str(error)) from error
    return {"cleared": numbers}


def _faults(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    known = {name: _fault_explained(handler, kind) for name, kind in FAULTS.items()}
    return {"faults": [_fault_row(fault) for fault in handler.faults.faults], "known": known}


def _fault_explained(handler: ControlRequestHandler, kind: FaultKind) -> dict[str, Any]:
    return {
        "meaning": kind.meaning,
        "ending": kind.ending,
        "parameters": {key: parameter.meaning for key, parameter in kind.parameters.items()},
        "robots": [robot.name for robot in handler.emulator.robots.values() if kind.applies_to(robot)],
    }


def _fault_row(fault: Fault) -> dict[str, Any]:
    end = None if math.isinf(fault.end) else fault.end
    return {
        "number": fault.number,
        "fault": str(fault.spec),
        "active": fault.is_active,
        "start": fault.start,
        "end": end,
    }


def _step(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    count = fields.get("n", 1)
    if not handler.runner.is_paused:
        raise RequestError('the emulator runs by the clock; {"do": "pause"} first')
    if not 1 <= count <= _MOST_STEPS:
        raise RequestError(f'"n" must be from 1 to {_MOST_STEPS}, not {count}')
    handler.runner.step(count)
    return {"time": handler.emulator.time}


def _pause(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    handler.runner.pause(fields.get("on", True))
    return {"time": handler.emulator.time, **_pace(handler)}


def _speed(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    factor = fields.get("factor", handler.runner.speed)
    if factor <= 0:
        raise RequestError(f'"factor" must be above zero, not {factor}; {{"do": "pause"}} stops time')
    if not SLOWEST <= factor <= FASTEST:
        raise RequestError(f'"factor" must be from {SLOWEST:g} to {FASTEST:g}, not {factor:g}')
    if "factor" in fields:
        handler.runner.speed = factor
    return _pace(handler)


def _pace(handler: ControlRequestHandler) -> dict[str, Any]:
    return {
        "speed": handler.runner.speed,
        "paused": handler.runner.is_paused,
        "late_dropped": handler.runner.late_dropped,
        "lost": handler.runner.lost,
        "degraded": list(handler.runner.degradation.given_up),
    }


def _joystick(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    robot = handler.robot(fields)
    panel = robot.microcontroller.panel
    if panel.joystick is None:
        raise RequestError(f"{robot.name} has no joystick fitted; give it one with --fit joystick")
    for key, (low, high) in _REACH.items():
        if not low <= fields.get(key, 0.0) <= high:
            raise RequestError(f'"{key}" must be from {low:g} to {high:g}, not {fields[key]}')
    panel.joystick = panel.joystick._replace(**{key: value for key, value in fields.items() if key != "robot"})
    return {"robot": robot.name, **panel.joystick._asdict()}


def _reset(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    names = [robot.name for robot in handler.robots(fields)]
    try:
        handler.emulator.restart(names)
    except ValueError as error:
        raise RequestError(str(error)) from error
    return {"reset": names}


def _add(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    place = fields.keys() & {"x", "y", "heading"}
    if place and not place >= {"x", "y"}:
        raise RequestError('a place needs "x" and "y"; leave both out and the world finds one')
    pose = Pose2D(fields["x"], fields["y"], fields.get("heading", 0.0)) if place else None
    text = fields["model"] + (f":{fields['name']}" if "name" in fields else "")
    try:
        robot = handler.team.add(text, pose, parts=[part for part in fields.get("fit", "").split(",") if part])
    except (ConfigError, PortError) as error:
        raise RequestError(str(error)) from error
    return {"robot": handler.team.entry(robot)}


def _remove(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    robot = handler.robot(fields)
    handler.emulator.remove(robot.name)
    return {"removed": robot.name}


def _quit(handler: ControlRequestHandler, fields: Fields) -> Mapping[str, Any]:
    handler.runner.leave()
    return {"time": handler.emulator.time}


_TYPE_NAMES = {str: "text", float: "a finite number", int: "a whole number", bool: "true or false"}
_REACH = {"x": (-1.0, 1.0), "y": (-1.0, 1.0), "throttle": (0.0, 1.0)}
_PLACE: Mapping[str, type] = {"x": float, "y": float, "heading": float}

REQUESTS: Mapping[str, _Request] = {
    "truth": _Request(_truth, {"robot": str}),
    "pose": _Request(_pose, {"robot": str, **_PLACE}),
    "door": _Request(_door, {"name": str, "open": bool}, ("name", "open")),
    "fault": _Request(_fault, {"fault": str}, ("fault",)),
    "clear": _Request(_clear, {"number": int}),
    "faults": _Request(_faults, {}),
    "step": _Request(_step, {"n": int}),
    "pause": _Request(_pause, {"on": bool}),
    "speed": _Request(_speed, {"factor": float}),
    "joystick": _Request(
        _joystick, {"robot": str, "x": float, "y": float, "throttle": float, "button1": bool, "button2": bool}
    ),
    "reset": _Request(_reset, {"robot": str}),
    "add": _Request(_add, {"model": str, "name": str, "fit": str, **_PLACE}, ("model",)),
    "remove": _Request(_remove, {"robot": str}, ("robot",)),
    "quit": _Request(_quit, {}),
}


def _surroundings(emulator: Emulator) -> dict[str, Any]:
    """Return the places of objects, people and doors."""
    people = {
        name: {"x": x, "y": y, "heading": heading, "walks": walks}
        for name, (x, y, heading, walks) in emulator.world.people().items()
    }
    doors = {name: {"opening": opening, "width": width} for name, (opening, width) in emulator.world.doors().items()}
    return {"objects": emulator.world.object_places(), "people": people, "doors": doors}

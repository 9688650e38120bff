"""All faults, and the board that starts and ends them at their time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from p2os_emu.emulator import STEP, EmulatedRobot
from p2os_emu.fault_spec import FaultError, FaultSpec, parse_fault
from p2os_emu.faults import lines, machine, power
from p2os_emu.faults.kind import Arguments, FaultKind
from p2os_emu.hints import nearest

FAULTS: Mapping[str, FaultKind] = {kind.name: kind for kind in (*machine.KINDS, *power.KINDS, *lines.KINDS)}
"""All faults, by name."""

_ROUNDING = 1e-9  # s; times are sums of steps


@dataclass(slots=True)
class Fault:
    """A fault that is scheduled or active.

    start, end: s of emulated time, end may be inf. targets: the robots it is applied to, and its arguments there.
    """

    number: int
    spec: FaultSpec
    kind: FaultKind
    start: float
    end: float
    targets: Sequence[tuple[EmulatedRobot, Arguments]]
    is_active: bool = False


class FaultBoard:
    """The scheduled and active faults of a run.

    Call `advance` before every step.
    """

    def __init__(self, robots: Mapping[str, EmulatedRobot]) -> None:
        self._robots = robots
        self._faults: dict[int, Fault] = {}
        self._last_number = 0

    @property
    def faults(self) -> list[Fault]:
        """Scheduled and active faults in the order of their requests."""
        return list(self._faults.values())

    def schedule(self, spec: FaultSpec, now: float) -> Fault:
        """Schedule a fault.

        Args:
            spec: What somebody asked for; its start counts from now.
            now: Emulated time, s.
        Raises:
            FaultError: There is no such fault, parameter or robot, a robot has nothing that could fail so, or a value
                does not fit; the message lists what there is.
        """
        given = dict(spec.parameters)
        meant = self._robots_meant(given.pop("robot", None))
        kind = FAULTS.get(spec.name)
        if kind is None:
            raise FaultError(f"there is no fault {spec.name!r}; {_suggestion(spec.name, meant)}")
        able = [robot for robot in meant if kind.applies_to(robot)]
        if kind.needs and meant and not able:
            have = "has" if len(meant) == 1 else "have"
            raise FaultError(f"{_who(meant)} {have} no {kind.needs.name} to suffer {kind.name}; {_supported(meant)}")
        targets = [(robot, _arguments(kind, given, robot)) for robot in able]
        start = now + spec.start
        duration = spec.duration
        if duration is None:
            duration = 0.0 if kind.is_momentary else math.inf
        self._last_number += 1
        fault = Fault(self._last_number, spec, kind, start, start + duration, targets)
        self._faults[fault.number] = fault
        return fault

    def schedule_file(self, path: Path, now: float) -> None:
        """Schedule the faults of a file, one a line as on the command line; `#` begins a comment.

            # In the tenth second the cable fails for five seconds, and at last somebody presses stop.
            line-cut:robot=happy@10+5
            stop-pressed@30

        Args:
            path: The file.
            now: Emulated time from which starts count, s.
        Raises:
            FaultError: The file cannot be read, or a line is wrong; the message names file and line.
        """
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except OSError as error:
            raise FaultError(f"{path}: the file of faults cannot be read: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise FaultError(f"{path}: the file of faults cannot be read: it is no text") from error
        for number, line in enumerate(lines, 1):
            text = line.partition("#")[0].strip()
            if not text:
                continue
            try:
                self.schedule(parse_fault(text), now)
            except FaultError as error:
                raise FaultError(f"{path}, line {number}: {error}") from error

    def advance(self, now: float) -> None:
        """Begin and end the faults that are due at emulated time `now`, s."""
        if not self._faults:
            return
        for fault in self.faults:
            if not fault.is_active and fault.start <= now + _ROUNDING:
                fault.is_active = True
                self._tell(fault)
            if fault.is_active and fault.end <= now + _ROUNDING:
                self.clear(fault.number)
        for robot in self._robots.values():
            robot.body.advance(STEP)

    def clear(self, number: int) -> None:
        """End a fault, or cancel one that has not begun.

        Raises:
            FaultError: There is no fault of this number.
        """
        fault = self._faults.pop(number, None)
        if fault is None:
            raise FaultError(f"there is no fault number {number}; ask for the faults to see those there are")
        if fault.is_active:
            self._tell(fault)

    def _tell(self, changed: Fault) -> None:
        """Apply the active faults to the robots of a fault; a brown-out may have replaced parts."""
        for robot, _ in changed.targets:
            if self._robots.get(robot.name) is not robot:
                continue  # it was removed
            kinds = {fault.kind.name: fault.kind for fault in (changed, *self._faults.values())}
            for kind in kinds.values():
                active = self._at_work(kind, robot)
                if active or kind is changed.kind:
                    kind.apply(robot, active)

    def _at_work(self, kind: FaultKind, robot: EmulatedRobot) -> list[Arguments]:
        return [
            arguments
            for fault in self._faults.values()
            if fault.is_active and fault.kind is kind
            for target, arguments in fault.targets
            if target is robot
        ]

    def _robots_meant(self, name: str | None) -> list[EmulatedRobot]:
        if name is None:
            return list(self._robots.values())
        if name not in self._robots:
            raise FaultError(f"there is no robot {name!r}; {nearest(name, self._robots)}")
        return [self._robots[name]]


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


def _suggestion(name: str, robots: Sequence[EmulatedRobot]) -> str:
    hint = nearest(name, FAULTS)
    return f"{hint} {_supported(robots)}" if hint.endswith("?") else _supported(robots)


def _supported(robots: Sequence[EmulatedRobot]) -> str:
    """Return the faults that any of these robots can have."""
    names = [kind.name for kind in FAULTS.values() if any(map(kind.applies_to, robots))]
    return f"{_who(robots)} can suffer {', '.join(names)}" if robots else "there is no robot"


def _who(robots: Sequence[EmulatedRobot]) -> str:
    return robots[0].name if len(robots) == 1 else "the robots here"

"""A running emulated robot as a test sees it: its ports, where it truly is, and what can go wrong with it."""

import json
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from p2os_emu.program import ChildFailed, EmulatedRobots, emulator

PATIENCE_S = 20.0
"""Seconds that a wait lasts at most: only a failing test waits so long."""
STANDING = 1e-3
"""m/s and rad/s below which a robot stands."""
_GLANCE_S = 0.01
_LOOKS = 10  # so many in a row must find a robot at rest


@dataclass(frozen=True, slots=True)
class RobotTruth:
    """The true state of a robot, which no client can see.

    time: s since the emulator's start. x, y, heading: pose of the middle of the axle in the frame of the world, m, m,
    rad. linear, angular: m/s forward, rad/s counter-clockwise. connected: a client has opened the connection.
    motors_enabled: the motors have power. battery_charge: 0 to 1. frames_dropped: because the client does not read.
    """

    time: float
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    connected: bool
    motors_enabled: bool
    battery_charge: float
    frames_dropped: int


@dataclass(frozen=True, slots=True)
class RunningFault:
    """A fault that a test has requested. It may also end by its own duration."""

    number: int
    spec: str
    _emulator: EmulatedRobots

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return all(row["number"] != self.number for row in self._emulator.ask("faults")["faults"])

    def clear(self) -> None:
        """End the fault now, or cancel it if it has not begun. Does nothing if it is over."""
        try:
            self._emulator.ask("clear", number=self.number)
        except ChildFailed:
            if not self.is_over:
                raise


class RobotForTests:
    """One emulated robot.

    name, model: as asked for. port: what a client opens. laser_port, arm_port, camera_url: of accessories, None
    without one. emulator: the process it lives in, for anything else: `emulator.ask("pause")`.
    """

    def __init__(self, running: EmulatedRobots, entry: Mapping[str, Any]) -> None:
        self.emulator = running
        self.name: str = entry["name"]
        self.model: str = entry["model"]
        self.port: str = entry["port"]
        self.laser_port: str | None = entry["laser_port"]
        self.arm_port: str | None = entry["arm_port"]
        self.camera_url: str | None = entry["camera_url"]

    def truth(self) -> RobotTruth:
        """Return the true pose, velocity and state of the robot."""
        answer = self.emulator.ask("truth", robot=self.name)
        row = {"time": answer["time"], **answer["robots"][self.name]}
        return RobotTruth(**{field.name: row[field.name] for field in fields(RobotTruth)})

    def fault(self, spec: str) -> RunningFault:
        """Apply a fault: `robot.fault("sonar-dead:disc=3@1+5")`; `p2os-emu --list-faults` explains each.

        The fault is applied to this robot only. Without START it begins with the next step.

        Raises:
            ChildFailed: The emulator refuses, and says what this robot can suffer.
            TypeError: `spec` is not a text.
        """
        __tracebackhide__ = True
        if not isinstance(spec, str):
            raise TypeError(f"a fault is a text such as 'line-cut@1+5', not {spec!r}")
        name, colon, rest = spec.partition(":")
        if not colon:
            name, at, rest = spec.partition("@")
            mine = f"{name}:robot={self.name}{at}{rest}"
        else:
            mine = f"{name}:robot={self.name},{rest}"
        return RunningFault(self.emulator.ask("fault", fault=mine)["number"], mine, self.emulator)

    def clear(self) -> None:
        """End every fault of this emulator, and cancel those that have not begun."""
        self.emulator.ask("clear")

    def place(self, x: float, y: float, heading: float = 0.0) -> None:
        """Move the robot to a pose in the world, m, m, rad. Its odometry does not change."""
        self.emulator.ask("pose", robot=self.name, x=x, y=y, heading=heading)

    def wait_until(
        self, condition: Callable[[RobotTruth], object], seconds: float = PATIENCE_S, what: str = "the condition held"
    ) -> RobotTruth:
        """Wait until something is true of the robot; return the truth in which it was.

        Args:
            condition: Asked about a hundred times a second.
            seconds: To wait at most.
            what: Ends the sentence "waited 20 s in vain until ...".
        Raises:
            AssertionError: It did not become true.
        """
        __tracebackhide__ = True
        end = time.monotonic() + seconds
        while True:
            truth = self.truth()
            if condition(truth):
                return truth
            if time.monotonic() > end:
                raise AssertionError(f"waited {seconds:g} s in vain until {what}; the robot is as follows: {truth}")
            time.sleep(_GLANCE_S)

    def wait_until_connected(self, seconds: float = PATIENCE_S) -> RobotTruth:
        """Wait until a client has opened the connection."""
        __tracebackhide__ = True
        return self.wait_until(lambda truth: truth.connected, seconds, "a client connected")

    def wait_until_it_moves(self, seconds: float = PATIENCE_S) -> RobotTruth:
        """Wait until the robot moves, by itself or pushed."""
        __tracebackhide__ = True
        return self.wait_until(lambda truth: not _stands(truth), seconds, "the robot moved")

    def wait_until_it_stands(self, seconds: float = PATIENCE_S) -> RobotTruth:
        """Wait until the robot stands, and not only for a moment."""
        __tracebackhide__ = True
        standing = 0

        def stands(truth: RobotTruth) -> bool:
            nonlocal standing
            standing = standing + 1 if _stands(truth) else 0
            return standing >= _LOOKS

        return self.wait_until(stands, seconds, "the robot stood")


@contextmanager
def start(
    *models: str,
    fit: str | Iterable[str] = (),
    world: str | Path = "empty",
    link: str = "ideal",
    faults: Iterable[str] = (),
    flash: str | Path | Mapping[str, object] | None = None,
    seed: int = 0,
    perfect: bool = False,
    tcp: bool = False,
    options: Iterable[str] = (),
) -> Iterator[tuple[RobotForTests, ...]]:
    """Run emulated robots until the block ends.

    Args:
        models: MODEL or MODEL:NAME of each, as `--robot`.
        fit: Accessories, as `--fit`: one text or several.
        world: Name or file.
        link: Link profile of the serial lines, as `--link`.
        faults: Specs, as `--fault`; their START counts from the start of the emulator.
        flash: FLASH parameters that replace the factory's: a TOML file, or names and values.
        seed: Seed of the random generators.
        perfect: Without the imperfections of body and sensors.
        tcp: TCP ports in place of pseudo-terminals.
        options: Further options of `p2os-emu`.
    Raises:
        ChildFailed: The emulator could not start; the message is its own sentence.
        TypeError: A model, accessory, fault or option is not a text.
    """
    with ExitStack() as stack:
        arguments = ["--world", str(world), "--link", link, "--seed", str(seed), "--quiet"]
        for option, values in ("--robot", models), ("--fit", _listed(fit)), ("--fault", _listed(faults)):
            for value in _texts(option, values):
                arguments += [option, value]
        if flash is not None:
            file = flash if isinstance(flash, str | Path) else _written(flash, stack)
            arguments += ["--flash", str(file)]
        if perfect:
            arguments.append("--perfect")
        if tcp:
            arguments += ["--tcp", "0"]
        running = stack.enter_context(emulator(*arguments, *_texts("options", _listed(options))))
        yield tuple(RobotForTests(running, entry) for entry in running.robots)


def _stands(truth: RobotTruth) -> bool:
    return abs(truth.linear) < STANDING and abs(truth.angular) < STANDING


def _listed(given: str | Iterable[str]) -> Iterable[str]:
    return [given] if isinstance(given, str) else given


def _texts(option: str, values: Iterable[str]) -> Iterable[str]:
    """Check that all are texts: the arguments of a program are nothing else."""
    if not isinstance(values, Iterable) or not all(isinstance(value, str) for value in values):
        raise TypeError(f"{option.strip('-')}: texts are needed, not {values!r}")
    return values


def _written(flash: Mapping[str, object], stack: ExitStack) -> Path:
    """A TOML file of these parameters; numbers, texts and truth values look the same in JSON."""
    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="p2os-emu-"))
    file = Path(folder, "flash.toml")
    file.write_text("".join(f"{name} = {json.dumps(value)}\n" for name, value in flash.items()))
    return file

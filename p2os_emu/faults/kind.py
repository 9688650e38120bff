"""Kinds of faults: name, meaning, parameters and effect on a robot."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from p2os_emu.emulator import EmulatedRobot

Arguments = Mapping[str, Any]
_NUMBER = re.compile(r"\d+(\.\d*)?|\.\d+")


@dataclass(frozen=True, slots=True)
class FaultParameter:
    """One parameter of a fault: its meaning for people, and how its text becomes a value.

    read: Raises ValueError with what it should be.
    default: What is read when nothing is given; None leaves the choice to the fault.
    """

    meaning: str
    read: Callable[[str, EmulatedRobot], Any]
    default: str | None = None


@dataclass(frozen=True, slots=True)
class Requirement:
    """Part that a fault needs: its name, and a test whether a robot has it."""

    name: str
    has: Callable[[EmulatedRobot], object]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One kind of fault.

    ending: how it ends, for people.
    apply: applies the active faults of this kind to a robot. Called with the arguments of each whenever one begins
        or ends, and with none after the last has ended. It may be called twice with the same arguments.
    needs: part that the robot must have; None where every robot can have the fault.
    is_momentary: without a duration it ends when it begins; other faults last until they are cleared.
    """

    name: str
    meaning: str
    ending: str
    apply: Callable[[EmulatedRobot, Sequence[Arguments]], None]
    parameters: Mapping[str, FaultParameter] = field(default_factory=dict)
    needs: Requirement | None = None
    is_momentary: bool = False

    def applies_to(self, robot: EmulatedRobot) -> bool:
        """Return whether a robot has the part that can fail."""
        return self.needs is None or bool(self.needs.has(robot))


def number(most: float, unit: str = "") -> Callable[[str, EmulatedRobot], float]:
    """Return a reader of numbers from 0 to `most`, for `FaultParameter.read`."""

    def read(text: str, robot: EmulatedRobot) -> float:
        value = float(text) if _NUMBER.fullmatch(text) else math.nan
        if not 0.0 <= value <= most:
            raise ValueError(f"give {unit or 'a number'} from 0 to {most:g}")
        return value

    return read

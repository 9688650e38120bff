"""What a fault is: its name, what it means to people, what it takes and what it does to a robot."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from p2os_emu.emulator import EmulatedRobot

Arguments = Mapping[str, Any]


def _nothing_missing(robot: EmulatedRobot) -> str | None:
    return None


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
    befall: makes a robot suffer what the faults of this kind that are at work on it say together: it is given the
        arguments of each whenever one begins or ends, and none when the last has ended. It may be told the same twice.
    missing: what a robot would need to suffer it, "no bumpers" for example; None for a robot that can.
    is_momentary: without a duration it ends in the moment it begins, else it lasts until it is cleared.
    """

    name: str
    meaning: str
    ending: str
    befall: Callable[[EmulatedRobot, Sequence[Arguments]], None]
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    missing: Callable[[EmulatedRobot], str | None] = _nothing_missing
    is_momentary: bool = False

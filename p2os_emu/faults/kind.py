"""What a fault is: its name, what it means to people, what it takes and what it does to a robot."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from p2os_emu.emulator import EmulatedRobot

Arguments = Mapping[str, Any]


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
class Need:
    """What a robot must have to suffer a fault: its name for people, and whether a robot has it."""

    name: str
    has: Callable[[EmulatedRobot], object]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One fault.

    ending: how it ends, for people.
    befall: makes a robot suffer what the faults of this kind that are at work on it say together: it is given the
        arguments of each whenever one begins or ends, and none when the last has ended. It may be told the same twice.
    needs: what a robot must have to suffer it; None where every robot can.
    is_momentary: without a duration it ends in the moment it begins, else it lasts until it is cleared.
    """

    name: str
    meaning: str
    ending: str
    befall: Callable[[EmulatedRobot, Sequence[Arguments]], None]
    parameters: Mapping[str, FaultParameter] = field(default_factory=dict)
    needs: Need | None = None
    is_momentary: bool = False

    def can_befall(self, robot: EmulatedRobot) -> bool:
        """Whether a robot has what can fail so."""
        return self.needs is None or bool(self.needs.has(robot))

"""Robots on the bus, found by the tokens of their gateways."""

import difflib
from threading import Condition

from bus.bus import Bus
from bus.errors import BusError
from bus.keys import ALIVE, robot_name, split
from bus.meeting import wait_for_others

MEETING_TIME = 2.0  # s in which a robot that is there has been seen, once the bus has met all programs


class UnknownRobot(BusError, LookupError):
    """There is no robot of this name."""


class RobotPresence:
    """The robots on the bus, kept up to date."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._robots: set[str] = set()
        self._changed = Condition()
        bus.watch_alive(f"*/{ALIVE.suffix}", self._on_change)

    @property
    def robots(self) -> list[str]:
        """Their names, sorted."""
        with self._changed:
            return sorted(self._robots)

    def expect(self, robot: str, timeout: float = MEETING_TIME) -> None:
        """Wait until a robot is there.

        Raises:
            KeyNotValid: This cannot be a robot's name.
            UnknownRobot: It has not been seen within `timeout` s of meeting all on the bus; the message says which
                robots have.
        """
        robot_name(robot)
        with self._changed:
            if not wait_for_others(self._bus, self._changed, lambda: robot in self._robots, timeout):
                raise UnknownRobot(f"no robot {robot!r} is seen; {advice(robot, sorted(self._robots))}")

    def _on_change(self, key: str, is_alive: bool) -> None:
        robot, _ = split(key)
        with self._changed:
            (self._robots.add if is_alive else self._robots.discard)(robot)
            self._changed.notify_all()


def advice(robot: str, seen: list[str]) -> str:
    """Return advice for the name of a missing robot."""
    if not seen:
        return "there are no robots at all: start one with p2os-gateway PORT, and see whether both use the same --bus"
    near = difflib.get_close_matches(robot, seen, 1)
    return f"did you mean {near[0]!r}?" if near else f"the robots seen are {', '.join(seen)}"

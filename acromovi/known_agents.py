"""Agents on the bus, found by their liveliness tokens."""

import asyncio
import difflib
import time
from threading import Condition

from acromovi.presence import MEETING_TIME
from agents.platform.directory import Description, Directory
from agents.platform.errors import AgentError
from agents.platform.names import AgentName
from bus.bus import Bus, Closeable
from bus.meeting import wait_for_others

LIKENESS = 0.6  # 0 to 1, from which on one name may have been meant for another
QUIET_TIME = 0.3  # s without a new token after which a session has met everybody, on one machine


class NotOnBus(AgentError, LookupError):
    """No agent, container or navigation of this name is on the bus."""


class KnownAgents(Closeable):
    """The agents on the bus, for a short-lived program with a new session."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._changed = Condition()
        self._changed_at = time.monotonic()
        self._directory = Directory(bus, self._on_change)

    @property
    def names(self) -> list[AgentName]:
        """Their names, sorted."""
        return self._directory.names

    def expect(self, name: AgentName, timeout: float = MEETING_TIME) -> None:
        """Wait until an agent is there.

        Raises:
            NotOnBus: It has not been seen within `timeout` s of meeting all on the bus; the message gives the nearest
                name.
        """
        with self._changed:
            if not wait_for_others(self._bus, self._changed, lambda: self._directory.knows(name), timeout):
                raise NotOnBus(f"there is no agent {name}; {advice(name, self.names)}")

    def meet(self, timeout: float = MEETING_TIME) -> None:
        """Wait until no new agents appear; a new session knows all agents then."""

        def is_calm() -> bool:
            is_quiet = time.monotonic() >= self._changed_at + QUIET_TIME
            return self._bus.has_met_all and bool(self._directory.names) and is_quiet

        with self._changed:
            wait_for_others(self._bus, self._changed, is_calm, timeout)

    def describe(
        self, service: str | None = None, robot: str | None = None
    ) -> tuple[list[Description], list[AgentName]]:
        """Return the descriptions of the agents, and the names of those that do not answer, both sorted by name.

        Raises:
            KeyNotValid: `robot` cannot name a robot.
            BusError: The bus is closed.
        """
        self.meet()
        found = asyncio.run(self._directory.search(None, robot))
        answered = {description.name for description in found}
        silent = [name for name in self.names if name not in answered and robot in (None, name.platform)]
        return [description for description in found if description.fits(service, {})], silent

    def close(self) -> None:
        """Stop watching."""
        self._directory.close()

    def _on_change(self, name: AgentName, is_alive: bool) -> None:
        with self._changed:
            self._changed_at = time.monotonic()
            self._changed.notify_all()


def advice(name: AgentName, seen: list[AgentName]) -> str:
    """Return advice for the name of a missing agent."""
    if not seen:
        return "there are no agents at all: start a team with acromovi up, and see whether both use the same --bus"
    near = _nearest(name, seen)
    if near is not None:
        return f"did you mean {near}?"
    here = [str(each) for each in seen if each.platform == name.platform]
    if here:
        return f"those of {name.platform} are {', '.join(here)}"
    return "acromovi ps lists those that are there"


def _nearest(name: AgentName, seen: list[AgentName]) -> AgentName | None:
    """The one most like it."""
    close = [each for each in seen if _likeness(name, each) >= LIKENESS]
    return max(close, key=lambda each: _likeness(name, each), default=None)


def _likeness(one: AgentName, other: AgentName) -> float:
    """Return 0 to 1, by the part of the names that differs more: a common robot does not make names similar."""
    words = ((one.local, other.local), (one.platform, other.platform))
    return min(difflib.SequenceMatcher(None, *pair).ratio() for pair in words)

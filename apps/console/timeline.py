"""What has happened in the team: connections, e-stops, leases, refusals, missions, faults, restarts."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

KINDS = ("connection", "e-stop", "lease", "refusal", "mission", "fault", "restart", "console")
_RESTARTS = ("started again", "restart", "has failed", "was killed", "frozen")
_MOST = 2000  # events
_LONGEST = 500  # characters of what has happened


@dataclass(frozen=True, slots=True)
class TimelineEvent:
    """One event.

    number: counts the events, from 1. time: s since 1970. kind: one of `KINDS`. about: a robot, an agent or a page.
    what: for people, without its subject.
    """

    number: int
    time: float
    kind: str
    about: str
    what: str


class Timeline:
    """The newest events. number: of events so far."""

    def __init__(self, wall_time: Callable[[], float], most: int = _MOST) -> None:
        """Begin empty. wall_time: s since 1970. most: events that are kept."""
        self.number = 0
        self._wall_time = wall_time
        self._events: deque[TimelineEvent] = deque(maxlen=most)

    def tell(self, kind: str, about: str, what: str, at: float | None = None) -> None:
        """Note what has happened, now or at another time, s since 1970."""
        self.number += 1
        self._events.append(
            TimelineEvent(self.number, self._wall_time() if at is None else at, kind, about, what[:_LONGEST])
        )

    def hear_monitor(self, event: Mapping[str, Any]) -> None:
        """Note an event that a monitor reports. That of robots is left out, which the console sees itself."""
        match event:
            case {"time": int() | float() as at, "what": str(what), "about": str(about), "level": str(level)}:
                is_restart = any(words in what for words in _RESTARTS)
                if "@" in about or is_restart:
                    kind = "restart" if is_restart else "fault" if level != "ok" else "connection"
                    self.tell(kind, about, what, float(at))

    def hear_mission(self, robot: str, message: Mapping[str, Any], at: float | None = None) -> None:
        """Note a message of a robot's navigation, of now or another time, s since 1970."""
        match message:
            case {"mission": str(mission), "what": str(what)}:
                self.tell("mission", robot, f"{mission}: {what}" if mission else what, at)

    @property
    def events(self) -> list[TimelineEvent]:
        """All that are kept, in the order of their times."""
        return sorted(self._events, key=lambda event: (event.time, event.number))

    def newest(self, most: int, kinds: frozenset[str], about: str = "") -> list[TimelineEvent]:
        """Return the newest events of some kinds, the newest first.

        Args:
            most: How many.
            kinds: Which.
            about: Part of what they are about; empty for any.
        """
        found = [event for event in self._events if event.kind in kinds and about.lower() in event.about.lower()]
        return sorted(found, key=lambda event: (event.time, event.number), reverse=True)[:most]

"""The states and events that a monitor reports, and a bounded history of the events."""

from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

REMEMBERED = 1000  # events


class Level(StrEnum):
    """The severity, in rising order."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


SEVERITY = {level: number for number, level in enumerate(Level)}  # as diagnostic_msgs numbers them


@dataclass(frozen=True, slots=True)
class Standing:
    """The status of one subject.

    about: a robot, a container, an agent, a stream. what: one sentence. values: figures for display.
    """

    about: str
    level: Level = Level.OK
    what: str = "all is well"
    values: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON."""
        return {"level": str(self.level), "what": self.what, **self.values}


@dataclass(frozen=True, slots=True)
class _ServiceEvent:
    """An event.

    time: s since 1970. what: a sentence without its subject. about: the subject, an agent, a robot or a container.
    """

    time: float
    what: str
    about: str
    level: Level

    def to_dict(self) -> dict[str, Any]:
        """Return the event as JSON."""
        return asdict(self)


class History:
    """The newest events."""

    def __init__(self, publish: Callable[[dict[str, Any]], None], wall_time: Callable[[], float]) -> None:
        """Make an empty one.

        Args:
            publish: Called with each event.
            wall_time: s since 1970.
        """
        self._publish = publish
        self._wall_time = wall_time
        self._events: deque[_ServiceEvent] = deque(maxlen=REMEMBERED)

    def tell(self, about: object, what: str, level: Level = Level.OK) -> None:
        """Add an event that has just happened."""
        event = _ServiceEvent(self._wall_time(), what, str(about), level)
        self._events.append(event)
        self._publish(event.to_dict())

    def last(self, number: int) -> list[_ServiceEvent]:
        """Return the newest events, the oldest first."""
        return list(self._events)[-number:] if number > 0 else []

"""Targets of leases, and the messages of arbiters to holders.

An arbiter informs a holder in the ontology `acromovi-lease`, in the conversation of the lease's id, with the content
`{"lease", "element", "event", "within", "by"}`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Self

from agents.platform import AgentName, NameNotValid
from bus import KeyNotValid, Refused
from bus.keys import robot_name

ONTOLOGY = "acromovi-lease"
SERVICE = "arbitration"
ROBOT = "robot"
"""What the gateway calls the lease on a whole robot."""
NAMED = "name:"
"""How a lease on something begins that is no part of a robot: `name:doorway`."""
ID_BYTES = 8  # of the id of a lease, which cannot be guessed
LONGEST_NAME = 200  # characters of robot and element


class LeaseEvent(StrEnum):
    """An event that an arbiter reports to a holder."""

    PREEMPTED = "preempted"  # another holder has the lease in `within` s
    EXPIRED = "expired"  # it was not renewed in time
    LOST = "lost"  # the gateway does not know it any more


@dataclass(frozen=True, slots=True)
class LeaseNews:
    """News of a lease.

    within: s until the event. by: the new holder, or the arbiter's reason, for messages.
    """

    event: LeaseEvent
    within: float = 0.0
    by: str = ""

    @property
    def is_warning(self) -> bool:
        """Whether the lease is still held, and another is about to take it over."""
        return self.event is LeaseEvent.PREEMPTED and self.within > 0.0

    @classmethod
    def from_content(cls, content: Any) -> Self | None:
        """Read the content of an arbiter's message; None for other contents."""
        match content:
            case {"event": str(event), "within": int() | float() as within, "by": str(by)} if event in list(LeaseEvent):
                return cls(LeaseEvent(event), float(within), by)
        return None

    def __str__(self) -> str:
        return f"{self.event} by {self.by}" if self.by else str(self.event)


@dataclass(frozen=True, slots=True, order=True)
class LeaseTarget:
    """The target of a lease: an element of a robot, the whole robot, or a name that applications agree upon.

    robot: its name, or `NAMED` and the name. element: its name, or `ROBOT`.
    """

    robot: str
    element: str

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `base@happy`, `happy` for the whole robot, or `name:doorway` for a name.

        Raises:
            Refused: It is none of these.
        """
        if len(text) > LONGEST_NAME:
            raise Refused(f"a lease is on an element such as base@happy; {text[:20]}… is longer than any name")
        if text.startswith(NAMED):
            name = text.removeprefix(NAMED)
            if not name.strip() or name != name.strip() or not name.isprintable() or "@" in name:
                raise Refused(f"{text!r} names nothing to lease; write name:doorway, in printable characters without @")
            return cls(text, ROBOT)
        try:
            if "@" not in text:
                return cls(robot_name(text), ROBOT)
            agent = AgentName.parse(text)
        except (NameNotValid, KeyNotValid) as err:
            raise Refused(f"a lease is on an element such as base@happy, on a robot, or on a name: {err}") from err
        return cls(agent.platform, agent.local)

    @property
    def is_named(self) -> bool:
        """Whether it is a name, which only the arbiter knows."""
        return self.robot.startswith(NAMED)

    @property
    def is_whole(self) -> bool:
        """Whether it is a whole robot."""
        return self.element == ROBOT

    def conflicts_with(self, other: "LeaseTarget") -> bool:
        """Return whether both cannot be leased at the same time."""
        return self.robot == other.robot and (self.element == other.element or self.is_whole or other.is_whole)

    def lease_in(self, state: Mapping[str, Any]) -> Any:
        """Return the lease on exactly this target, by the gateway's `lease/state`; None when there is none."""
        return state if self.is_whole else _elements(state).get(self.element)

    def holders(self, state: Mapping[str, Any]) -> list[tuple[str, int]]:
        """Return the holders of this target or its parts, and their priorities, by the gateway's `lease/state`."""
        wanted = [state, *_elements(state).values()] if self.is_whole else [state, self.lease_in(state)]
        return [
            (row["holder"], row["priority"])
            for row in wanted
            if isinstance(row, Mapping) and isinstance(row.get("holder"), str) and isinstance(row.get("priority"), int)
        ]

    def __str__(self) -> str:
        return self.robot if self.is_whole else f"{self.element}@{self.robot}"


def _elements(state: Mapping[str, Any]) -> Mapping[str, Any]:
    elements = state.get("elements")
    return elements if isinstance(elements, Mapping) else {}

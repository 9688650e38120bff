"""The monitor's knowledge as a DiagnosticArray: one status for each robot, container, and failing stream or agent."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from agents.services.events import SEVERITY, Level
from bus.messages import DiagnosticArray, DiagnosticStatus, KeyValue, header


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


def worst(standings: Iterable[Standing]) -> Level:
    """Return the highest level."""
    return max((standing.level for standing in standings), key=SEVERITY.__getitem__, default=Level.OK)


def diagnostic_array(team: str, standings: Iterable[Standing], stamp_ns: int) -> DiagnosticArray:
    """Return the message; names are `<team>: <about>`."""
    return DiagnosticArray(
        header=header(stamp_ns, ""),
        status=[
            DiagnosticStatus(
                level=SEVERITY[standing.level],
                name=f"{team}: {standing.about}",
                message=standing.what,
                hardware_id="",
                values=[KeyValue(key=key, value=str(value)) for key, value in standing.values.items()],
            )
            for standing in standings
        ],
    )

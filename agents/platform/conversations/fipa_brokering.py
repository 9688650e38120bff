"""FIPA's brokering (SC00033H) and recruiting (SC00034H) protocols, the initiator's end.

The initiator sends `proxy` to a broker: which agents it needs, and what they shall do. A broker finds agents by their
descriptions. In brokering it asks them itself, and passes on what they have done; in recruiting it says which agents
they are, and the initiator asks them, so that their replies come without the broker. FIPA lets recruited agents begin
that conversation; here a conversation is one query of the initiator, who therefore begins it.

`agents.services.broker` has an agent that is a broker.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.errors import NameNotValid
from agents.platform.names import AgentName

PROTOCOL = "fipa-brokering"
RECRUITING = "fipa-recruiting"
BROKER, RECRUIT = "broker", "recruit"
"""What a broker is asked for."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Which agents are wanted, by their descriptions.

    service, robot: none for any. properties: with their values. everyone: all that fit, and not only the first.
    """

    service: str | None = None
    robot: str | None = None
    properties: Mapping[str, Any] | None = None
    everyone: bool = False

    def arguments(self) -> dict[str, Any]:
        """Return it as arguments of a proxy."""
        given = {"service": self.service, "robot": self.robot, "properties": self.properties, "everyone": self.everyone}
        return {name: value for name, value in given.items() if value}


def recruited(outcome: Outcome) -> list[AgentName]:
    """Return the agents that a broker has named; none unless the recruiting was done."""
    match outcome:
        case Outcome(ending=Ending.DONE, result={"agents": list(names)}):
            try:
                return [AgentName.parse(each) for each in names]
            except NameNotValid:
                return []
    return []

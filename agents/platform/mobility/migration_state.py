"""What an agent takes along when it moves, as an object and as JSON."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from agents.platform.acl import AclMessage
from agents.platform.errors import AgentError


@dataclass(frozen=True, slots=True)
class MigrationState:
    """What an agent takes along.

    state: what its `pack` returned.
    mailbox: the messages in its mailbox, the oldest first.
    is_suspended: whether it is suspended where it arrives, as it was before.
    """

    state: Mapping[str, Any]
    mailbox: tuple[AclMessage, ...]
    is_suspended: bool

    def to_dict(self) -> dict[str, Any]:
        """Return it as a JSON object."""
        mailbox = [message.to_dict() for message in self.mailbox]
        return {"state": self.state, "mailbox": mailbox, "suspended": self.is_suspended}

    @classmethod
    def from_dict(cls, value: Mapping[str, Any]) -> Self:
        """Read it from a JSON object.

        Raises:
            AgentError: The object is not valid.
        """
        match value:
            case {"state": dict(state), "mailbox": list(mailbox), "suspended": bool(is_suspended)}:
                return cls(state, tuple(AclMessage.from_dict(message) for message in mailbox), is_suspended)
        raise AgentError("the state of the agent that moves is not valid")

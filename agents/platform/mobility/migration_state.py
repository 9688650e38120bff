"""What an agent takes along when it moves, and the messages that follow it, as objects and as JSON."""

from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from agents.platform.acl import AclMessage
from agents.platform.container.delivery_gate import QueuedMessage
from agents.platform.errors import NotMoved


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
            NotMoved, AclError: The object is not valid.
        """
        match value:
            case {"state": dict(state), "mailbox": list(mailbox), "suspended": bool(is_suspended)}:
                return cls(state, tuple(AclMessage.from_dict(message) for message in mailbox), is_suspended)
        raise NotMoved("the state of the agent that moves is not valid")


def encode_queued(waiting: Sequence[QueuedMessage]) -> list[list[str]]:
    """Return queued messages as JSON."""
    return [[queued.label, b64encode(queued.payload).decode()] for queued in waiting]


def decode_queued(value: Any) -> list[QueuedMessage]:
    """Read queued messages from JSON.

    Raises:
        NotMoved: They are not valid.
    """
    try:
        return [QueuedMessage(str(label), b64decode(payload)) for label, payload in value]
    except (TypeError, ValueError) as err:
        raise NotMoved("the messages for the agent that moves are not valid") from err

"""What an agent takes along when it moves, and what follows it, as objects and as JSON."""

from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from agents.platform.acl import AclMessage
from agents.platform.container.delivery_gate import QueuedMessage
from agents.platform.errors import NotMoved


@dataclass(frozen=True, slots=True)
class MigrationState:
    """What an agent takes along.

    state: what its `pack` says.
    mailbox: the messages that wait in its mailbox, oldest first.
    is_suspended: whether it is to rest where it arrives, as it did before.
    """

    state: Mapping[str, Any]
    mailbox: tuple[AclMessage, ...]
    is_suspended: bool


def packed(migration: MigrationState) -> dict[str, Any]:
    """A migration state as a JSON object."""
    mailbox = [message.to_dict() for message in migration.mailbox]
    return {"state": migration.state, "mailbox": mailbox, "suspended": migration.is_suspended}


def unpacked(value: Mapping[str, Any]) -> MigrationState:
    """A migration state from a JSON object.

    Raises:
        NotMoved, AclError: It is none.
    """
    match value:
        case {"state": dict(state), "mailbox": list(mailbox), "suspended": bool(is_suspended)}:
            return MigrationState(state, tuple(AclMessage.from_dict(message) for message in mailbox), is_suspended)
    raise NotMoved("this is not what an agent takes along")


def enveloped(waiting: Sequence[QueuedMessage]) -> list[list[str]]:
    """Queued messages as JSON."""
    return [[queued.label, b64encode(queued.payload).decode()] for queued in waiting]


def opened(value: Any) -> list[QueuedMessage]:
    """Queued messages from JSON.

    Raises:
        NotMoved: They are none.
    """
    try:
        return [QueuedMessage(str(label), b64decode(payload)) for label, payload in value]
    except (TypeError, ValueError) as err:
        raise NotMoved("these are not messages for an agent that moves") from err

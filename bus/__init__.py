"""The bus: Zenoh between processes and an in-memory twin inside one, with ROS 2 messages on it."""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING, Any

from bus import keys
from bus.bus import CDR, JSON, Answer, Bus, Conversation, Publisher, Sample, Subscription
from bus.errors import (
    BusError,
    BusUnavailable,
    KeyNotValid,
    MessageError,
    NameTaken,
    NoAnswer,
    NotAllowed,
    Refused,
    TimedOut,
)
from bus.memory import MemoryBus
from bus.memory_network import MemoryNetwork
from bus.session import ZenohBus

if TYPE_CHECKING:
    from bus import messages

__all__ = [
    "CDR",
    "JSON",
    "Answer",
    "Bus",
    "BusError",
    "BusUnavailable",
    "Conversation",
    "KeyNotValid",
    "MemoryBus",
    "MemoryNetwork",
    "MessageError",
    "NameTaken",
    "NoAnswer",
    "NotAllowed",
    "Publisher",
    "Refused",
    "Sample",
    "Subscription",
    "TimedOut",
    "ZenohBus",
    "keys",
    "messages",
]


def __getattr__(name: str) -> Any:
    """Load the message types when they are first used: numpy and the serialisers are half of what the bus takes."""
    if name == "messages":
        return _import_module("bus.messages")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

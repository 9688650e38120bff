"""The bus: Zenoh between processes and an in-memory twin inside one, with ROS 2 messages on it."""

from bus import keys, messages
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

"""The bus: Zenoh between processes and an in-memory twin inside one, with ROS 2 messages on it."""

from bus import keys, messages
from bus.bus import CDR, JSON, Answer, Bus, Publisher, Sample, Subscription
from bus.errors import BusError, BusUnavailable, KeyNotValid, MessageError, NoAnswer, Refused
from bus.memory import MemoryBus, MemoryNetwork
from bus.session import ZenohBus

__all__ = [
    "CDR",
    "JSON",
    "Answer",
    "Bus",
    "BusError",
    "BusUnavailable",
    "KeyNotValid",
    "MemoryBus",
    "MemoryNetwork",
    "MessageError",
    "NoAnswer",
    "Publisher",
    "Refused",
    "Sample",
    "Subscription",
    "ZenohBus",
    "keys",
    "messages",
]

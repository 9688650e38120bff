"""The bus: Zenoh between processes and an in-memory twin inside one, with ROS 2 messages on it.

The abstract bus is here; `bus.session` and `bus.memory` are its two kinds, `bus.messages` and `bus.keys` what goes over
it. Those are imported where they are needed, so that a program that only asks for help does not load Zenoh.
"""

from bus.bus import Answer, Bus, Publisher, Sample, Subscription
from bus.errors import BusError, BusUnavailable, KeyNotValid, MessageError, NoAnswer, Refused

__all__ = [
    "Answer",
    "Bus",
    "BusError",
    "BusUnavailable",
    "KeyNotValid",
    "MessageError",
    "NoAnswer",
    "Publisher",
    "Refused",
    "Sample",
    "Subscription",
]

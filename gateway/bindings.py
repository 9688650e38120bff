"""Motions that are bound to the heartbeat of their commander, and end when it is silent.

A motion that runs for seconds would outlive a commander that dies. So the command names a heartbeat
(`bus/heartbeat.py`), and the gateway stops what it moves 0.5 s after the last beat: the process may be dead or frozen,
or the network down.

A binding stays after its motion has ended, until the heartbeat ends or the next command comes; it has no effect then.

No clock. `bind`, `release`, `beat` and `expire` are called under the robot's lock, `follow` outside it, since it
declares and withdraws subscriptions.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from bus import Bus, Sample, Subscription
from bus.heartbeat import SILENCE

BEAT_PERIOD = 0.02
"""Seconds: of a heartbeat that beats faster, only the latest beats are looked at."""


@dataclass(frozen=True, slots=True)
class Binding:
    """A motion and the heartbeat that it is bound to.

    element: what moves. key: of the heartbeat. motion_id: of a motion of the wheels; None for other elements. began_at:
    steady time, s.
    """

    element: str
    key: str
    motion_id: str | None
    began_at: float


class MotionBindings(Subscription):
    """All bindings of one robot, one for each element that moves."""

    def __init__(self, bus: Bus, on_beat: Callable[[str], None]) -> None:
        """Begin without bindings.

        Args:
            bus: Where heartbeats are published.
            on_beat: Called with the key of each beat, on a thread of the bus; calls `beat` under the robot's lock.
        """
        self._bus = bus
        self._on_beat = on_beat
        self._bindings: dict[str, Binding] = {}  # by element
        self._heard_at: dict[str, float] = {}  # by key
        self._following = threading.Lock()
        self._subscriptions: dict[str, Subscription] = {}  # by key

    @property
    def deadline(self) -> float:
        """When the next binding ends if no beat is heard, s; infinite without bindings."""
        heard_at = tuple(self._heard_at.values())  # in one step: it is read without the lock
        return min(heard_at, default=inf) + SILENCE

    def bind(self, binding: Binding) -> None:
        """Bind a motion that has begun; it replaces the element's former motion."""
        self.release(binding.element)
        self._bindings[binding.element] = binding
        self._heard_at[binding.key] = binding.began_at  # its first beat may still be on its way

    def release(self, element: str) -> None:
        """Remove the binding of an element's motion."""
        binding = self._bindings.pop(element, None)
        if binding is not None and not any(other.key == binding.key for other in self._bindings.values()):
            del self._heard_at[binding.key]

    def beat(self, key: str, now: float) -> None:
        """Note a beat; now: steady time, s."""
        if key in self._heard_at:
            self._heard_at[key] = now

    def expire(self, now: float) -> list[Binding]:
        """Take the bindings whose heartbeat has been silent for too long."""
        silent = {key for key, heard in self._heard_at.items() if now - heard >= SILENCE}
        expired = [binding for binding in self._bindings.values() if binding.key in silent]
        for binding in expired:
            self.release(binding.element)
        return expired

    def follow(self) -> None:
        """Subscribe to the heartbeats that count, and to no others."""
        with self._following:
            wanted = set(self._heard_at)
            for key in self._subscriptions.keys() - wanted:
                self._subscriptions.pop(key).close()
            for key in wanted - self._subscriptions.keys():
                self._subscriptions[key] = self._bus.subscribe_latest(key, self._hear, BEAT_PERIOD)

    def close(self) -> None:
        """Withdraw the subscriptions."""
        with self._following:
            while self._subscriptions:
                self._subscriptions.popitem()[1].close()

    def _hear(self, sample: Sample) -> None:
        self._on_beat(sample.key)

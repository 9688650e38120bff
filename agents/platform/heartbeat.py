"""Heartbeats of agents: each shows that an agent works while it waits for a motion.

An initiator publishes its heartbeat while one of its requests is open, and the request names the key (`x_heartbeat`).
An agent that moves something binds the gateway's motion to its own heartbeat, and cancels the request when the
initiator's heartbeat stops. So each level stops 0.5 s after the level above it died or froze.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from agents.platform.names import AgentName
from bus import JSON, Bus, BusUnavailable, Publisher, Sample
from bus.heartbeat import PERIOD, SILENCE, heartbeat_key


class Heartbeats:
    """The heartbeats of all agents of one container. They are published by the event loop, and stop when it blocks."""

    def __init__(self, bus: Bus) -> None:
        """Publish none yet."""
        self._bus = bus
        self._users: dict[AgentName, int] = {}
        self._publishers: dict[AgentName, Publisher] = {}
        self._task: asyncio.Task[None] | None = None

    @contextmanager
    def beating(self, agent: AgentName) -> Iterator[None]:
        """Publish an agent's heartbeat during a block; blocks may overlap."""
        if agent not in self._publishers:
            self._publishers[agent] = self._bus.publisher(agent.heartbeat_key, JSON)
        self._users[agent] = self._users.get(agent, 0) + 1
        if self._task is None or self._task.done():
            self._task = asyncio.ensure_future(self._run())
        try:
            yield
        finally:
            self._users[agent] -= 1
            if not self._users[agent]:
                del self._users[agent]
                self._publishers.pop(agent).close()  # no heartbeat is published any more, and no motion depends on one

    def close(self) -> None:
        """Stop all heartbeats."""
        if self._task is not None:
            self._task.cancel()
        while self._publishers:
            self._publishers.popitem()[1].close()

    async def _run(self) -> None:
        while self._publishers:
            for publisher in list(self._publishers.values()):
                try:
                    publisher.put({})
                except BusUnavailable:  # the bus is closed, and with it everything that depends on a heartbeat
                    return
            await asyncio.sleep(PERIOD)


@contextmanager
def watched(bus: Bus, key: str, on_silence: Callable[[], None]) -> Iterator[None]:
    """Watch a heartbeat during a block, in the running event loop.

    Args:
        bus: The bus.
        key: The key of the heartbeat.
        on_silence: Called once, in the loop, when the heartbeat has stopped for `SILENCE` seconds.
    Raises:
        KeyNotValid: The key is not that of a heartbeat.
    """
    watch = _Watch(on_silence)
    subscription = bus.subscribe(heartbeat_key(key), watch.hear, urgent=True)
    try:
        yield
    finally:
        watch.close()
        subscription.close()


class _Watch:
    """Calls `on_silence` once when the heartbeat has stopped for too long."""

    def __init__(self, on_silence: Callable[[], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._on_silence = on_silence
        self._heard_at = self._loop.time()
        self._timer = self._loop.call_at(self._heard_at + SILENCE, self._look)

    def hear(self, sample: Sample) -> None:
        """Note a sample of the heartbeat; on the bus's thread."""
        self._heard_at = self._loop.time()

    def close(self) -> None:
        """Watch no more."""
        self._timer.cancel()

    def _look(self) -> None:
        deadline = self._heard_at + SILENCE
        if self._loop.time() >= deadline:
            self._on_silence()
        else:
            self._timer = self._loop.call_at(deadline, self._look)

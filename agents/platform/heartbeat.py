"""Heartbeats of agents: they show that an agent works while it waits for a motion, and are watched by who moves.

An initiator's heartbeat beats while one of its requests is open, and the request names the key (`x_heartbeat`). An
agent that moves something binds the gateway's motion to a heartbeat of its own, and cancels the request when that of
the initiator falls silent. So each level stops 0.5 s after the level above it died or froze.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from agents.platform.names import AgentName
from bus import JSON, Bus, BusUnavailable, Publisher, Sample
from bus.heartbeat import PERIOD, SILENCE, heartbeat_key


class Heartbeats:
    """The heartbeats of all agents of one container. It works in the event loop: where that is held up, they stop."""

    def __init__(self, bus: Bus) -> None:
        """None beats."""
        self._bus = bus
        self._users: dict[AgentName, int] = {}
        self._publishers: dict[AgentName, Publisher] = {}
        self._task: asyncio.Task[None] | None = None

    @contextmanager
    def beating(self, agent: AgentName) -> Iterator[None]:
        """Let an agent's heartbeat beat during a block; blocks may overlap."""
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
                self._publishers.pop(agent).close()  # no more beats; who relies on one has been released by now

    def close(self) -> None:
        """Let none beat any more."""
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
        bus: Where it beats.
        key: Of the heartbeat.
        on_silence: Called once, in the loop, when no beat has come for `SILENCE` seconds.
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
    """Calls `on_silence` once when nothing has been heard for too long."""

    def __init__(self, on_silence: Callable[[], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._on_silence = on_silence
        self._heard_at = self._loop.time()
        self._timer = self._loop.call_at(self._heard_at + SILENCE, self._look)

    def hear(self, sample: Sample) -> None:
        """A beat has come; on the bus's thread."""
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

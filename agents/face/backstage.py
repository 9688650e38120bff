"""A private container for a program of one's own: one agent, on an event loop in a thread of its own."""

import asyncio
import threading
import uuid
from collections.abc import Coroutine
from typing import Any

from agents.face.errors import RobotError
from agents.face.stage import LAST_WORDS, Stage
from agents.platform import Agent, AgentName, Container
from bus import Bus, BusError, ZenohBus
from configs.loader import ConfigError

PLATFORM = "apps"  # where agents live that belong to no robot


class Backstage:
    """What a plain script stands on; its thread ends with the program, whatever the program does.

    stage: that of its agent, `app-1f3a@apps`.
    """

    def __init__(self, bus: Bus | str) -> None:
        """Begin.

        Args:
            bus: A profile to open, or a bus that stays open afterwards.
        Raises:
            RobotError: The bus cannot be reached.
        """
        self._own_bus = _opened(bus) if isinstance(bus, str) else None
        name = f"app-{uuid.uuid4().hex[:8]}"
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()
        self._container = Container(self._own_bus or bus, name)  # type: ignore[arg-type]
        agent = Agent(AgentName(name, PLATFORM))
        self._run(self._container.start(agent))
        self.stage = Stage(agent, self._loop)

    def close(self) -> None:
        """End the agent, the thread and the bus."""
        self._run(self._container.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LAST_WORDS)
        if not self._thread.is_alive():
            self._loop.close()
        if self._own_bus is not None:
            self._own_bus.close()

    def _run(self, work: Coroutine[Any, Any, Any]) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(LAST_WORDS)


def _opened(profile: str) -> Bus:
    try:
        return ZenohBus.open(profile)
    except (BusError, ConfigError) as err:
        raise RobotError(str(err)) from err

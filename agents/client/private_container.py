"""A private container for a program of one's own: one agent, on an event loop in a thread of its own."""

import asyncio
import threading
import uuid
from collections.abc import Coroutine
from contextlib import suppress
from typing import Any

from agents.client.errors import RobotError
from agents.client.loop_thread import LAST_WORDS, LoopThread
from agents.platform import Agent, AgentError, AgentName, Container
from bus import Bus, BusError, NotAllowed, ZenohBus
from configs.loader import ConfigError

PLATFORM = "apps"  # where agents live that belong to no robot
OPENING_TIME = 15.0  # s; only a machine that does nothing else needs so long


class PrivateContainer:
    """What a plain script stands on; its thread ends with the program, whatever the program does.

    thread: that of its agent, `app-1f3a@apps`; on a secure bus `app-1f3a@anna`, after the owner of the key.
    """

    def __init__(self, bus: Bus | str) -> None:
        """Begin.

        Args:
            bus: A profile to open, or a bus that stays open afterwards.
        Raises:
            RobotError: The bus cannot be reached, or allows no program on it.
        """
        if not isinstance(bus, Bus | str):
            raise RobotError(f"a bus is a profile such as 'local', or an open bus, not {bus!r}")
        home = _opened(bus) if isinstance(bus, str) else bus
        self._own_bus = home if isinstance(bus, str) else None
        name = f"app-{uuid.uuid4().hex[:8]}"
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()
        self._container = Container(home, name)
        agent = Agent(AgentName(name, home.own_name or PLATFORM))
        self.thread = LoopThread(agent, self._loop)
        try:
            self._join(agent)
        except (BusError, AgentError, TimeoutError) as err:
            self.close()
            why = str(err) or f"nothing has happened there for {OPENING_TIME:g} s"
            raise RobotError(f"the bus cannot be joined: {why}") from err

    def close(self) -> None:
        """End the agent, the thread and the bus."""
        with suppress(BusError, TimeoutError):  # it is left in any case
            self._run(self._end(), LAST_WORDS)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LAST_WORDS)
        if not self._thread.is_alive():
            self._loop.close()
        if self._own_bus is not None:
            self._own_bus.close()

    async def _end(self) -> None:
        """Close the container, and leave nothing in the loop: Ctrl-C may have come before a call was waited for."""
        try:
            await self._container.close()
        finally:
            left = asyncio.all_tasks() - {asyncio.current_task()}
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)

    def _join(self, agent: Agent) -> None:
        try:
            self._run(self._container.start(agent), OPENING_TIME)
        except NotAllowed:  # who may only look needs no agent that others see
            self._run(agent.look_on(self._container), OPENING_TIME)
            self.thread.only_looks = True

    def _run(self, work: Coroutine[Any, Any, Any], within: float) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(within)


def _opened(profile: str) -> Bus:
    try:
        return ZenohBus.open(profile)
    except (BusError, ConfigError) as err:
        raise RobotError(str(err)) from err

"""Whether those who ask the agents of one container still live: nobody works for a dead one."""

import asyncio
import contextlib
from collections.abc import Callable

from agents.platform.names import AgentName
from agents.platform.talk import hand_over
from bus import Bus, BusError, Subscription

UNSEEN_TIME = 40.0  # s; longer than a setup, in which an agent may ask and shows no token yet
MOST_IDLE = 64  # askers that are watched on after their last conversation, since who has asked asks again


class Askers:
    """Watches the tokens of those who ask, from their first conversation on. All of it happens in the event loop."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._known: dict[AgentName, _Asker] = {}  # the one that has asked last is the last

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Have `gone` called when an asker dies, or shows no token for longer than any setup takes.

        Returns:
            What to call when it does not matter any more.
        """
        known = self._known.pop(asker, None) or _Asker(self._bus, asker)
        self._known[asker] = known
        self._forget_idle()
        return known.attend(gone)

    def close(self) -> None:
        """Watch nobody any more."""
        while self._known:
            self._known.popitem()[1].close()

    def _forget_idle(self) -> None:
        idle = [name for name, known in self._known.items() if known.is_idle]
        for name in idle[: max(len(idle) - MOST_IDLE, 0)]:
            self._known.pop(name).close()


class _Asker:
    """One who asks, or has asked."""

    def __init__(self, bus: Bus, name: AgentName) -> None:
        self._loop = asyncio.get_running_loop()
        self._is_alive = False
        self._calls: dict[object, Callable[[], None]] = {}
        self._watching: Subscription | None = None
        with contextlib.suppress(BusError):  # the bus is closed, or does not let us look
            self._watching = bus.watch_alive(name.alive_key, self._changed)

    @property
    def is_idle(self) -> bool:
        """Whether nothing is being done for it."""
        return not self._calls

    def attend(self, gone: Callable[[], None]) -> Callable[[], None]:
        """Have it called when this one is gone, until what is returned is called."""
        ticket = object()
        unseen = self._loop.call_later(UNSEEN_TIME, self._look, ticket)
        self._calls[ticket] = gone

        def release() -> None:
            unseen.cancel()
            self._calls.pop(ticket, None)

        return release

    def close(self) -> None:
        """Watch no more."""
        if self._watching is not None:
            self._watching.close()

    def _changed(self, key: str, is_alive: bool) -> None:
        hand_over(self._loop, self._note, is_alive)

    def _note(self, is_alive: bool) -> None:
        was_alive, self._is_alive = self._is_alive, is_alive
        if was_alive and not is_alive:
            for gone in list(self._calls.values()):
                gone()

    def _look(self, ticket: object) -> None:
        """Whether it has been seen by now."""
        if not self._is_alive and ticket in self._calls:
            self._calls[ticket]()

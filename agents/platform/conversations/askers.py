"""Whether those who ask the agents of one container still live: nobody works for a dead one."""

import asyncio
import contextlib
from collections.abc import Callable

from agents.platform.names import AgentName
from bus import Bus, BusError, Subscription
from bus.aio import hand_over

UNSEEN_TIME = 40.0  # s; longer than a setup, in which an agent may ask and shows no token yet


class Askers:
    """Watches the tokens of all agents, so that one who asks is known before it does. It works in the event loop."""

    def __init__(self, bus: Bus) -> None:
        """Watch nobody yet."""
        self._bus = bus
        self._alive: set[str] = set()  # by the keys of their tokens
        self._calls: dict[str, dict[object, Callable[[], None]]] = {}
        self._watching: Subscription | None = None

    def watch(self) -> None:
        """Begin, in the running event loop."""
        loop = asyncio.get_running_loop()

        def changed(key: str, is_alive: bool) -> None:
            hand_over(loop, self._note, key, is_alive)

        with contextlib.suppress(BusError):  # the bus does not let us look
            self._watching = self._bus.watch_alive("*/agents/*/alive", changed)

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Have `gone` called when an asker dies, or shows no token for longer than any setup takes.

        Returns:
            What to call when it does not matter any more.
        """
        key, ticket = asker.alive_key, object()
        self._calls.setdefault(key, {})[ticket] = gone
        unseen = None
        if key not in self._alive:
            unseen = asyncio.get_running_loop().call_later(UNSEEN_TIME, self._look, key, ticket)

        def release() -> None:
            if unseen is not None:
                unseen.cancel()
            calls = self._calls.get(key, {})
            calls.pop(ticket, None)
            if not calls:
                self._calls.pop(key, None)  # a forged name leaves no trace

        return release

    def close(self) -> None:
        """Watch nobody any more."""
        if self._watching is not None:
            self._watching.close()

    def _note(self, key: str, is_alive: bool) -> None:
        if is_alive:
            self._alive.add(key)
        elif key in self._alive:
            self._alive.discard(key)
            for gone in list(self._calls.get(key, {}).values()):
                gone()

    def _look(self, key: str, ticket: object) -> None:
        """Whether it has been seen by now."""
        if key not in self._alive and ticket in self._calls.get(key, {}):
            self._calls[key][ticket]()

"""Exchanges with a device behind AUX1, one at a time.

Bytes for the device go out with TTY2. GETAUX delivers once so many bytes are there, and not before: so as many are
asked for as the answer hoped for has; after one that failed to come, as many as the shortest has, and then the rest. A
flush (GETAUX 0) goes before each exchange, so that a byte too much or too few costs one answer.
Source: fact sheet of accessories, section 3.
"""

from collections.abc import Callable, Hashable
from math import inf
from typing import NamedTuple, Protocol

from gateway.outbox import Outbox
from p2os import Command, CommandValue

BLIND_PERIOD = 0.3
"""Seconds between two requests to a device that never answers, as client libraries have it."""


class AuxExchange(NamedTuple):
    """A request, and the length of its answer.

    first: bytes of the shortest answer there can be. whole: of the answer hoped for. patience: s to wait for it.
    """

    request: bytes
    first: int
    whole: int
    patience: float = 0.5


class _Ask(Protocol):
    """The type of `Element._ask`."""

    def __call__(self, command: Command, value: CommandValue | None = None, kind: Hashable = None) -> None:
        """Queue a command that can wait."""


class AuxLine:
    """A queue of exchanges by name: a new one replaces one of its name that still waits.

    is_one_way: the device does not answer, and is not waited for.
    current: the exchange whose answer is awaited.
    """

    def __init__(self, outbox: Outbox, ask: _Ask, accessory_delay: float = 0.0) -> None:
        """Use the robot's line; accessory_delay: as in `LineKind`, s."""
        self.is_one_way = False
        self.current: AuxExchange | None = None
        self._outbox = outbox
        self._ask = ask
        self._accessory_delay = accessory_delay
        self._queue: dict[str, AuxExchange] = {}
        self._give_up_at = inf
        self._not_before = -inf
        self._is_careful = True

    @property
    def deadline(self) -> float:
        """When `watch` is due, s."""
        if self.current is not None:
            return self._give_up_at
        return self._not_before if self._queue else inf

    def clear(self) -> None:
        """Forget everything."""
        self._queue.clear()
        self.current = None
        self.is_one_way = False
        self._not_before = -inf
        self._is_careful = True
        self._drop_frames()

    def put(self, name: str, exchange: AuxExchange) -> None:
        """Queue an exchange."""
        self._queue[name] = exchange

    def put_back(self, exchange: AuxExchange, not_before: float) -> None:
        """Begin again with this one, at a time, s."""
        self._queue = {"again": exchange, **self._queue}
        self._not_before = not_before

    def drop(self, is_dropped: Callable[[str], bool]) -> None:
        """Take back what has not begun yet."""
        self._queue = {name: exchange for name, exchange in self._queue.items() if not is_dropped(name)}

    def has(self, name: str) -> bool:
        """Return whether an exchange waits."""
        return name in self._queue

    def watch(self, now: float) -> bool:
        """Begin what is due; return whether an answer is missing."""
        has_missed = self.current is not None and now >= self._give_up_at
        if has_missed:
            self.current = None
            self._is_careful = True
        if self.current is None and self._queue and now >= self._not_before:
            self._begin(self._queue.pop(next(iter(self._queue))), now)
        return has_missed

    def fetch_rest(self, pending: int) -> None:
        """Ask for what is missing of an answer of which so many bytes have come."""
        if self.current is not None:
            self._ask(Command.GETAUX, max(1, self.current.whole - pending), ("aux", "fetch"))

    def finish(self) -> AuxExchange | None:
        """End the exchange whose answer is complete; return it."""
        done, self.current = self.current, None
        self._is_careful = False
        return done

    def _begin(self, exchange: AuxExchange, now: float) -> None:
        self._drop_frames()
        self._ask(Command.GETAUX, 0, ("aux", "flush"))
        self._ask(Command.TTY2, exchange.request, ("aux", "request"))
        if self.is_one_way:
            self._not_before = now + BLIND_PERIOD
            return
        self._ask(Command.GETAUX, exchange.first if self._is_careful else exchange.whole, ("aux", "fetch"))
        self.current = exchange
        self._give_up_at = now + exchange.patience + self._accessory_delay

    def _drop_frames(self) -> None:
        self._outbox.drop(*(("aux", frame) for frame in ("flush", "request", "fetch")))

"""A stream of the bus as a behaviour: messages are processed in order, and old ones are dropped."""

import asyncio
import threading
from collections import deque
from collections.abc import Awaitable, Callable
from functools import lru_cache
from typing import Any

from agents.platform.behaviours import Behaviour, Gate
from bus import JSON, MessageError, Sample
from bus.aio import hand_over

LARGEST_SHARED = 16384  # bytes; pictures, of which there is one listener, are not kept


class Stream(Behaviour):
    """Processes the messages on one key expression.

    skipped: number of messages dropped because newer ones came while one was being processed.
    """

    def __init__(
        self,
        key_expr: str,
        hear: Callable[..., Awaitable[Any]],
        keep: int,
        malformed: Callable[[Exception], None],
        keyed: bool = False,
    ) -> None:
        """Make one in a running event loop.

        Args:
            key_expr: The key expression, for its name.
            hear: Called with each message, decoded, and with its key before it if `keyed`.
            keep: How many messages wait while one is being processed.
            malformed: Called with the error of a sample that cannot be decoded.
            keyed: Whether `hear` gets the key as well.
        """
        self.name = f"on {key_expr}"
        self.skipped = 0
        self._hear = hear
        self._malformed = malformed
        self._keyed = keyed
        self._lock = threading.Lock()
        self._waiting: deque[Sample] = deque(maxlen=keep)
        self._called = asyncio.Event()
        self._loop = asyncio.get_running_loop()

    def take(self, sample: Sample) -> None:
        """Take a sample; called on the bus's thread."""
        with self._lock:
            was_empty = not self._waiting
            self.skipped += len(self._waiting) == self._waiting.maxlen
            self._waiting.append(sample)
        if was_empty:  # else it has been called already
            hand_over(self._loop, self._called.set)

    @staticmethod
    def decode(sample: Sample) -> Any:
        """Return the message of a sample.

        Agents of one process get the same object, decoded once; they must not change it.

        Raises:
            MessageError: It cannot be decoded.
        """
        if sample.encoding == JSON or len(sample.payload) > LARGEST_SHARED:
            return sample.decoded()
        return _decode_once(sample.payload, sample.encoding)

    async def run(self, gate: Gate) -> None:
        """Process one message after the other."""
        while True:
            await self._called.wait()
            await gate.passed()
            with self._lock:
                sample = self._waiting.popleft() if self._waiting else None
                if not self._waiting:
                    self._called.clear()
            if sample is not None:
                await self._hear_one(sample)

    async def _hear_one(self, sample: Sample) -> None:
        try:
            message = self.decode(sample)
        except MessageError as error:
            self._malformed(error)
            return
        await (self._hear(sample.key, message) if self._keyed else self._hear(message))


@lru_cache(maxsize=8)
def _decode_once(payload: bytes, encoding: str) -> Any:
    return Sample("", payload, encoding).decoded()

"""The newest reading of a stream of the bus, decoded when somebody looks at it."""

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from bus import Bus, MessageError, Sample
from bus.bus import Closeable
from bus.messages import decode

_WINDOW = 2.0  # s over which a rate is counted


class LatestReading(Closeable):
    """The newest sample of one key.

    A sample is noted on the bus's thread and decoded when it is used: a stream at which nobody looks costs next to
    nothing, and no event loop wakes up for it.

    number: of samples so far. at: s of the clock when the newest one came; 0 before the first.
    """

    def __init__(self, bus: Bus, key: str, type_name: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Subscribe.

        Args:
            bus: The bus.
            key: The key.
            type_name: Of its messages.
            clock: Returns s; that of a recording while one is shown.
        """
        self.number = 0
        self.at = 0.0
        self._type_name, self._clock = type_name, clock
        self._sample: Sample | None = None
        self._decoded: tuple[int, Any] = 0, None
        self._times: deque[float] = deque(maxlen=256)
        self._subscription = bus.subscribe(key, self._note, urgent=True)

    @property
    def message(self) -> Any:
        """The newest message, or JSON object; None before the first one, or if it cannot be decoded."""
        number, sample = self.number, self._sample
        if sample is None:
            return None
        if self._decoded[0] != number:
            try:
                is_json = self._type_name == "application/json"
                content = sample.decoded() if is_json else decode(self._type_name, sample.payload)
            except MessageError:  # from a foreign program, or damaged
                content = None
            self._decoded = number, content
        return self._decoded[1]

    def age(self, now: float) -> float:
        """Return the s since the newest sample; infinite before the first one. now: s of the clock."""
        return now - self.at if self.number else float("inf")

    def rate(self, now: float) -> float:
        """Return the samples in a second lately, Hz. now: s of the clock."""
        return sum(0.0 <= now - at <= _WINDOW for at in list(self._times)) / _WINDOW

    def close(self) -> None:
        """End the subscription."""
        self._subscription.close()

    def _note(self, sample: Sample) -> None:  # on the bus's thread
        self._sample, self.at = sample, self._clock()
        if not self._times or self.at != self._times[-1]:  # a recording that is paused repeats its messages
            self._times.append(self.at)
        self.number += 1

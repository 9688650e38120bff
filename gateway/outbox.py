"""Frames on their way to the robot: one at a time, and only the latest of each kind.

What moves the robot goes before what merely asks it something; yet a stream of speeds that fills a slow line lets a
request pass now and then. A robot's command processor wants a pause between commands (source: fact sheet section 3,
command pacing).
"""

from collections.abc import Hashable
from math import inf

from p2os.framing import BITS_PER_BYTE

PACE = 0.005
"""Least seconds between two frames."""
MOST_AHEAD = 8
"""Frames that may overtake a request before it leaves all the same."""


class Outbox:
    """A queue of frames.

    baud: bit/s of the line, so that a slow line is not given more than it carries; 0 where it does not matter.
    share: how much of that may be used; what stops the robot may exceed it.
    last_sent: when the latest frame left, s; None before the first.
    """

    def __init__(self) -> None:
        self.baud = 0
        self.share = 1.0
        self.last_sent: float | None = None
        self._waiting: dict[Hashable, bytes] = {}
        self._requests: dict[Hashable, bytes] = {}
        self._pauses: dict[Hashable, float] = {}  # after the frame has left, s
        self._ahead = 0  # frames that have left before the oldest request
        self._free_at = -inf

    def put(self, kind: Hashable, frame: bytes) -> None:
        """Queue a frame; one of the same kind that still waits is replaced, at its place in the queue."""
        self._waiting[kind] = frame

    def put_first(self, kind: Hashable, frame: bytes) -> None:
        """Queue a frame before all others, without a pause before it."""
        self._waiting.pop(kind, None)
        self._waiting = {kind: frame, **self._waiting}
        self._free_at = -inf

    def put_alone(self, kind: Hashable, frame: bytes, pause: float, now: float) -> float:
        """Queue a frame before all others, after which nothing leaves for a while; what stops the robot does.

        Args:
            kind: As in `put`.
            frame: The whole frame.
            pause: s, from its last byte on.
            now: Steady time, s.
        Returns:
            When the pause is over, s.
        """
        self._waiting.pop(kind, None)
        self._waiting = {kind: frame, **self._waiting}
        self._pauses[kind] = pause
        return max(now, self._free_at) + self._time_for(frame) + pause

    def ask(self, kind: Hashable, frame: bytes) -> None:
        """Queue a request: a frame that can wait until those of `put` have left."""
        self._requests[kind] = frame

    def is_waiting(self, kind: Hashable) -> bool:
        """Whether a frame of this kind is queued and has not left."""
        return kind in self._waiting or kind in self._requests

    def drop(self, *kinds: Hashable) -> None:
        """Take back what has not left yet."""
        for kind in kinds:
            self._waiting.pop(kind, None)
            self._requests.pop(kind, None)

    def clear(self) -> None:
        """Take everything back."""
        self._waiting.clear()
        self._requests.clear()
        self._pauses.clear()
        self._free_at = -inf

    @property
    def deadline(self) -> float:
        """When the next frame may leave, s; infinite while none waits."""
        return self._free_at if self._waiting or self._requests else inf

    def due(self, now: float) -> bytes:
        """Take the frame that leaves now: empty while there is none, or the pause after the last is not over."""
        if now < self._free_at or not (self._waiting or self._requests):
            return b""
        queue = self._next_queue()
        kind = next(iter(queue))
        frame = queue.pop(kind)
        self._free_at = now + max(PACE, self._time_for(frame) + self._pauses.pop(kind, 0.0))
        self.last_sent = now
        return frame

    def time_to_send(self, *frames: bytes) -> float:
        """Seconds until the last byte of these frames is on its way, if nothing else waits."""
        return sum(max(PACE, self._time_for(frame)) for frame in frames[:-1]) + sum(map(self._time_for, frames[-1:]))

    def _time_for(self, frame: bytes) -> float:
        return len(frame) * BITS_PER_BYTE / (self.baud * self.share) if self.baud else 0.0

    def _next_queue(self) -> dict[Hashable, bytes]:
        if self._waiting and (not self._requests or self._ahead < MOST_AHEAD):
            self._ahead = self._ahead + 1 if self._requests else 0
            return self._waiting
        self._ahead = 0
        return self._requests

"""What applications show of robots on maps: following, formations, flow, and any other that uses `Robot.show`."""

import asyncio
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from apps.console.map_layers import is_number
from bus import Bus, MessageError, Sample, keys
from bus.aio import hand_over
from bus.bus import Closeable

_OLD = 3.0  # s after which an overlay is not drawn any more
_MOST = 60  # overlays, of which more are left out
_MOST_SHAPES = 200  # points, and lines, of one
_LONGEST = 120  # characters
_FRAMES = ("base_link", "odom")


class OverlayWatch(Closeable):
    """The overlays of all robots, kept up to date in one event loop."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        """Subscribe, in a running event loop. clock: returns s; that of a recording while one is shown."""
        self._clock = clock
        self._kept: dict[str, tuple[float, dict[str, Any]]] = {}
        take = partial(hand_over, asyncio.get_running_loop(), self.take)
        self._subscription = bus.subscribe(f"*/{keys.OVERLAY.suffix}", take)

    @property
    def overlays(self) -> list[dict[str, Any]]:
        """Those that are not old: robot, application, frame, words, points (x, y) and lines (x1, y1, x2, y2), m."""
        now = self._clock()
        return [content for at, content in self._kept.values() if abs(now - at) <= _OLD]

    def take(self, sample: Sample) -> None:
        """Take an overlay; what is malformed is left out."""
        try:
            told = sample.decoded()
        except MessageError:  # of any program; the next one may be right
            return
        robot, suffix = keys.split(sample.key)
        now = self._clock()
        self._kept = {key: each for key, each in self._kept.items() if abs(now - each[0]) <= _OLD}
        if not isinstance(told, Mapping) or (len(self._kept) >= _MOST and sample.key not in self._kept):
            return
        frame = told.get("frame")
        self._kept[sample.key] = (
            now,
            {
                "robot": robot,
                "application": suffix.rpartition("/")[2],
                "frame": frame if frame in _FRAMES else _FRAMES[0],
                "words": str(told.get("words") or "")[:_LONGEST],
                "points": _rows(told.get("points"), 2),
                "lines": _rows(told.get("lines"), 4),
            },
        )

    def close(self) -> None:
        """End the subscription."""
        self._subscription.close()


def _rows(value: Any, length: int) -> list[list[float]]:
    """Return the rows of a list that have so many finite numbers."""
    rows = value[:_MOST_SHAPES] if isinstance(value, list) else []
    return [row for row in rows if isinstance(row, list) and len(row) == length and all(map(is_number, row))]

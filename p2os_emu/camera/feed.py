"""The newest picture and its viewers; older pictures are dropped."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple


class _JpegPicture(NamedTuple):
    """number: counts from 1. jpeg: the file. time: of what it shows, s since 1970."""

    number: int
    jpeg: bytes
    time: float


class Feed:
    """One writer, any number of viewers; pictures are drawn only while there are viewers."""

    def __init__(self, on_watched: Callable[[bool], None] = lambda is_watched: None) -> None:
        """Begin without a picture.

        Args:
            on_watched: Told when the first viewer comes, and when the last one goes; must not wait.
        """
        self._on_watched = on_watched
        self._newest = _JpegPicture(0, b"", 0.0)
        self._viewers = 0
        self._changed = threading.Condition()

    def put(self, jpeg: bytes, time: float) -> None:
        """Publish a new picture; time: of what it shows, s since 1970."""
        with self._changed:
            self._newest = _JpegPicture(self._newest.number + 1, jpeg, time)
            self._changed.notify_all()

    @property
    def has_viewers(self) -> bool:
        """Whether there are viewers."""
        with self._changed:
            return self._viewers > 0

    def wait_for_viewers(self) -> None:
        """Return as soon as there is a viewer."""
        with self._changed:
            self._changed.wait_for(lambda: self._viewers > 0)

    @contextmanager
    def watching(self) -> Iterator[int]:
        """Count as a viewer while the block runs; yield the number of the last picture."""
        with self._changed:
            self._viewers += 1
            if self._viewers == 1:
                self._on_watched(True)
            self._changed.notify_all()
            before = self._newest.number
        try:
            yield before
        finally:
            with self._changed:
                self._viewers -= 1
                if self._viewers == 0:
                    self._on_watched(False)

    def after(self, number: int, timeout: float) -> _JpegPicture | None:
        """Wait for a picture newer than one; None when none has come within so many s."""
        with self._changed:
            has_come = self._changed.wait_for(lambda: self._newest.number > number, timeout)
            return self._newest if has_come else None

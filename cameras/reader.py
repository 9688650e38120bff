"""A camera at work, on a thread of its own: opens it, hands on its pictures, and opens it again when it fails.

Pictures cost whoever makes them, so a camera is open only while they are wanted. Otherwise it is opened now and then
for a single picture, which shows whether it is still there.
"""

import threading
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass

from cameras.errors import CameraLost
from cameras.jpeg import picture_size
from cameras.source import CameraSource, open_source

NS_PER_S = 1_000_000_000
RETRY = 1.0
"""Seconds between two tries to open a camera."""
LINGER = 2.0
"""Seconds that a camera stays open after its pictures were last wanted."""
CHECK = 10.0
"""Seconds between two looks at a camera whose pictures nobody wants."""
ATTENTION = 0.1
"""Seconds between two looks whether pictures are wanted."""
SINCE_1970 = 1e9
"""Seconds; fewer are counted from elsewhere, such as the start of a computer."""
LEAVING = 1.0
"""Seconds for the thread to end; a device that hangs keeps it, and it ends with the program."""


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """What a camera saw.

    jpeg: a JPEG file. width, height: pixels. stamp_ns: when it was taken, or when it had come where the camera does not
    tell; ns since 1970.
    """

    jpeg: bytes
    width: int
    height: int
    stamp_ns: int


class CameraReader:
    """Reads one camera until it is closed. What it calls, it calls on its own thread."""

    def __init__(
        self,
        where: str,
        on_picture: Callable[[CameraFrame], None],
        on_lost: Callable[[str], None],
        on_damaged: Callable[[], None] = lambda: None,
        open_camera: Callable[[str], CameraSource] = open_source,
        is_wanted: Callable[[], bool] = lambda: True,
        on_rest: Callable[[], None] = lambda: None,
    ) -> None:
        """Make ready; `start` lets the thread run.

        Args:
            where: As `open_source` takes it.
            on_picture: Told of each picture.
            on_lost: Told why there are none, once per try to open it.
            on_damaged: Told of what came and is no whole picture.
            open_camera: How to open it.
            is_wanted: Whether somebody wants pictures now; cheap, it is asked often.
            on_rest: Told when the camera is let go of because nobody does.
        """
        self._where = where
        self._on_picture = on_picture
        self._on_lost = on_lost
        self._on_damaged = on_damaged
        self._open_camera = open_camera
        self._is_wanted = is_wanted
        self._on_rest = on_rest
        self._source: CameraSource | None = None
        self._is_closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> None:
        """Let the thread run."""
        self._thread.start()

    def close(self) -> None:
        """Let go of the camera and end the thread."""
        self._is_closed.set()
        source = self._source
        if source is not None:
            source.interrupt()
        if self._thread.is_alive():
            self._thread.join(LEAVING)

    def _run(self) -> None:
        while not self._is_closed.is_set():
            try:
                with closing(self._open_camera(self._where)) as self._source:
                    self._look(self._source)
            except CameraLost as lost:
                self._on_lost(str(lost))
                self._is_closed.wait(RETRY)
            else:
                self._on_rest()
                self._rest()

    def _rest(self) -> None:
        """Return when pictures are wanted, or it is time to see whether the camera is still there."""
        until = time.monotonic() + CHECK
        while not (self._is_closed.is_set() or self._is_wanted() or time.monotonic() >= until):
            self._is_closed.wait(ATTENTION)

    def _look(self, source: CameraSource) -> None:
        """Hand on pictures as long as they are wanted, one at least.

        Raises:
            CameraLost: There are no more.
        """
        until = time.monotonic()
        while not self._is_closed.is_set():
            picture = source.read()
            stamp_ns = _stamp_ns(picture.taken, time.time_ns())
            size = picture_size(picture.jpeg)
            if size is None:
                self._on_damaged()
            else:
                self._on_picture(CameraFrame(picture.jpeg, *size, stamp_ns))
            if self._is_wanted():
                until = time.monotonic() + LINGER
            elif time.monotonic() >= until:
                return


def _stamp_ns(taken: float | None, now_ns: int) -> int:
    """Return when a picture was taken, ns since 1970.

    Args:
        taken: What its camera says, s since 1970 or from anywhere else.
        now_ns: When it had come.
    """
    if taken is None or taken < SINCE_1970:
        return now_ns
    return min(round(taken * NS_PER_S), now_ns)

"""A camera of a robot: brings its pictures to the bus while somebody wants them, and keeps what others may know of it.

It stands beside the threads of elements on cables (`gateway.cables.cable_thread`) and is used like one.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cameras.reader import CameraFrame, CameraReader
from cameras.source import PATIENCE, CameraSource, open_source
from gateway.cables.cable import IsWanted, PublishEvents
from gateway.events import PictureTaken


class CameraState:
    """What others may know of a camera, in place of a driver's state.

    size: of its pictures, pixels. pictures: how many have come.
    is_resting: nobody wants pictures; the camera was there when it was last opened.
    """

    baud = 0

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.size: tuple[int, int] | None = None
        self.pictures = 0
        self.damaged: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.has_port = False
        self.is_resting = False
        self._clock = clock
        self._complaint = "it has not been opened yet"
        self._picture_at = 0.0

    @property
    def is_connected(self) -> bool:
        """Pictures come, or would come if somebody wanted them."""
        return self.has_port and (self.is_resting or self._clock() - self._picture_at < PATIENCE)

    def faults(self) -> Sequence[str]:
        """What is wrong, a sentence each."""
        if self.is_connected:
            return ()
        why = self._complaint if not self.has_port else f"none has come for {PATIENCE:g} s"
        return (f"the camera gives no pictures: {why}",)

    def figures(self) -> Mapping[str, Any]:
        """For diagnostics."""
        return {"pictures": self.pictures, "resting": self.is_resting}

    def take(self, size: tuple[int, int]) -> None:
        """A picture has come."""
        self.size = size
        self.pictures += 1
        self.has_port = True
        self.is_resting = False
        self._picture_at = self._clock()

    def rest(self) -> None:
        """It has been let go of, since nobody wants its pictures."""
        self.is_resting = self.has_port

    def lose(self, why: str) -> None:
        """It is gone, or was never there."""
        if self.has_port:
            self.lost[why] += 1
        self.has_port = self.is_resting = False
        self._complaint = why


class CameraThread:
    """One camera of one robot.

    name: of the element, as on the bus. driver: its state. bridge: none, since nobody commands a camera.
    """

    name = "camera"
    bridge = None

    def __init__(self, where: str, open_camera: Callable[[str], CameraSource] = open_source) -> None:
        """Make ready; `start` lets the thread run. where: as `open_source` takes it."""
        self.driver = CameraState()
        self._publish: PublishEvents | None = None
        self._is_wanted: IsWanted = lambda: False
        self._reader = CameraReader(
            where, self._take, self.driver.lose, self._count_damage, open_camera, self._has_listeners, self.driver.rest
        )

    def start(self) -> None:
        """Let the thread run."""
        self._reader.start()

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish the pictures from now on, while somebody subscribes to them."""
        self._publish, self._is_wanted = publish, is_wanted

    def halt(self) -> None:
        """Do nothing: a camera does not move."""

    def close(self) -> None:
        """Let go of the camera and end the thread."""
        self._publish, self._is_wanted = None, lambda: False
        self._reader.close()

    def _has_listeners(self) -> bool:
        return self._is_wanted()

    def _count_damage(self) -> None:
        self.driver.damaged["picture"] += 1

    def _take(self, picture: CameraFrame) -> None:
        self.driver.take((picture.width, picture.height))
        publish = self._publish  # `close` may clear it meanwhile
        if publish is not None:
            publish([PictureTaken(picture.jpeg, picture.width, picture.height)], picture.stamp_ns)

"""A camera at work, on a thread of its own: opens it, brings its pictures to the bus, and opens it again when it fails.

It stands beside the threads of elements on cables (`gateway.cables.cable_thread`) and is used like one.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

from gateway.cameras.jpeg import picture_size
from gateway.cameras.source import PATIENCE, Source, open_source
from gateway.errors import CameraLost
from gateway.events import PictureTaken

if TYPE_CHECKING:  # they load the message types, which takes longer than finding the robot
    from gateway.faces.cable_face import CableFace
    from gateway.robot_on_bus import RobotOnBus

RETRY = 1.0
"""Seconds between two tries to open a camera."""
LEAVING = 1.0
"""Seconds for the thread to end; a device that hangs keeps it, and it ends with the program."""


class CameraState:
    """What others may know of a camera, in place of a driver's state.

    size: of its pictures, pixels. is_connected: pictures come. pictures: how many have come.
    """

    baud = 0

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.size: tuple[int, int] | None = None
        self.pictures = 0
        self.damaged: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.has_port = False
        self._clock = clock
        self._complaint = "it has not been opened yet"
        self._picture_at = 0.0

    @property
    def is_connected(self) -> bool:
        """Pictures come."""
        return self.has_port and self._clock() - self._picture_at < PATIENCE

    def faults(self) -> Sequence[str]:
        """What is wrong, a sentence each."""
        if self.is_connected:
            return ()
        why = self._complaint if not self.has_port else f"none has come for {PATIENCE:g} s"
        return (f"the camera gives no pictures: {why}",)

    def figures(self) -> Mapping[str, Any]:
        """For diagnostics."""
        return {"pictures": self.pictures}

    def take(self, size: tuple[int, int]) -> None:
        """A picture has come."""
        self.size = size
        self.pictures += 1
        self.has_port = True
        self._picture_at = self._clock()

    def lose(self, why: str) -> None:
        """It is gone, or was never there."""
        if self.has_port:
            self.lost[why] += 1
        self.has_port = False
        self._complaint = why


class CameraThread:
    """One camera of one robot.

    name: of the element, as on the bus. driver: its state. bridge: none, since nobody commands a camera.
    """

    name = "camera"
    bridge = None

    def __init__(self, where: str, open_camera: Callable[[str], Source] = open_source) -> None:
        """Make ready; `start` lets the thread run. where: as `open_source` takes it."""
        self.driver = CameraState()
        self._where = where
        self._open_camera = open_camera
        self._source: Source | None = None
        self._is_closed = threading.Event()
        self._joined: tuple[RobotOnBus, CableFace[Any]] | None = None
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> None:
        """Let the thread run."""
        self._thread.start()

    def join(self, robot: "RobotOnBus", face: "CableFace[Any]") -> None:
        """From now on bring the pictures to the bus."""
        self._joined = robot, face

    def halt(self) -> None:
        """A camera does not move."""

    def close(self) -> None:
        """Let go of the camera and end the thread."""
        self._joined = None
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
                self.driver.lose(str(lost))
            self._is_closed.wait(RETRY)

    def _look(self, source: Source) -> None:
        while not self._is_closed.is_set():
            jpeg = source.read()
            stamp = time.time_ns()
            size = picture_size(jpeg)
            if size is None:
                self.driver.damaged["picture"] += 1
                continue
            self.driver.take(size)
            if self._joined is not None:
                robot, face = self._joined
                robot.element_happened(face, [PictureTaken(jpeg, *size)], stamp)

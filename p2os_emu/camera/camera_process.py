"""The emulator's side of a camera process: sends changes without blocking while the camera is watched."""

import socket
import subprocess
import sys
from dataclasses import dataclass
from math import radians
from zlib import crc32

from geometry import Pose2D
from p2os_emu.accessories.head import Head
from p2os_emu.camera.image_format import ImageFormat
from p2os_emu.camera.news import SceneMoment, send, watched_reports
from p2os_emu.world.sight import MOST_NEW
from p2os_emu.world.view import View


@dataclass(frozen=True, slots=True)
class CameraModel:
    """An emulated camera, from `configs/accessories/camera.toml`: its place, its view without a head, its pictures.

    forward_m: of the eye, ahead of the axle. height_m: above the floor. wide_deg: horizontal field of view.
    quality: of the JPEG, 1 to 95.
    """

    forward_m: float
    height_m: float
    wide_deg: float
    quality: int

    @property
    def field_of_view(self) -> float:
        """Horizontal, rad."""
        return radians(self.wide_deg)

    def view(self, robot: Pose2D, head: Head | None) -> View:
        """Return where the camera of a robot is and where it looks.

        Args:
            robot: Of the middle of its axle.
            head: The one that carries the camera and has its lens; None for a camera that looks straight ahead.
        """
        if head is None:
            return View.on(robot, self.forward_m, self.height_m, 0.0, 0.0, self.field_of_view)
        pan, tilt = head.pan.position, head.tilt.position
        return View.on(robot, self.forward_m, self.height_m, pan, tilt, head.field_of_view)


FAREWELL = 2.0
"""Seconds for a process to end by itself."""
BACKLOG = 8
PORTS = range(20000, 30000)
"""Below those that the system gives to whoever asks for any."""


class CameraProcess:
    """One camera at `url`; early viewers wait until it serves.

    known: numbers of the things that the process has been told of. is_watched: somebody looks at its pictures.
    is_newly_watched: ... and it has been told nothing since that began.
    """

    def __init__(self, name: str, image: ImageFormat, model: CameraModel) -> None:
        """Start it.

        Args:
            name: Of the robot.
            image: Of its pictures.
            model: What it is.
        Raises:
            OSError: There is no port or no process to be had.
        """
        self.known: set[int] = set()
        self.is_watched = self.is_newly_watched = False
        self._knows_all = False
        listener = _listener(name)
        self._channel, channel = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with listener, channel:
            self.url = f"http://127.0.0.1:{listener.getsockname()[1]}/video"
            command = [sys.executable, "-m", "p2os_emu.camera", str(channel.fileno()), str(listener.fileno())]
            self._process = subprocess.Popen(
                [*command, str(image), str(model.quality), f"The camera of {name}"],
                pass_fds=(channel.fileno(), listener.fileno()),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,  # the engine prints there
                start_new_session=True,  # Ctrl-C in the terminal is for the emulator, whose end is the camera's
            )

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    @property
    def wants_news(self) -> bool:
        """Whether the camera is watched, or does not know all objects yet."""
        return self.is_watched or not self._knows_all

    def listen(self) -> bool:
        """Read whether the camera is watched; return whether the process lives."""
        try:
            for is_watched in watched_reports(self._channel):
                self.is_watched = is_watched
                self.is_newly_watched |= is_watched
        except OSError:  # the process has ended
            return False
        return True

    def tell(self, moment: SceneMoment) -> bool:
        """Send the changes if the process can take them now; return whether it lives."""
        try:
            if send(self._channel, moment):
                self.known |= moment.news.new.keys()
                self.known -= moment.news.gone
                self._knows_all = len(moment.news.new) < MOST_NEW
                self.is_newly_watched = False
        except OSError:  # the process has ended
            return False
        return True

    def leave(self) -> None:
        """Ask the process to end without waiting."""
        self._channel.close()

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended."""
        return self._process.poll() is not None

    def close(self) -> None:
        """End the process and wait for it; closing twice does nothing."""
        self.leave()
        try:
            self._process.wait(FAREWELL)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _listener(name: str) -> socket.socket:
    """Listen on the port derived from the robot's name, so that viewers can reconnect; else on any port."""
    own = PORTS[crc32(name.encode()) % len(PORTS)]
    try:
        return socket.create_server(("127.0.0.1", own), backlog=BACKLOG)
    except OSError:  # somebody has it: the camera of a robot of this name in another emulator, for example
        return socket.create_server(("127.0.0.1", 0), backlog=BACKLOG)

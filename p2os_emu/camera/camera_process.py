"""The emulator's side of a camera process: sends changes without blocking while the camera is watched.

The process ends when nobody has looked for a while, since it takes 115 MB, and is started again for the next viewer.
"""

import select
import socket
import subprocess
import sys
from dataclasses import dataclass
from math import radians
from zlib import crc32

from p2os_emu.camera.image_format import ImageFormat
from p2os_emu.camera.news import RESTED, SceneMoment, send, watched_reports
from p2os_emu.world.sight import MOST_NEW


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


FAREWELL = 2.0
"""Seconds for a process to end by itself."""
PATIENCE = 10.0
"""Seconds without a viewer after which a process ends; the first picture of a new one comes much later."""
BACKLOG = 8
PORTS = range(20000, 30000)
"""Below those that the system gives to whoever asks for any."""


class CameraProcess:
    """One camera at `url`; viewers wait until it serves.

    known: numbers of the things that the process has been told of. is_watched: somebody looks at its pictures.
    is_newly_watched: ... and it has been told nothing since that began.
    """

    def __init__(self, name: str, image: ImageFormat, model: CameraModel, patience: float = PATIENCE) -> None:
        """Start it.

        Args:
            name: Of the robot.
            image: Of its pictures.
            model: What it is.
            patience: s without a viewer after which the process ends until there is one.
        Raises:
            OSError: There is no port or no process to be had.
        """
        self.known: set[int] = set()
        self.is_watched = self.is_newly_watched = False
        self._knows_all = self._is_resting = False
        self._listener = _listener(name)
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}/video"
        self._words = str(image), str(model.quality), f"The camera of {name}", str(patience)
        self._channel, self._process = self._start()

    @property
    def wants_news(self) -> bool:
        """Whether the camera is watched, or does not know all objects yet."""
        return self.is_watched or not (self._knows_all or self._is_resting)

    def listen(self) -> bool:
        """Read whether the camera is watched, and start it again for a viewer; return whether it lives."""
        if self._is_resting:
            return self._wake()
        try:
            for is_watched in watched_reports(self._channel):
                self.is_watched = is_watched
                self.is_newly_watched |= is_watched
        except OSError:  # it ends; how it has ended is seen next time
            self._is_resting, self.is_watched = True, False
        return True

    def tell(self, moment: SceneMoment) -> bool:
        """Send the changes if the process can take them now; return whether it lives."""
        try:
            if send(self._channel, moment):
                self.known |= moment.news.new.keys()
                self.known -= moment.news.gone
                self._knows_all = len(moment.news.new) < MOST_NEW
                self.is_newly_watched = False
        except OSError:
            return False
        return True

    def leave(self) -> None:
        """Ask the process to end without waiting."""
        self._listener.close()
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


    def _start(self) -> tuple[socket.socket, "subprocess.Popen[bytes]"]:
        """Start the process; return the channel to it."""
        own, channel = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        descriptors = channel.fileno(), self._listener.fileno()
        with channel:
            process = subprocess.Popen(
                [sys.executable, "-m", "p2os_emu.camera", *map(str, descriptors), *self._words],
                pass_fds=descriptors,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in the terminal is for the emulator, whose end is the camera's
            )
        return own, process

    def _wake(self) -> bool:
        """Start the process again if somebody wants to look; return whether it can be."""
        if self._process.poll() == RESTED and select.select([self._listener], [], [], 0.0)[0]:
            self._channel.close()
            self.known.clear()
            self._knows_all = self._is_resting = False
            try:
                self._channel, self._process = self._start()
            except OSError:
                return False
        return self._process.returncode in (None, RESTED)


def _listener(name: str) -> socket.socket:
    """Listen on the port derived from the robot's name, so that viewers can reconnect; else on any port."""
    own = PORTS[crc32(name.encode()) % len(PORTS)]
    try:
        return socket.create_server(("127.0.0.1", own), backlog=BACKLOG)
    except OSError:  # somebody has it: the camera of a robot of this name in another emulator, for example
        return socket.create_server(("127.0.0.1", 0), backlog=BACKLOG)

"""The process of one camera. The emulator starts it; it ends with the emulator, however that ends."""

import io
import os
import socket
import sys
import threading
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from p2os_emu.camera.feed import Feed
from p2os_emu.camera.image_format import read_format
from p2os_emu.camera.news import Moment, receive
from p2os_emu.camera.server import CameraServer
from p2os_emu.world.mirror import Mirror, choose_renderer

NICENESS = 10
"""Pictures may be late; the robots' packets may not."""


class Inbox:
    """What the emulator has said since one looked last, put together."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._moment: Moment | None = None
        self._come = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def take(self) -> Moment | None:
        """The world's news, and the view now; None while nothing is new."""
        with self._come:
            moment, self._moment = self._moment, None
            return moment

    def wait(self) -> None:
        """Return as soon as something has come."""
        with self._come:
            self._come.wait_for(lambda: self._moment is not None)

    def _read(self) -> None:
        try:
            while (moment := receive(self._channel)) is not None:
                with self._come:
                    if self._moment is not None:
                        self._moment.news.add(moment.news)
                        moment = Moment(self._moment.news, moment.view)
                    self._moment = moment
                    self._come.notify_all()
        finally:
            os._exit(0)  # the emulator is gone, and whatever else goes on here goes on for nobody


def main(argv: Sequence[str] | None = None) -> int:
    """Draw and serve until the emulator goes.

    Args:
        argv: Descriptors of the channel and of the listening socket, the picture format, the JPEG's quality, a title.
    """
    channel_fd, listener_fd, image_format, quality, title = sys.argv[1:] if argv is None else argv
    os.nice(NICENESS)
    image = read_format(image_format)
    mirror = Mirror(choose_renderer())
    inbox = Inbox(socket.socket(fileno=int(channel_fd)))
    feed = Feed()
    server = CameraServer(socket.socket(fileno=int(listener_fd)), feed, title)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    inbox.wait()
    view = None
    due = time.monotonic()
    while True:
        feed.wait_for_viewers()
        moment = inbox.take()
        if moment is not None:
            mirror.apply(moment.news)
            view = moment.view
        assert view is not None  # the first has been waited for
        feed.put(_jpeg(mirror.draw(view, image.width, image.height), int(quality)))
        now = time.monotonic()
        due = max(due + 1 / image.rate, now)
        time.sleep(due - now)


def _jpeg(colours: NDArray[np.uint8], quality: int) -> bytes:
    file = io.BytesIO()
    Image.fromarray(colours).save(file, "JPEG", quality=quality)
    return file.getvalue()


if __name__ == "__main__":
    sys.exit(main())

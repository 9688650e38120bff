"""The process of one camera. The emulator starts it, and it ends with the emulator."""

import os
import socket
import sys
import threading
import time
from collections.abc import Sequence
from functools import partial

from p2os_emu.camera.feed import Feed
from p2os_emu.camera.image_format import read_format
from p2os_emu.camera.jpeg import encode_jpeg
from p2os_emu.camera.news import SceneMoment, receive, report_watched
from p2os_emu.camera.server import CameraServer
from p2os_emu.world.mirror import Mirror, choose_renderer
from p2os_emu.zero_pages import zeros_given_back

NICENESS = 10
"""Pictures may be late; the robots' packets may not."""
LEAST_OFTEN = 1.0
"""s after which a picture is drawn though nothing new has come: the emulator is paused or too busy, and viewers wait.
"""


class _SceneInbox:
    """Collects what the emulator has sent since the last read."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._moment: SceneMoment | None = None
        self._come = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def take(self) -> SceneMoment | None:
        """The world's news, and the view now; None while nothing is new."""
        with self._come:
            moment, self._moment = self._moment, None
            return moment

    def wait(self, timeout: float | None = None) -> None:
        """Return as soon as something was received, or after a timeout, s."""
        with self._come:
            self._come.wait_for(lambda: self._moment is not None, timeout)

    def _read(self) -> None:
        try:
            while (moment := receive(self._channel)) is not None:
                with self._come:
                    if self._moment is not None:
                        self._moment.news.add(moment.news)
                        moment = moment._replace(news=self._moment.news)
                    self._moment = moment
                    self._come.notify_all()
        finally:
            os._exit(0)  # the emulator is gone, and whatever else goes on here goes on for nobody


def main(argv: Sequence[str] | None = None) -> int:
    """Draw and serve until the emulator ends.

    Args:
        argv: Descriptors of the channel and of the listening socket, the picture format, the JPEG's quality, a title.
    """
    channel_fd, listener_fd, image_format, quality, title = sys.argv[1:] if argv is None else argv
    os.nice(NICENESS)
    image = read_format(image_format)
    renderer = choose_renderer()
    with zeros_given_back():  # before there are threads
        mirror = Mirror(renderer)
    channel = socket.socket(fileno=int(channel_fd))
    inbox = _SceneInbox(channel)
    feed = Feed(partial(report_watched, channel))
    server = CameraServer(socket.socket(fileno=int(listener_fd)), feed, title)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    inbox.wait()
    moment: SceneMoment | None = None
    due = time.monotonic()
    while True:
        if not feed.has_viewers:
            feed.wait_for_viewers()
            moment = _take(inbox, mirror, moment)  # it may be as old as the last viewer
        inbox.wait(LEAST_OFTEN)
        moment = _take(inbox, mirror, moment)
        assert moment is not None  # the first has been waited for
        feed.put(encode_jpeg(mirror.draw(moment.view, image.width, image.height), int(quality)), moment.time)
        now = time.monotonic()
        due = max(due + 1 / image.rate, now)
        time.sleep(due - now)


def _take(inbox: _SceneInbox, mirror: Mirror, last: SceneMoment | None) -> SceneMoment | None:
    """Update the mirror; return the present moment. Without news, the last one lasts."""
    moment = inbox.take()
    if moment is None:
        return None if last is None else last._replace(time=time.time())
    mirror.apply(moment.news)
    return moment


if __name__ == "__main__":
    sys.exit(main())

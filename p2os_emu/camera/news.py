"""Packets between the emulator and a camera process, on a pair of sockets.

The process reports whether somebody looks, and while somebody does, the emulator sends it what is new as often as it
can be taken. That packet is a pickled `SceneMoment`: both ends are this program. A packet is sent whole or not at all,
and what could not be sent is sent with the next one, so the emulator never waits.
"""

import pickle
import socket
from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple

from p2os_emu.world.sight import SceneChanges
from p2os_emu.world.view import View

LARGEST = 2**20
"""Bytes of a packet, at most."""
WATCHED, UNWATCHED = b"\1", b"\0"
"""What a camera's process reports: somebody looks, or nobody does."""


class SceneMoment(NamedTuple):
    """The changes of the world, and the view of the camera. time: of both, s since 1970."""

    news: SceneChanges
    view: View
    time: float


def send(channel: socket.socket, moment: SceneMoment) -> bool:
    """Send without blocking; return whether it was sent.

    Raises:
        OSError: Nobody is there to take it.
    """
    try:
        channel.send(pickle.dumps(moment, pickle.HIGHEST_PROTOCOL), socket.MSG_DONTWAIT)
    except BlockingIOError:  # it is full; what was not sent goes with the next one
        return False
    return True


def receive(channel: socket.socket) -> SceneMoment | None:
    """Wait for the next moment; return None when the emulator has ended."""
    data = channel.recv(LARGEST)
    if not data:
        return None
    moment = pickle.loads(data)
    assert isinstance(moment, SceneMoment)  # both ends are ours
    return moment


def report_watched(channel: socket.socket, is_watched: bool) -> None:
    """Report whether the camera is watched; an emulator that has ended is ignored."""
    with suppress(OSError):  # it is gone
        channel.send(WATCHED if is_watched else UNWATCHED, socket.MSG_DONTWAIT)


def watched_reports(channel: socket.socket) -> Iterator[bool]:
    """Take the reports of a camera's process that have come, without waiting.

    Raises:
        ConnectionError: The process is gone.
    """
    while True:
        try:
            report = channel.recv(1, socket.MSG_DONTWAIT)
        except BlockingIOError:  # nothing has come yet
            return
        if not report:
            raise ConnectionError("the process of the camera has ended")
        yield report == WATCHED

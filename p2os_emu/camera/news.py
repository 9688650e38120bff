"""What the emulator sends a camera's process, as often as it can be taken: packets on a pair of sockets.

A packet is a pickled `Moment`: both ends are this program. A packet is sent whole or not at all, and what could not be
sent is sent with the next one, so the sender never waits.
"""

import pickle
import socket
from typing import NamedTuple

from p2os_emu.world.sight import News
from p2os_emu.world.view import View

LARGEST = 1 << 20
"""Bytes of a packet, at most."""


class Moment(NamedTuple):
    """The world's news, and where the camera looks."""

    news: News
    view: View


def send(channel: socket.socket, moment: Moment) -> bool:
    """Send without waiting; returns whether it could be sent.

    Raises:
        OSError: Nobody is there to take it.
    """
    try:
        channel.send(pickle.dumps(moment, pickle.HIGHEST_PROTOCOL), socket.MSG_DONTWAIT)
    except BlockingIOError:
        return False
    return True


def receive(channel: socket.socket) -> Moment | None:
    """Wait for the next moment; None when there will be none."""
    data = channel.recv(LARGEST)
    if not data:
        return None
    moment = pickle.loads(data)
    assert isinstance(moment, Moment)  # both ends are ours
    return moment

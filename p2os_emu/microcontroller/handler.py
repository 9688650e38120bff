"""Type of command handlers, and the most common handler."""

from collections.abc import Callable
from typing import Any

from p2os.packets import PacketType
from p2os_emu.microcontroller.board import Board

Handler = Callable[[Board, Any], None]
"""Takes the board and the command's value, as `p2os.commands` reads it."""


def requests(packet: PacketType) -> Handler:
    """Ask for a packet: 0 stops it, 1 asks for one, 2 and more for one with every SIP."""
    return lambda board, count: board.requests.ask(packet, count)

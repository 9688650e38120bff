"""Requested packets beside the standard SIP."""

from p2os.arguments import PacketRequest
from p2os.packets import PacketType


class Requests:
    """Packets to send with the next SIP, or with every SIP."""

    __slots__ = ("_wanted",)

    def __init__(self) -> None:
        self._wanted: dict[PacketType, int] = {}

    def clear(self) -> None:
        """Send nothing more."""
        self._wanted.clear()

    def ask(self, packet: PacketType, count: int) -> None:
        """Ask for a packet: 0 stops it, 1 asks for one, 2 and more for one with every SIP."""
        if count <= 0:
            self._wanted.pop(packet, None)
        else:
            self._wanted[packet] = min(count, PacketRequest.CONTINUOUS)

    def take(self) -> list[PacketType]:
        """The packets for this SIP, lowest type first."""
        if not self._wanted:
            return []
        due = sorted(self._wanted)
        self._wanted = {packet: count for packet, count in self._wanted.items() if count == PacketRequest.CONTINUOUS}
        return due

"""AUX ports: the controller's own serial ports, which a client reaches through TTYn and GETAUXn.

What comes in waits in a circular buffer until a client asks for so many bytes; the answer leaves once they are all
there, and what is left over stays. Source: fact sheet section 6, SERAUXpac. Where it is silent, assumed: the size of
the buffer; a new GETAUX takes the place of one not yet met.
"""

from collections.abc import Callable
from random import Random

from p2os.accessory_packets import AuxData
from p2os_emu.device import Device

BUFFER = 256
"""Bytes that wait at most; the oldest are overwritten."""
MOST = 200
"""Bytes of one answer: what keeps a frame within what every client takes."""


class AuxPort:
    """One port.

    baud: its rate, bit/s. device: what is plugged in.
    """

    __slots__ = ("_buffer", "_make", "_number", "_rng", "_wanted", "baud", "device")

    def __init__(self, number: int, baud: int, rng: Random) -> None:
        self.baud = baud
        self.device: Device | None = None
        self._make: Callable[[], Device] | None = None
        self._number = number
        self._rng = rng
        self.clear()

    def plug(self, make: Callable[[], Device]) -> None:
        """Plug a device in. make: makes it as it is after the power switch."""
        self._make = make
        self.power_cycle()

    def power_cycle(self) -> None:
        """Give the device power; it forgets what it was told before."""
        if self._make is not None:
            self.device = self._make()

    def clear(self) -> None:
        """Flush the buffer and forget the request."""
        self._buffer = bytearray()
        self._wanted = 0

    def write(self, data: bytes) -> None:
        """TTYn: send bytes to the device; noise, if it listens at another rate."""
        if self.device is not None:
            self.device.receive(self._carried(data, self.device))

    def ask(self, count: int) -> None:
        """GETAUXn: ask for so many bytes; 0 flushes."""
        if count <= 0:
            self.clear()
        else:
            self._wanted = min(count, MOST)

    def advance(self, dt: float) -> None:
        """Advance the device by a step, s, and take the bytes that it sends."""
        if self.device is None:
            return
        data = self.device.step(dt)
        if data:
            self._buffer += self._carried(data, self.device)
            del self._buffer[:-BUFFER]

    def answer(self) -> AuxData | None:
        """Return the requested bytes once all of them are there."""
        count = self._wanted
        if not 0 < count <= len(self._buffer):
            return None
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        self._wanted = 0
        return AuxData(self._number, data)

    def _carried(self, data: bytes, device: Device) -> bytes:
        return data if device.baud == self.baud else self._rng.randbytes(len(data))

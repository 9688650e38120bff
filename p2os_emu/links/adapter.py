"""A USB serial adapter: bytes from the robot wait in it until a block is full or a timer runs out."""

from dataclasses import dataclass

from p2os_emu.links.stage import Rates

_ROUNDING = 1e-9  # s; times are sums of steps


@dataclass(frozen=True, slots=True)
class Adapter:
    """What the adapter does.

    latency_timer: s after the last block until an incomplete one is handed on.
    block_bytes: payload of one block.
    """

    latency_timer: float
    block_bytes: int


class Blocks:
    """The way from the robot: full blocks at once, the rest when the timer runs out.

    The timer restarts with every block; it ran out long ago when bytes come after silence, so it is restarted with
    the first byte then.
    """

    def __init__(self, adapter: Adapter) -> None:
        self._adapter = adapter
        self._held = bytearray()
        self._since = 0.0

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        if not self._held:
            self._since = now
        self._held += data
        ready = len(self._held) // self._adapter.block_bytes * self._adapter.block_bytes
        if now - self._since >= self._adapter.latency_timer - _ROUNDING:
            ready = len(self._held)
        if ready:
            self._since = now
        handed_on = bytes(self._held[:ready])
        del self._held[:ready]
        return handed_on

"""A stage of a line: one effect on the bytes of one direction."""

from typing import NamedTuple, Protocol


class Rates(NamedTuple):
    """The rates of the two ends at one moment, bit/s; the client's is None where the port knows no rate."""

    host: int
    client: int | None


class LinkStage(Protocol):
    """One effect on the bytes of one direction."""

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """Take the bytes that enter now and return those that leave now; called every step, also without bytes."""

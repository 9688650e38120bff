"""Protocols of drivers and of elements on cables of their own: bytes and time in, events and bytes out."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from gateway.events import Event


class CableDriver(Protocol):
    """A driver without port, clock and threads. `Driver` is the one of the robot itself."""

    @property
    def baud(self) -> int:
        """The rate for writing the bytes due and for reading from now on, bit/s; 0 for a line without a rate."""

    @property
    def deadline(self) -> float:
        """When to call `receive` and `bytes_due` again even without bytes, s."""

    @property
    def is_moving(self) -> bool:
        """Something moves that must stand still before the closing bytes are written."""

    @property
    def stopping_bytes(self) -> bytes:
        """The bytes that stop everything; written first on closing."""

    @property
    def closing_bytes(self) -> bytes:
        """The bytes to write at the end, when everything stands still or the time to stop has passed."""

    def port_opened(self, now: float) -> None:
        """Begin: the port is open."""

    def port_lost(self, reason: str, now: float) -> None:
        """Note that the port is lost or cannot be opened, and why. `receive` reports what follows."""

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take bytes as read; none lets time pass. now: steady time, s."""

    def bytes_due(self, now: float) -> bytes:
        """Take what must be written now."""


class ElementDriver(CableDriver, Protocol):
    """The driver of an element on a cable of its own. It announces `ElementFound` and `ElementLost`.

    has_port: there is a line. is_connected: the element answers as it should; only then it is described on the bus.
    damaged: bytes that were no telegram, counted by reason. lost: how often the element was lost, likewise.
    """

    has_port: bool
    is_connected: bool
    damaged: Counter[str]
    lost: Counter[str]

    def faults(self) -> Sequence[str]:
        """Return what is wrong with the element, a sentence each."""

    def figures(self) -> Mapping[str, Any]:
        """Return the values for diagnostics, beside the counters."""

    def halt(self, now: float) -> None:
        """Stop where it is, because the robot was stopped. Does nothing for an element that cannot move."""


PublishEvents = Callable[[Sequence[Event], int], None]
"""Publishes events of an element, with the wall clock when their bytes came, ns; called on the element's own thread."""
IsWanted = Callable[[], bool]
"""Tells whether anybody subscribes to a stream of an element; called on the element's own thread."""


class ElementCable(Protocol):
    """An element on a cable of its own, as its bus adapter sees it.

    name: of the element, as on the bus.
    """

    name: str

    @property
    def driver(self) -> Any:
        """Its driver, of which only the plain state may be read."""

    @property
    def bridge(self) -> Any:
        """Takes commands for the driver by its `command`; None where nothing can be commanded."""

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish the driver's events from now on."""

    def halt(self) -> None:
        """Stop everything that moves; does not wait for a slow cable."""


class ElementThread(ElementCable, Protocol):
    """An element on a cable of its own with the thread that serves it."""

    def start(self) -> None:
        """Let the thread run."""

    def close(self) -> None:
        """Bring the element to rest, close the port, end the thread."""

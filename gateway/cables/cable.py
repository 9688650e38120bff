"""What the bridge needs of a driver, whatever hangs on the cable: bytes and time in, events and bytes out."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from gateway.events import Event


class CableDriver(Protocol):
    """A driver without port, clock and threads. `Driver` is the one of the robot itself."""

    @property
    def baud(self) -> int:
        """The rate at which to write what is due and to read from now on, bit/s; 0 for a line without a rate."""
        ...

    @property
    def deadline(self) -> float:
        """When to call `receive` and `bytes_due` again even if nothing has come, s."""
        ...

    @property
    def is_moving(self) -> bool:
        """Something moves that should stand still before the last words."""
        ...

    @property
    def stopping_words(self) -> bytes:
        """What to say first on leaving, so that everything comes to rest."""
        ...

    @property
    def last_words(self) -> bytes:
        """What to say at the very end, when everything rests or has had its time."""
        ...

    def port_opened(self, now: float) -> None:
        """There is a line to talk on; begin."""
        ...

    def port_lost(self, reason: str, now: float) -> None:
        """The line is gone, or cannot be opened for this reason. `receive` still reports what follows from it."""
        ...

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take bytes as read; none lets time pass. now: steady time, s."""
        ...

    def bytes_due(self, now: float) -> bytes:
        """Take what must be written now."""
        ...


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
        """What is wrong with the element, a sentence each."""
        ...

    def figures(self) -> Mapping[str, Any]:
        """What diagnostics say of the element beside the counters."""
        ...

    def halt(self, now: float) -> None:
        """Stand still: somebody has stopped the robot. Nothing to do for what cannot move."""
        ...


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
        ...

    @property
    def bridge(self) -> Any:
        """Takes commands for the driver by its `command`; None where nothing can be commanded."""
        ...

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish the driver's events from now on."""
        ...

    def halt(self) -> None:
        """Stop everything that moves; does not wait for a slow cable."""
        ...


class ElementThread(ElementCable, Protocol):
    """An element on a cable of its own with the thread that serves it."""

    def start(self) -> None:
        """Let the thread run."""
        ...

    def close(self) -> None:
        """Bring the element to rest, close the port, end the thread."""
        ...

"""What the bridge needs of a driver, whatever hangs on the cable: bytes and time in, events and bytes out."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from gateway.events import Event

if TYPE_CHECKING:  # the bus takes longer to load than the robot to be found
    from bus.keys import Topic


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


class ElementListener(Protocol):
    """Brings an element's events to the bus; called on the element's own thread."""

    def on_element_events(self, adapter: Any, events: Sequence[Event], stamp_ns: int) -> None:
        """Publish events of the element with this bus adapter. stamp_ns: wall clock, ns, when their bytes came."""
        ...

    def has_listeners(self, topic: "Topic") -> bool:
        """Whether anybody subscribes to a topic of this robot."""
        ...


class ElementThread(Protocol):
    """An element at work on a thread of its own, beside the robot's.

    name: of the element, as on the bus. driver, bridge: as its bus adapter takes them.
    """

    name: str

    @property
    def driver(self) -> Any:
        """Its state."""
        ...

    @property
    def bridge(self) -> Any:
        """The way to command it."""
        ...

    def start(self) -> None:
        """Let the thread run."""
        ...

    def join(self, robot: ElementListener, adapter: Any) -> None:
        """From now on bring what happens to the bus. adapter: the element's bus adapter."""
        ...

    def halt(self) -> None:
        """Let nothing move any more, at once."""
        ...

    def close(self) -> None:
        """Bring the element to rest, let go of it, end the thread."""
        ...

"""One element on a cable of its own at work: its driver and its bridge, on a thread beside the robot's."""

import threading
from collections.abc import Callable, Sequence
from math import inf
from typing import Any, Generic, TypeVar

from gateway.bridge import Bridge
from gateway.cables.cable import ElementDriver, ElementListener
from gateway.events import Event
from gateway.serial_port import Port

D = TypeVar("D", bound=ElementDriver)


class CableThread(Generic[D]):
    """Drives one element, and brings what it reports to the bus once the robot is there.

    name: of the element, as on the bus. driver: only its plain state may be read by others. bridge: the way to it.
    deadline: never; the bridge need not call without events.
    """

    deadline = inf

    def __init__(self, name: str, driver: D, port: Port | None, reopen: Callable[[], Port]) -> None:
        """Begin to talk; `start` lets the thread run.

        Args:
            name: Of the element.
            driver: Nobody else may command it from now on but through the bridge.
            port: Open, and closed with this; None begins by opening it.
            reopen: Opens it again; raises GatewayError while it cannot.
        """
        self.name = name
        self.driver = driver
        self.bridge = Bridge(driver, port, reopen)
        self._thread = threading.Thread(target=self.bridge.run, args=(self,), name=f"{name} cable", daemon=True)
        self._joined: tuple[ElementListener, Any] | None = None

    def start(self) -> None:
        """Let the thread run."""
        self._thread.start()

    def join(self, robot: ElementListener, adapter: Any) -> None:
        """From now on bring what happens to the bus."""
        self._joined = robot, adapter

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Take the driver's events, on the cable's own thread; what comes before there is a robot is lost."""
        if self._joined is not None and events:
            robot, adapter = self._joined
            robot.on_element_events(adapter, events, stamp_ns)

    def halt(self) -> None:
        """Let nothing move any more, at once."""
        self.bridge.command(lambda driver, now: driver.halt(now))

    def close(self) -> None:
        """Bring the element to rest, let go of the port, end the thread."""
        self._joined = None
        self.bridge.stop()
        if self._thread.is_alive():
            self._thread.join()
        self.bridge.close()

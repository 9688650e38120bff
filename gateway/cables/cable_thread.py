"""Elements on cables of their own: how each is opened, and the thread on which its driver and its bridge work."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, Generic, TypeVar

from gateway.bridge import Bridge
from gateway.cables.cable import ElementDriver, ElementThread, IsWanted, PublishEvents
from gateway.errors import ExitCode, GatewayError, NoSuchPort
from gateway.events import Event
from gateway.serial_port import Port, has_rate, open_port
from gateway.settings import Settings

D = TypeVar("D", bound=ElementDriver)


class _CableThread(Generic[D]):
    """Drives one element, and publishes what it reports once the robot is on the bus.

    name: of the element, as on the bus. driver: only its plain state may be read by others. bridge: takes commands for
    the driver. deadline: never; the bridge need not call without events.
    """

    deadline = inf

    def __init__(self, name: str, driver: D, port: Port | None, reopen: Callable[[], Port]) -> None:
        """Begin to talk; `start` lets the thread run.

        Args:
            name: Of the element.
            driver: From now on commanded only through the bridge.
            port: Open, and closed with this; None begins by opening it.
            reopen: Opens it again; raises GatewayError while it cannot.
        """
        self.name = name
        self.driver = driver
        self.bridge = Bridge(driver, port, reopen)
        self._thread = threading.Thread(target=self.bridge.run, args=(self,), name=f"{name} cable", daemon=True)
        self._publish: PublishEvents | None = None

    def start(self) -> None:
        """Let the thread run."""
        self._thread.start()

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Publish events from now on."""
        self._publish = publish

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Take the driver's events, on the cable's own thread; events before `join` are dropped."""
        publish = self._publish  # `close` may clear it meanwhile
        if publish is not None and events:
            publish(events, stamp_ns)

    def halt(self) -> None:
        """Stop everything that moves; does not wait for a slow cable."""
        self.bridge.post(lambda driver, now: driver.halt(now))

    def close(self) -> None:
        """Bring the element to rest, close the port, end the thread."""
        self._publish = None
        self.bridge.stop()
        if self._thread.is_alive():
            self._thread.join()
        self.bridge.close()


@dataclass(frozen=True, slots=True)
class CableKind(ABC):
    """How an element on a cable of its own is opened: `p2os-gateway --NAME ADDRESS`.

    name: of the element and of the option. help: of the option. metavar: what the option calls the address.
    fitted: what holds of the rest of the robot then, in place of the settings' `fitted`.
    """

    name: str
    help: str
    metavar: str = "PORT"
    fitted: Mapping[str, Any] = field(default_factory=dict)

    @abstractmethod
    def check(self, address: str) -> None:
        """Refuse an address that cannot be one, before anything is opened.

        Raises:
            GatewayError: It cannot.
        """

    @abstractmethod
    def open(self, address: str, settings: Settings, waits: bool) -> ElementThread:
        """Open the cable; the thread does not run yet.

        Args:
            address: As the option gives it.
            settings: Of the robot.
            waits: The port may appear later.
        Raises:
            GatewayError: It cannot be opened.
            ConfigError: The settings ask for what the element does not have.
        """


@dataclass(frozen=True, slots=True)
class SerialCable(CableKind):
    """A serial line. make_driver: the driver, from whether the port has a rate and the settings; raises ConfigError."""

    make_driver: Callable[[bool, Settings], ElementDriver] = field(kw_only=True)

    def check(self, address: str) -> None:
        """Do nothing: only opening a port shows whether it is there."""

    def open(self, address: str, settings: Settings, waits: bool) -> _CableThread[ElementDriver]:
        """Begin to talk to the element."""
        try:
            port: Port | None = open_port(address)
        except NoSuchPort:
            if not waits:
                raise
            port = None
        return _CableThread(self.name, self.make_driver(has_rate(address), settings), port, lambda: open_port(address))


@dataclass(frozen=True, slots=True)
class CameraCable(CableKind):
    """A camera at a URL or a device; its thread opens it, now or when it appears."""

    def check(self, address: str) -> None:
        """Refuse an address that is neither a device nor a URL of a camera."""
        import cameras  # here and not at the top: a gateway without a camera starts sooner

        try:
            cameras.check_source(address)
        except cameras.CameraNotUsable as error:
            raise GatewayError(str(error), ExitCode.USAGE) from error

    def open(self, address: str, settings: Settings, waits: bool) -> ElementThread:
        """Return the thread, which opens the camera."""
        from gateway.cables.camera_thread import CameraThread  # likewise

        return CameraThread(address)

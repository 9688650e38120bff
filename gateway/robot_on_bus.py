"""One robot on the bus: its streams, commands, leases and description.

It has no thread and no clock of its own: the owner of the driver calls `on_events`.
"""

import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from bus import Bus, BusUnavailable, Subscription, keys
from bus.name_holder import BusProgram
from gateway.cables.cable import ElementCable
from gateway.command_server import Commander, CommandServer
from gateway.description import RobotDescription
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter, RobotContext, adapter_types
from gateway.elements.all_elements import ELEMENTS
from gateway.events import Event
from gateway.settings import Settings
from gateway.streams import RobotPublishers

STAMPS_APART = 1000
"""ns between the stamps of two packets that were read at once: readers take equal stamps for a repetition."""

_ON_ROBOTS_LINE = [kind for row in ELEMENTS if row.cable is None for kind in adapter_types(row)]
"""Loaded with this module, so that a robot that is found comes to the bus without delay."""


class ElementTokens(Subscription):
    """A token on the bus for each element of a robot, by which agents are made and ended; for one thread.

    They stand for what the robot is known to have, not for what works just now: a cable that is cut for a second ends
    no agent. An element on a cable of its own that does not answer is one that the robot does not have.
    """

    def __init__(self, robot: str, bus: Bus) -> None:
        self._robot = robot
        self._bus = bus
        self._shown: dict[str, Subscription] = {}

    def follow(self, present: Iterable[str]) -> None:
        """Declare the tokens of these elements, and withdraw all others."""
        wanted = set(present)
        if wanted == self._shown.keys():
            return
        for element in self._shown.keys() - wanted:
            self._shown.pop(element).close()
        for element in sorted(wanted - self._shown.keys()):
            self._shown[element] = self._bus.declare_alive(keys.ELEMENT_ALIVE.key(self._robot, element))

    def close(self) -> None:
        """Withdraw them all."""
        self.follow(())


def _adapter_on(cable: ElementCable, robot: RobotContext) -> BusAdapter[Any]:
    """Make the bus adapter of an element on a cable of its own."""
    (row,) = (row for row in ELEMENTS if row.cable is not None and row.cable.name == cable.name)
    (kind,) = adapter_types(row)
    return kind(robot, cable)


class RobotOnBus(Subscription):
    """Publishes one robot under `<name>/` and obeys what comes there.

    name: the robot's, on the bus.
    """

    def __init__(
        self,
        name: str,
        bus: Bus,
        driver: Driver,
        commander: Commander,
        settings: Settings,
        *,
        cables: Sequence[ElementCable] = (),
        new_token: Callable[[], str] = lambda: secrets.token_hex(16),
        wall_clock: Callable[[], int] = time.time_ns,
        steady_clock: Callable[[], float] = time.monotonic,
        process: BusProgram | None = None,
    ) -> None:
        """Declare publishers, subscribers, queryables and tokens.

        Args:
            name: The robot's name on the bus.
            bus: Outlives this.
            driver: Of a robot that has identified itself.
            commander: The way to the driver from the bus's threads.
            settings: Of the robot.
            cables: Elements on cables of their own; from now on their events are published.
            new_token: Makes a lease's token.
            wall_clock: ns since the epoch; judges the age of stamped commands.
            steady_clock: s; judges the age of the description.
            process: The gateway, for the description.
        Raises:
            BusError: The name does not serve as a key, or the bus is closed.
        """
        model = driver.model
        if model is None:
            raise ValueError("the robot has not identified itself yet")
        self.name = name
        self._driver = driver
        robot = RobotContext(name, model, settings, driver)
        cabled = [(cable, _adapter_on(cable, robot)) for cable in cables]
        self._adapters = [*(kind(robot) for kind in _ON_ROBOTS_LINE), *(adapter for _, adapter in cabled)]
        self._server = CommandServer(robot, bus, commander, new_token, wall_clock, self._adapters)
        self._streams = RobotPublishers(robot, bus, self._adapters)
        self._elements = ElementTokens(name, bus)
        self._has_answered = False  # and takes orders; before its first SIP it refuses them
        self._description = RobotDescription(robot, self._adapters, process, steady_clock)
        self._lease_state = bus.publisher(keys.LEASE_STATE.key(name), keys.LEASE_STATE.type_name)
        self._declared: list[Subscription] = [
            self._server,
            self._streams,
            self._elements,
            self._lease_state,
            bus.serve(keys.DESCRIPTION.key(name), self._on_description, urgent=True),
            bus.declare_alive(keys.ALIVE.key(name)),
        ]
        for cable, adapter in cabled:
            cable.join(partial(self._publish_element, adapter), partial(self._streams.is_wanted, adapter))

    @property
    def deadline(self) -> float:
        """When `on_events` is due even without events, s."""
        return min(self._streams.due_at, self._server.deadline)

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Publish what follows from the driver's events, and from time.

        Args:
            events: In their order, maybe none.
            now: Steady time, s.
            stamp_ns: Wall clock when the bytes came that brought the events about.
        """
        with suppress(BusUnavailable):  # the bus is being closed
            for index, event in enumerate(events):
                with self._streams.guarded("events"):
                    self._streams.publish(event, stamp_ns + index * STAMPS_APART)
            self._has_answered |= self._driver.is_connected
            has_news = events or now >= self._streams.due_at  # elements on cables of their own make no events here
            if self._has_answered and has_news:  # a client that finds a token finds a robot that obeys
                with self._streams.guarded("elements"):
                    self._elements.follow(self._present())
            if now >= self._server.deadline:
                self._server.settle()
            with self._streams.guarded("heartbeats"):
                self._server.bindings.follow()
            if self._server.lease_has_changed:
                self._server.lease_has_changed = False
                with self._streams.guarded(keys.LEASE_STATE.suffix):
                    self._lease_state.put(self._server.leases.state(now))
            with self._streams.guarded("status"):
                self._streams.publish_status(self._server.refused, self._server.recent_notice(now), now, stamp_ns)

    def publish_kept(self, events: Iterable[tuple[Event, int]]) -> None:
        """Publish events from before the robot was on the bus, each with its stamp as in `on_events`."""
        with suppress(BusUnavailable):  # the bus is being closed
            for event, stamp_ns in events:
                with self._streams.guarded("events"):
                    self._streams.publish(event, stamp_ns)

    def close(self) -> None:
        """Withdraw everything."""
        while self._declared:
            self._declared.pop().close()

    def _publish_element(self, adapter: BusAdapter[Any], events: Sequence[Event], stamp_ns: int) -> None:
        """Publish what follows from the events of an element on a cable of its own; on that cable's thread."""
        with suppress(BusUnavailable):  # the bus is being closed
            for event in events:
                self._streams.publish_element(adapter, event, stamp_ns)

    def _present(self) -> list[str]:
        """Return the names of the elements that the robot is known to have.

        A robot that is out of touch keeps its elements. An element on a cable of its own is there while it answers.
        """
        return [adapter.name for adapter in self._adapters if adapter.is_present()]

    def _on_description(self, given: dict[str, Any]) -> bytes:
        return self._description.encoded(tuple(self._present()))

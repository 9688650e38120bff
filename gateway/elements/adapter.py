"""The base class of all bus adapters: keys, commands, and messages made from events."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Generic, TypeVar

from bus.keys import Topic
from bus.messages import TransformStamped
from gateway.cables.cable import ElementCable
from gateway.commands import CommandRow
from gateway.driver import Driver
from gateway.elements.all_elements import ElementRow
from gateway.elements.element import Element
from gateway.events import Event, MotionEnd
from gateway.settings import Settings
from p2os import RobotModel


@dataclass(frozen=True, slots=True)
class RobotContext:
    """The robot that an element belongs to.

    name: on the bus. driver: commanded only under the robot's lock; its plain state may be read from any thread.
    """

    name: str
    model: RobotModel
    settings: Settings
    driver: Driver


E = TypeVar("E", bound=Event, contravariant=True)
"""The events from which an adapter makes messages."""


class BusAdapter(Generic[E]):
    """One element on the bus, on the robot's line or on a cable of its own.

    Commands, `halt` and `is_moving` run under the robot's lock. The rest only reads plain state, and runs without it.

    name: as the robot's description and the agents call it. streams: what it publishes. events: classes of the events
    from which it makes messages. subscriptions: streams that it obeys. commands: requests that it obeys; each handler
    is a method. element: the driver's side of an element on the robot's line. cable: the element's own cable; None on
    the robot's line.
    """

    name: ClassVar[str]
    streams: ClassVar[tuple[Topic, ...]] = ()
    events: ClassVar[tuple[type, ...]] = ()
    subscriptions: ClassVar[tuple[Topic, ...]] = ()
    commands: ClassVar[tuple[CommandRow, ...]] = ()
    element: ClassVar[type[Element[Any]] | None] = None

    def __init__(self, robot: RobotContext, cable: ElementCable | None = None) -> None:
        """Prepare the adapter for one robot."""
        self.cable = cable
        self._robot = robot.name
        self._model = robot.model
        self._driver = robot.driver

    def is_present(self) -> bool:
        """Return whether the robot is known to have the element; on a cable of its own, whether it answers now."""
        if self.cable is not None:
            return bool(self.cable.driver.is_connected)
        return self.element is None or self._driver.has(self.element)

    def messages(self, event: E, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return the messages that follow from an event, with their topics.

        Args:
            event: Of a class in `events`, of the robot's line or of the element's own cable.
            stamp: Wall clock when its last byte came, ns.
        """
        return ()

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Return the places of the element's frames on the robot. stamp: wall clock, ns."""
        return ()

    def halt(self, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop the element where it is, if it can move; does not wait for a slow cable.

        Args:
            now: Steady time, s.
            end: How a motion of the wheels under way is reported to have ended.
        """
        if self.cable is not None:
            self.cable.halt()
        elif self.element is not None:
            self._driver.halt_element(self.element, now)

    def is_moving(self, now: float) -> bool:
        """Return whether the element moves by motors of its own, by its last report."""
        if self.cable is not None:
            return bool(self.cable.driver.is_moving)
        return self.element is not None and self._driver.lookup(self.element).is_moving(now)

    def describe(self) -> Mapping[str, Any]:
        """Return what the description contains beyond name and keys; SI and radians, ready for JSON."""
        return {}


def adapter_types(row: ElementRow) -> tuple[type[BusAdapter[Any]], ...]:
    """Load the bus adapters of a row of the table."""
    types: tuple[type[BusAdapter[Any]], ...] = import_module(f"gateway.elements.{row.folder}.adapter").ADAPTERS
    return types

"""What every element has in common as the bus sees it: keys, commands, and messages made from events."""

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from bus.keys import Topic
from bus.messages import TransformStamped
from gateway.commands import CommandRow
from gateway.driver import Driver
from gateway.events import Event
from p2os import RobotModel


class BusAdapter:
    """One element on the bus.

    name: as the robot's description and the agents call it. streams: what it publishes. commands: what it obeys.
    """

    name: ClassVar[str]
    streams: ClassVar[tuple[Topic, ...]] = ()
    commands: ClassVar[tuple[CommandRow, ...]] = ()

    def __init__(self, robot: str, model: RobotModel) -> None:
        """Make ready for one robot, known by this name on the bus."""
        self._robot = robot
        self._model = model

    def is_present(self, driver: Driver) -> bool:
        """Whether the robot is known to have the element."""
        raise NotImplementedError

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """What is to be published of an event, with its topic. stamp: wall clock, ns, when its last byte came."""
        return ()

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Where the element's frames are on the robot."""
        return ()

    @classmethod
    def halt(cls, driver: Driver, now: float) -> None:
        """The lease on the element has changed hands: it stands still. Nothing to do for what cannot move."""

    @classmethod
    def is_moving(cls, driver: Driver, now: float) -> bool:
        """Whether the element moves by motors of its own, as it said last."""
        return False

    def describe(self, driver: Driver) -> Mapping[str, Any]:
        """What the description says of this element beyond its name and keys; SI and radians, ready for JSON."""
        return {}

"""What every element on a cable of its own has in common as the bus sees it; `adapter` is for those on the robot's."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from bus.keys import Topic
from bus.messages import TransformStamped
from gateway.cables.cable import ElementDriver
from gateway.commands import CommandRow
from gateway.events import Event
from gateway.settings import Settings
from p2os import RobotModel

D = TypeVar("D", bound=ElementDriver)
D_co = TypeVar("D_co", bound=ElementDriver, covariant=True)
T = TypeVar("T")


class ElementCommander(Protocol[D_co]):
    """The way to an element's driver from any thread."""

    def command(self, give: Callable[[D_co, float], T]) -> T:
        """Call `give` with the driver and the steady time, nobody else meanwhile, and write what follows."""
        ...

    def post(self, give: Callable[[D_co, float], object]) -> None:
        """The same without waiting: now if the driver is free, and otherwise as soon as it is."""
        ...


class CableAdapter(Generic[D]):
    """One element on the bus.

    name: as the robot's description and the agents call it. streams: what it publishes. commands: what it obeys; their
    handlers are given the robot's driver like all others, and reach the element's own through `commander`.
    """

    name: ClassVar[str]
    streams: ClassVar[tuple[Topic, ...]] = ()

    def __init__(
        self, robot: str, model: RobotModel, settings: Settings, driver: D, commander: ElementCommander[D]
    ) -> None:
        """Make ready for one robot, known by this name on the bus.

        Args:
            robot: The robot's name on the bus.
            model: Of the robot.
            settings: Of the robot.
            driver: Of the element; only its plain state may be read here.
            commander: Everything else goes through it.
        """
        self._robot = robot
        self._model = model
        self._settings = settings
        self._driver = driver
        self._commander = commander
        self.commands: tuple[CommandRow, ...] = ()

    @property
    def driver(self) -> ElementDriver:
        """Of the element, for whoever reports how it is doing."""
        return self._driver

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """What is to be published of an event, with its topic. stamp: wall clock, ns, when its last byte came."""
        return ()

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Where the element's frames are on the robot."""
        return ()

    def describe(self) -> Mapping[str, Any]:
        """What the description says of this element beyond its name and keys; SI and radians, ready for JSON."""
        return {}

    def halt(self) -> None:
        """Somebody has stopped the robot: the element stands still too. Does not wait for a slow cable."""
        self._commander.post(lambda driver, now: driver.halt(now))

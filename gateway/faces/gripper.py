"""The gripper on the bus."""

from collections.abc import Iterable

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Gripper, header
from gateway.commands import Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.gripper import Gripper as GripperElement
from gateway.events import Event, GripperSeen
from gateway.faces.face import Face


def _order(driver: Driver, arguments: Arguments, now: float) -> None:
    driver.element(GripperElement, now).order(arguments["do"])


class GripperFace(Face):
    """`<robot>/gripper` and `command/gripper`."""

    name = "gripper"
    streams = (keys.GRIPPER,)
    commands = (CommandRow(keys.GRIP, {"do": str}, _order),)

    def is_present(self, driver: Driver) -> bool:
        """The robot has said so."""
        return driver.has(GripperElement)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """One with every SIP."""
        if isinstance(event, GripperSeen):
            yield keys.GRIPPER, Gripper(header(stamp, frame(self._robot, "base_link")), True, *event)

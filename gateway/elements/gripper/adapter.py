"""The gripper on the bus."""

from collections.abc import Iterable

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Gripper, Header, JointState, header
from gateway.commands import Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.gripper.element import STOPPING, GripperElement
from gateway.events import Event, GripperJoints, GripperSeen


def _order(driver: Driver, arguments: Arguments, now: float) -> None:
    gripper = driver.element(GripperElement, now)
    if arguments["do"] not in STOPPING:
        driver.check_free()
    gripper.order(arguments["do"])


def _duration(driver: Driver, arguments: Arguments, now: float) -> float:
    return driver.lookup(GripperElement).duration(arguments["do"])


class GripperAdapter(BusAdapter):
    """`<robot>/gripper`, its joints in `<robot>/joint_states`, and `command/gripper`.

    Joints, in m: `<robot>/lift` from its lowest place, `<robot>/left_paddle` and `right_paddle` from the middle, to the
    left.
    """

    name = "gripper"
    streams = (keys.GRIPPER, keys.JOINT_STATES)
    commands = (CommandRow(keys.GRIP, {"do": str}, _order, name, duration=_duration),)

    def is_present(self, driver: Driver) -> bool:
        """The robot has said so."""
        return driver.has(GripperElement)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """One of each with every SIP; a joint whose place nobody knows is left out."""
        match event:
            case GripperSeen():
                yield keys.GRIPPER, Gripper(self._header(stamp), True, *event)
            case GripperJoints(opening, lift):
                places = {"lift": lift}
                if opening is not None:
                    places |= {"left_paddle": opening / 2.0, "right_paddle": -opening / 2.0}
                known = {frame(self._robot, name): place for name, place in places.items() if place is not None}
                if known:
                    yield keys.JOINT_STATES, self._joint_state(known, stamp)

    @classmethod
    def halt(cls, driver: Driver, now: float) -> None:
        """Stop it where it is."""
        driver.halt_element(GripperElement, now)

    @classmethod
    def is_moving(cls, driver: Driver, now: float) -> bool:
        """Paddles or lift."""
        return driver.lookup(GripperElement).is_moving(now)

    def _joint_state(self, places: dict[str, float], stamp: int) -> JointState:
        nothing = np.array([])
        position = np.array(list(places.values()))
        return JointState(
            header=self._header(stamp), name=list(places), position=position, velocity=nothing, effort=nothing
        )

    def _header(self, stamp: int) -> Header:
        return header(stamp, frame(self._robot, "base_link"))

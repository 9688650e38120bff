"""The gripper on the bus."""

from collections.abc import Iterable
from typing import Never

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Gripper, Header, JointState, header
from gateway.commands import Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.gripper.element import STOPPING, GripperElement
from gateway.events import Event, GripperJoints, GripperSeen


class _GripperAdapter(BusAdapter[Never]):
    """`<robot>/gripper`, its joints in `<robot>/joint_states`, and `command/gripper`.

    Joints, in m: `<robot>/lift` from its lowest place, `<robot>/left_paddle` and `right_paddle` from the middle, to the
    left.
    """

    name = "gripper"
    element = GripperElement
    streams = (keys.GRIPPER, keys.JOINT_STATES)
    events = (GripperSeen, GripperJoints)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return two messages for each SIP; a joint whose position is unknown is left out."""
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

    def _joint_state(self, places: dict[str, float], stamp: int) -> JointState:
        nothing = np.array([])
        position = np.array(list(places.values()))
        return JointState(
            header=self._header(stamp), name=list(places), position=position, velocity=nothing, effort=nothing
        )

    def _header(self, stamp: int) -> Header:
        return header(stamp, frame(self._robot, "base_link"))

    def _order(self, arguments: Arguments, now: float) -> None:
        gripper = self._driver.element(GripperElement, now)
        if arguments["do"] not in STOPPING:
            self._driver.check_free()
        gripper.order(arguments["do"])

    def _duration(self, arguments: Arguments, now: float) -> float:
        return self._driver.lookup(GripperElement).duration(arguments["do"])

    commands = (CommandRow(keys.GRIP, {"do": str}, _order, name, duration=_duration),)


ADAPTERS = (_GripperAdapter,)

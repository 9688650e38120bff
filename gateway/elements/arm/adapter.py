"""The arm on the bus; the same keys on the robot's line and on a cable of its own."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Arm, JointState, header
from gateway.commands import Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.arm import commands as arm_commands
from gateway.elements.arm.element import ArmElement
from gateway.elements.arm.joint_limits import JointLimits
from gateway.events import ArmSeen, Event

T = TypeVar("T")


class ArmAdapter(BusAdapter):
    """`<robot>/arm`, its joints among `<robot>/joint_states`, and `command/arm`.

    The joints are `<robot>/arm_joint_1` and so on; that of a gripper is the last.
    """

    name = "arm"
    streams = (keys.ARM, keys.JOINT_STATES)
    element = ArmElement

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return two messages for each report of the arm."""
        if isinstance(event, ArmSeen):
            base = header(stamp, frame(self._robot, "base_link"))
            yield keys.ARM, Arm(base, event.powered, event.homed, event.moving)
            joints = JointState(
                header=base,
                name=self._joint_names(len(event.positions)),
                position=np.array(event.positions),
                velocity=np.array([]),
                effort=np.array([]),
            )
            yield keys.JOINT_STATES, joints

    def describe(self) -> Mapping[str, Any]:
        """Return the limits and speeds of the joints, as the arm reports them."""
        return {"joints": arm_commands.describe(self._limits, self._joint_names(len(self._limits)))}

    @property
    def _limits(self) -> Sequence[JointLimits]:
        return self._driver.lookup(ArmElement).limits

    def _call(self, call: Callable[[arm_commands.Reaching, float], T], now: float) -> T:
        """Call a function with the arm and the steady time of its line, s.

        Raises:
            CommandRefused: There is no arm, or the function refuses.
        """
        return call(self._driver.element(ArmElement, now), now)

    def _joint_names(self, count: int) -> list[str]:
        return [frame(self._robot, f"arm_joint_{number}") for number in range(1, count + 1)]

    def _reach(self, arguments: Arguments, now: float) -> None:
        self._call(lambda arm, at: arm_commands.order(arm, self._driver, arguments, at), now)

    def _duration(self, arguments: Arguments, now: float) -> float:
        return self._call(lambda arm, at: arm_commands.duration(arm, arguments), now)

    commands = (CommandRow(keys.REACH, {"do": str}, _reach, name, may_take=arm_commands.MAY_TAKE, duration=_duration),)


ADAPTERS = (ArmAdapter,)

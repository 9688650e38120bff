"""The arm on the bus, whichever cable it hangs on: the Pioneer's on the robot's own, the PowerBot's on its own."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Arm, JointState, header
from gateway.commands import Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.arm import commands as arm_commands
from gateway.elements.arm.element import ArmElement
from gateway.elements.arm.joint_limits import JointLimits
from gateway.events import ArmSeen, Event

NAME = "arm"
STREAMS = (keys.ARM, keys.JOINT_STATES)


def arm_messages(robot: str, event: ArmSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
    """`<robot>/arm`, and its joints among `<robot>/joint_states`."""
    base = header(stamp, frame(robot, "base_link"))
    yield keys.ARM, Arm(base, event.powered, event.homed, event.moving)
    yield (
        keys.JOINT_STATES,
        JointState(
            header=base,
            name=joint_names(robot, len(event.positions)),
            position=np.array(event.positions),
            velocity=np.array([]),
            effort=np.array([]),
        ),
    )


def joint_names(robot: str, count: int) -> list[str]:
    """`<robot>/arm_joint_1` and so on; a gripper's is the last."""
    return [frame(robot, f"arm_joint_{number}") for number in range(1, count + 1)]


def arm_description(robot: str, limits: Sequence[JointLimits]) -> Mapping[str, Any]:
    """Ends and speeds of the joints."""
    return {"joints": arm_commands.describe(limits, joint_names(robot, len(limits)))}


def _order(driver: Driver, arguments: Arguments, now: float) -> None:
    arm_commands.order(driver.element(ArmElement, now), driver, arguments, now)


def _duration(driver: Driver, arguments: Arguments, now: float) -> float:
    return arm_commands.duration(driver.element(ArmElement, now), arguments)


class ArmAdapter(BusAdapter):
    """`<robot>/arm` and `command/arm` of the Pioneer arm."""

    name = NAME
    streams = STREAMS
    commands = (CommandRow(keys.REACH, {"do": str}, _order, NAME, may_take=arm_commands.MAY_TAKE, duration=_duration),)

    def is_present(self, driver: Driver) -> bool:
        """The robot has said so."""
        return driver.has(ArmElement)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Two with every ARMpac."""
        if isinstance(event, ArmSeen):
            yield from arm_messages(self._robot, event, stamp)

    @classmethod
    def halt(cls, driver: Driver, now: float) -> None:
        """Stop it where it is."""
        driver.halt_element(ArmElement, now)

    @classmethod
    def is_moving(cls, driver: Driver, now: float) -> bool:
        """Some joint."""
        return driver.lookup(ArmElement).is_moving(now)

    def describe(self, driver: Driver) -> Mapping[str, Any]:
        """Its joints, as the robot says they are."""
        return arm_description(self._robot, driver.lookup(ArmElement).limits)

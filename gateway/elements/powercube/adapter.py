"""An arm of PowerCube modules on the bus."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from gateway.cables.cable import ElementCable
from gateway.elements.adapter import RobotContext
from gateway.elements.arm.adapter import ArmAdapter, ArmCommands
from gateway.elements.arm.joint_limits import JointLimits
from p2os.accessories.arm_model import ArmModel

T = TypeVar("T")

CABLE_PATIENCE = 0.05
"""Seconds to wait for the arm's cable: the caller has the robot's lock, and a stop of the robot waits meanwhile."""


class _PowerCubeAdapter(ArmAdapter):
    """`<robot>/arm` and `command/arm` of the PowerBot's arm, on a cable of its own."""

    def __init__(self, robot: RobotContext, cable: ElementCable) -> None:
        super().__init__(robot, cable)
        self._arm = cable

    @property
    def _arm_model(self) -> ArmModel:
        model: ArmModel = self._arm.driver.model
        return model

    @property
    def _limits(self) -> Sequence[JointLimits]:
        limits: Sequence[JointLimits] = self._arm.driver.limits
        return limits

    def _call(self, call: Callable[[ArmCommands, float], T], now: float) -> T:
        result: T = self._arm.bridge.command(call, CABLE_PATIENCE)
        return result


ADAPTERS = (_PowerCubeAdapter,)

"""An arm of PowerCube modules on the bus: the same keys as an arm on the robot's own cable."""

from collections.abc import Iterable, Mapping
from typing import Any

from bus import keys
from bus.keys import Topic
from gateway.commands import Arguments, CommandRow
from gateway.driver import Driver
from gateway.elements.arm import commands as arm_commands
from gateway.elements.arm.adapter import STREAMS, arm_description, arm_messages
from gateway.elements.cable_adapter import CableAdapter, ElementCommander
from gateway.elements.powercube.driver import NAME, PowerCubeDriver
from gateway.events import ArmSeen, Event
from gateway.settings import Settings
from p2os import RobotModel


class PowerCubeAdapter(CableAdapter[PowerCubeDriver]):
    """`<robot>/arm` and `command/arm` of the PowerBot's arm."""

    name = NAME
    streams = STREAMS

    def __init__(
        self,
        robot: str,
        model: RobotModel,
        settings: Settings,
        driver: PowerCubeDriver,
        commander: ElementCommander[PowerCubeDriver],
    ) -> None:
        super().__init__(robot, model, settings, driver, commander)
        self.commands = (
            CommandRow(
                keys.REACH, {"do": str}, self._order, NAME, may_take=arm_commands.MAY_TAKE, duration=self._duration
            ),
        )

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Two with every round of answers."""
        if isinstance(event, ArmSeen):
            yield from arm_messages(self._robot, event, stamp)

    def describe(self) -> Mapping[str, Any]:
        """Its joints, as the modules say they are."""
        return arm_description(self._robot, self._driver.limits)

    def _duration(self, robot: Driver, arguments: Arguments, now: float) -> float:
        return self._commander.command(lambda arm, at: arm_commands.duration(arm, arguments))

    def _order(self, robot: Driver, arguments: Arguments, now: float) -> None:
        self._commander.command(lambda arm, at: arm_commands.order(arm, robot, arguments, at))

"""Turn the robot to where one is told."""

from apps.indoor_navigation.algorithms.orientation import OrientationParameters, turn
from apps.indoor_navigation.component import Component, Role, hears, is_told
from apps.indoor_navigation.data import MotionCmd, RobotOdometry, WorldCoord

TURN = "turn"


class Orienting(Component):
    """Wants the robot to look where it was told last, with each pose."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = OrientationParameters

    async def setup(self) -> None:
        """Know nothing yet."""
        self._target: WorldCoord | None = None

    @is_told(WorldCoord)
    async def look(self, target: WorldCoord) -> None:
        """There, unless there was a later order."""
        if self._target is None or target.order >= self._target.order:
            self._target = target

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """The robot looks there now."""
        if self._target is None:
            return
        is_wanted = self._target.aim == TURN
        angular = turn(self.parameters, odometry, self._target.heading) if is_wanted else 0.0
        self.push(MotionCmd(odometry.stamp, self.name.local, 0.0, angular, float(is_wanted)))

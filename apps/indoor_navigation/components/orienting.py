"""The component that turns the robot to a heading."""

from apps.indoor_navigation.algorithms.orientation import OrientationParameters, turn
from apps.indoor_navigation.component import Component, Role, hears, is_told
from apps.indoor_navigation.data import TURN, MotionCmd, RobotOdometry, WorldCoord
from apps.indoor_navigation.wakefulness import moves


class Orienting(Component):
    """Pushes a command towards the heading of the last target, with each odometry.

    It sleeps when orders have ceased, and the robot has stood for some time.
    """

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = OrientationParameters
    is_pulled = False

    async def setup(self) -> None:
        """Begin without a target."""
        self._target: WorldCoord | None = None

    @is_told(WorldCoord)
    async def look(self, target: WorldCoord) -> None:
        """Set the target; ignore it if a newer order was received."""
        self.work()
        if self._target is None or target.order >= self._target.order:
            self._target = target

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """Push the command for this pose."""
        if self._target is None:
            return
        is_wanted = self._target.aim == TURN
        if is_wanted and moves(odometry):
            self.work()
        angular = turn(self.parameters, odometry, self._target.heading) if is_wanted else 0.0
        self.push(MotionCmd(odometry.stamp, self.name.local, 0.0, angular, float(is_wanted)))

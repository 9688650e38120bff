"""Edges of the floor: the sensors that detect them, and the fall of a robot that drives over one."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry import Pose2D
from p2os_emu.world.collision import HULL, lift_wheels
from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.spec import Block


@dataclass(frozen=True, slots=True)
class LedgeModel:
    """Where a robot's ledge sensors look at the floor: ahead of its hull, m."""

    far_m: float
    near_m: float


class Ledges:
    """The edges that one robot meets.

    A robot whose axle passes an edge hangs there: it moves no more until somebody lifts it, and its wheels turn in the
    air. How it would fall further is not modelled.
    """

    def __init__(
        self, client: PhysicsClient, body: int, drops: Sequence[Block], front: float, model: LedgeModel | None
    ) -> None:
        """Watch one robot.

        Args:
            client, body: Of the engine.
            drops: Where there is no floor.
            front: Of the hull, m ahead of the axle.
            model: Its ledge sensors, if it has them.
        """
        self._client = client
        self._body = body
        self._drops = drops
        self._looks = (front + model.far_m, front + model.near_m) if model else ()
        self._hold = -1

    def sensed(self, pose: Pose2D) -> tuple[bool, bool]:
        """Whether the far and the near sensor look over an edge, for a robot at a pose."""
        if not self._looks:
            return False, False
        far, near = (self._is_open(*pose.transform(ahead, 0.0)) for ahead in self._looks)
        return far, near

    def follow(self, pose: Pose2D) -> None:
        """Hold a robot whose axle has passed an edge."""
        if self._hold < 0 and self._is_open(pose.x, pose.y):
            place, orientation = self._client.getBasePositionAndOrientation(self._body)
            self._hold = self._client.createConstraint(
                self._body,
                HULL,
                -1,
                -1,
                engine.JOINT_FIXED,
                [0.0] * 3,
                [0.0] * 3,
                place,
                [0.0, 0.0, 0.0, 1.0],
                orientation,
            )
            lift_wheels(self._client, self._body, True)

    def free(self) -> None:
        """Put the robot on its wheels again."""
        if self._hold >= 0:
            self._client.removeConstraint(self._hold)
            self._hold = -1
            lift_wheels(self._client, self._body, False)

    def _is_open(self, x: float, y: float) -> bool:
        return any(drop.contains(x, y) for drop in self._drops)

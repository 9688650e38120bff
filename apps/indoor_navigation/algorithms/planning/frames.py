"""The frame in which missions are planned: `odom`, or `map` while the robot is localized.

Readings come in odom and orders are given in odom, which drifts. Goals, plans and remembered obstacles of a localized
robot stay where they are in the building: readings are converted by the present pose of odom in map, and orders back.
"""

from dataclasses import dataclass, field, replace
from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.planning.orders import Order
from apps.indoor_navigation.data import DLEData, Floats, GoalPoint, ObstRead, Place, Pose
from geometry import Pose2D, wrap_angle

ODOM, MAP = "odom", "map"
CORRECTION, CORRECTION_TURN = 0.02, 0.005  # m and rad at the robot; smaller corrections are left out, for a steady path


@dataclass(frozen=True, slots=True)
class PlanFrame:
    """name: `odom` or `map`. odom: pose of the frame odom in it."""

    name: str = ODOM
    odom: Pose2D = field(default_factory=Pose2D)

    @property
    def is_map(self) -> bool:
        """Whether the robot is localized."""
        return self.name == MAP

    def is_corrected_by(self, odom: Pose2D, robot: Pose) -> bool:
        """Return whether another pose of odom changes that of the robot, given in odom, by more than a little."""
        here = Pose2D(*robot)
        before, after = self.odom.compose(here), odom.compose(here)
        turn = abs(wrap_angle(after.heading - before.heading))
        return hypot(after.x - before.x, after.y - before.y) > CORRECTION or turn > CORRECTION_TURN

    def reading(self, reading: ObstRead) -> ObstRead:
        """Return a reading with places in this frame."""
        if not self.is_map:
            return reading
        origin_x, origin_y = self._places(reading.origin_x, reading.origin_y)
        end_x, end_y = self._places(reading.end_x, reading.end_y)
        body_x, body_y = self._places(reading.body_x, reading.body_y)
        return replace(
            reading,
            pose=self.pose(reading.pose),
            origin_x=origin_x,
            origin_y=origin_y,
            end_x=end_x,
            end_y=end_y,
            body_x=body_x,
            body_y=body_y,
        )

    def doors(self, data: DLEData) -> DLEData:
        """Return the doors of a scan with places in this frame."""
        if not self.is_map:
            return data
        doors = []
        for door in data.doors:
            x, y, normal = self.pose((door.x, door.y, door.normal))
            doors.append(replace(door, x=x, y=y, normal=normal))
        return replace(data, pose=self.pose(data.pose), doors=tuple(doors))

    def goal(self, goal: GoalPoint) -> GoalPoint:
        """Return a goal in this frame; one in map stays as it is while the robot is not localized."""
        if goal.frame == self.name or goal.frame == MAP or goal.x is None or goal.y is None:
            return goal
        x, y, heading = self.pose((goal.x, goal.y, goal.heading or 0.0))
        return replace(goal, x=x, y=y, heading=None if goal.heading is None else heading, frame=self.name)

    def order(self, order: Order) -> Order:
        """Return an order of this frame with places in odom."""
        if not self.is_map:
            return order
        x, y, heading = self.in_odom((order.x, order.y, order.heading))
        path = np.array(order.path).reshape(-1, 2)
        barred = np.array(order.barred).reshape(-1, 2)
        return replace(order, x=x, y=y, heading=heading, path=self._listed(path), barred=self._listed(barred))

    def pose(self, pose: Pose) -> Pose:
        """Return a pose in odom as one in this frame."""
        found = self.odom.compose(Pose2D(*pose))
        return found.x, found.y, wrap_angle(found.heading)

    def place_in_odom(self, place: Place) -> Place:
        """Return a place of this frame in odom."""
        return self.odom.locate(*place)

    def in_odom(self, pose: Pose) -> Pose:
        """Return a pose of this frame in odom."""
        if not self.is_map:
            return pose
        found = Pose2D(*pose).relative_to(self.odom)
        return found.x, found.y, found.heading

    def _places(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        c, s = np.cos(self.odom.heading), np.sin(self.odom.heading)
        return self.odom.x + c * x - s * y, self.odom.y + s * x + c * y

    def _listed(self, places: Floats) -> tuple[float, ...]:
        if not len(places):
            return ()
        c, s = np.cos(self.odom.heading), np.sin(self.odom.heading)
        dx, dy = places[:, 0] - self.odom.x, places[:, 1] - self.odom.y
        found = np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)
        return tuple(np.round(found, 3).ravel().tolist())

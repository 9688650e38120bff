"""The method that the paper criticises, small, to compare with: turn to the free block nearest the target, each time.

The space about the robot is divided into blocks. Where the target's own block is not free, the robot turns to the free
one that is nearest to it, and goes on there, until the next reading says otherwise. Nothing is remembered, nothing
weighed, and no speed but one is known.
"""

from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.tracking import Speeds, TrackingParameters
from apps.indoor_navigation.components.goto import Goto, Steering
from apps.indoor_navigation.data import Floats, Place, RobotOdometry, WorldCoord
from geometry import wrap_angle

BLOCKS = 24  # of 15 degrees, about as many as a ring of sonar discs has
AHEAD = 0.8  # m on the path to the place that it steers to


@dataclass(frozen=True, slots=True)
class BlockParameters:
    """When a block is free, and how the robot turns to it.

    free: m beyond the outline for which a block must be empty. angular: rad/s at which it turns. turned: rad that are
    near enough. there: m.
    """

    free: float = 0.6
    angular: float = 0.6
    turned: float = 0.13
    there: float = 0.1


class FreeSpaceBlock:
    """Steers by the blocks of one reading; takes the place of `PathTracking`."""

    def __init__(self, outline: Outline, parameters: BlockParameters | None = None) -> None:
        self._outline = outline
        self._parameters = parameters or BlockParameters()

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Say how to go on; see `PathTracking.steer`."""
        parameters = self._parameters
        ahead = _ahead(odometry, target)
        x, y = ahead[0] - odometry.x, ahead[1] - odometry.y
        distance = hypot(x, y)
        if distance <= parameters.there:
            return Speeds()
        bearing = wrap_angle(atan2(y, x) - odometry.heading)
        direction = self._nearest_free(bearing, distance, places)
        if direction is None:
            return Speeds(0.0, parameters.angular)
        if abs(direction) > parameters.turned:
            linear = 0.0 if abs(direction) > pi / 4.0 else target.speed / 2.0
            return Speeds(linear, parameters.angular if direction > 0.0 else -parameters.angular)
        slow = min(1.0, distance / 0.5) if target.is_last else 1.0
        return Speeds(target.speed * slow, 0.0)

    def _nearest_free(self, bearing: float, distance: float, places: tuple[Floats, Floats]) -> float | None:
        """The middle of the free block nearest the target's direction, rad; the direction itself in its own block."""
        width = 2.0 * pi / BLOCKS
        middles = -pi + width * (np.arange(BLOCKS) + 0.5)
        is_free = np.array([self._is_free(middle, distance, places) for middle in middles])
        if not is_free.any():
            return None
        off = np.abs((middles - bearing + pi) % (2.0 * pi) - pi)
        nearest = int(np.where(is_free, off, np.inf).argmin())
        return bearing if off[nearest] <= width / 2.0 else float(middles[nearest])

    def _is_free(self, middle: float, distance: float, places: tuple[Floats, Floats]) -> bool:
        """Whether nothing is in the lane as wide as the robot that leads through a block."""
        x, y = places
        along, across = np.cos(middle) * x + np.sin(middle) * y, np.cos(middle) * y - np.sin(middle) * x
        lane = self._outline.width / 2.0 + 0.05
        reach = self._outline.front + min(self._parameters.free, distance)
        return not ((along > 0.0) & (along < reach) & (np.abs(across) < lane)).any()


def _ahead(odometry: RobotOdometry, target: WorldCoord) -> Place:
    """Return a place some way ahead on the path, to which this method can steer straight."""
    for x, y in zip(target.path[::2], target.path[1::2], strict=True):
        if hypot(x - odometry.x, y - odometry.y) > AHEAD:
            return x, y
    return target.x, target.y


class BlockGoto(Goto):
    """Goto by that method: `BlockGoto("goto@happy", properties)` in place of the wiring's own."""

    def steering(self, parameters: TrackingParameters, outline: Outline) -> Steering:
        """By blocks, and with numbers of its own."""
        return FreeSpaceBlock(outline)

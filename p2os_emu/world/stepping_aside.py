"""Where somebody steps whom a robot asks by a sound to let it pass.

They know the floor, and the place and size of the robot. It asks those in its way, so its way is taken to lead ahead
if it faces them, and otherwise to where they stand. They step to where it can pass them by a small detour, without
walking far for that.
"""

from math import atan2, cos, dist, inf, pi, sin
from typing import NamedTuple

import numpy as np

from geometry import Point, Pose2D, wrap_angle
from p2os_emu.world.free_space import Bools, Floats, FreeSpace
from p2os_emu.world.people import BODY_RADIUS

HEARING = 3.0
"""m within which people mind a sound."""
ASKED = 0.42 * pi
"""rad off its heading within which a robot means somebody."""
FACED = 0.6
"""rad off its heading within which a robot faces somebody."""
BERTH = 0.25
"""m between a person and a robot that passes; robots keep as far from where a body may be."""
MORE_BERTH = 0.35
"""m more for a robot that asks again, twice at most: its sensors may not tell how far aside somebody is."""
WALL_BERTH = 0.05
"""m between a wall and a robot that passes."""
NEARER = 0.2
"""m by which they come nearer to the robot to step aside, at most."""
WAY_WIDTH = 0.45
"""m beside its line, within which the robot finds its way although the line itself is barred."""
DETOUR = 2.0
"""m that they rather step for a metre that the robot has to leave its way."""
_DIRECTIONS = np.arange(16) * (pi / 8)
_CIRCLE = np.stack((np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)), axis=1)
_STEPS = np.concatenate([np.zeros((1, 2)), *(length * _CIRCLE for length in np.arange(0.2, 1.61, 0.2))])
_ACROSS = np.arange(-1.8, 1.81, 0.1)  # m beside its way at which the robot may pass


class Asker(NamedTuple):
    """A robot that sounds: where it is, and how wide and how far from there to its corners, m."""

    pose: Pose2D
    width: float
    reach: float

    def means(self, place: Point) -> bool:
        """Return whether somebody at a place has to feel asked."""
        return dist(place, (self.pose.x, self.pose.y)) <= HEARING and abs(self.bearing(place)) <= ASKED

    def bearing(self, place: Point) -> float:
        """Return the direction to a place, rad off its heading."""
        return wrap_angle(atan2(place[1] - self.pose.y, place[0] - self.pose.x) - self.pose.heading)

    def way(self, place: Point) -> Pose2D:
        """Return where it is and seems to go, for somebody at a place."""
        bearing = self.bearing(place)
        return self.pose if abs(bearing) <= FACED else self.pose.compose(Pose2D(0.0, 0.0, bearing))


def place_aside(
    place: Point, route: Point, asker: Asker, walking: FreeSpace, passing: FreeSpace, berth: float = BERTH
) -> Point | None:
    """Return where somebody goes straight to let a robot pass, m; None where there is no such place near.

    Args:
        place: Where they are, m; this is returned if they are out of its way.
        route: Where they go straight afterwards.
        asker: The robot.
        walking: Free space for a person.
        passing: Free space for a disc that is `WALL_BERTH` wider than half the robot.
        berth: Between them and the robot when it passes, m.
    """
    way = asker.way(place)
    robot, ahead = np.array((way.x, way.y)), np.array((cos(way.heading), sin(way.heading)))
    beside = np.array((-ahead[1], ahead[0]))
    steps = _steps(place, route, walking)
    good = (steps @ ahead >= -NEARER) & (np.hypot(*(place + steps - robot).T) >= asker.reach + BODY_RADIUS)
    good[0] = True  # they stay where they are
    steps = steps[good]
    ends = place + steps
    middles = robot + ((ends - robot) @ ahead)[:, np.newaxis] * ahead
    passed = middles[:, np.newaxis] + _ACROSS[:, np.newaxis] * beside
    can_pass = _reached(passing.are_free(passed.reshape(-1, 2)).reshape(passed.shape[:2]))
    can_pass &= abs(_ACROSS - ((ends - robot) @ beside)[:, np.newaxis]) >= asker.width / 2.0 + BODY_RADIUS + berth
    detours = np.where(can_pass, abs(_ACROSS), inf).min(axis=1)
    costs = np.hypot(*steps.T) + DETOUR * detours
    if not np.isfinite(costs).any():
        return None
    x, y = ends[costs.argmin()]
    return float(x), float(y)


def place_away(place: Point, route: Point, asker: Asker, walking: FreeSpace) -> Point:
    """Return where somebody goes straight to be as far from a robot as possible, m: back, as it were.

    Args:
        place: Where they are, m; this is returned if they cannot go farther away.
        route: Where they go straight afterwards.
        asker: The robot.
        walking: Free space for a person.
    """
    ends = place + _steps(place, route, walking)
    x, y = ends[np.hypot(*(ends - (asker.pose.x, asker.pose.y)).T).argmax()]
    return float(x), float(y)


def _steps(place: Point, route: Point, walking: FreeSpace) -> Floats:
    """Return the steps that somebody can take, and go straight to their route afterwards; the first one is none."""
    ends = place + _STEPS
    can_go = walking.reachable(place, ends) & walking.reachable(route, ends)
    can_go[0] = True
    return np.asarray(_STEPS[can_go])


def _reached(free: Bools) -> Bools:
    """Of the places across the way, leave those that are free and not behind what bars the others on their side."""
    bars = ~free & (abs(_ACROSS) > WAY_WIDTH)
    half = len(_ACROSS) // 2
    left = np.cumsum(bars[:, half::-1], axis=1)[:, ::-1]
    right = np.cumsum(bars[:, half:], axis=1)
    reached: Bools = free & (np.concatenate((left, right[:, 1:]), axis=1) == 0)
    return reached

"""What a robot does that has lost its place on the map: it stops, and drives about until the localization knows it.

The localization needs readings from other places. So the robot drives from one free place to another, by its sensors
alone and at half speed: the map is of no use while it is not known where the robot is on it.
"""

from math import hypot, pi

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import PASSED
from apps.indoor_navigation.algorithms.planning.orders import REST, Order
from apps.indoor_navigation.algorithms.planning.search import MAX_ASIDE_COST, NO_WAY, costs_to
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import MissionEvent
from apps.indoor_navigation.data import GoalPoint, Place

STAND = 1.5  # s for which the robot stands before it drives about
FARTHEST = 4.0  # m of the way to the next place, at most
NEAREST = 0.8  # m; where no place is so far away, the robot turns round to see more
TOLERANCE = 0.4  # m from a place where it counts as reached


class Recovering:
    """Returns an order while the robot stands, or None where another state has followed."""

    def __init__(self, situation: Situation) -> None:
        self._situation = situation
        self._memory = situation.memory

    def seek(self, now: float) -> Order | None:
        """Choose the next place to drive to, until the mission's time for that is over."""
        situation = self._situation
        seeking = situation.seeking
        assert seeking is not None  # it is lost
        if now - seeking.since > situation.parameters.seek:
            situation.seeking = None
            situation.give_up(
                now,
                f"the robot did not find its place on the map within {situation.parameters.seek:.0f} s: {seeking.why}; "
                "give the localization its pose",
            )
            return None
        if now - seeking.since < STAND:
            return REST
        place, heading = self._next(seeking.places)
        seeking.places.append(place)
        situation.set_goal(GoalPoint(situation.goal.mission, *place, heading, TOLERANCE))
        situation.machine.happens(MissionEvent.SEEKS, now, "drives on to find its place on the map")
        return None

    def _next(self, before: list[Place]) -> tuple[Place, float | None]:
        """Return a free place that is far from the robot and from those before, and the heading there; None for any."""
        ground, robot = self._memory.survey_flat(), self._memory.place
        area = ground.area
        ways = costs_to(ground, robot, 0.0)
        rows, columns = np.nonzero((area.evidence <= PASSED) & (ground.cost <= MAX_ASIDE_COST) & (ways < NO_WAY))
        x, y = area.x + (columns + 0.5) * area.resolution, area.y + (rows + 0.5) * area.resolution
        away = np.minimum(np.hypot(x - robot[0], y - robot[1]), FARTHEST)
        for place in before[-2:]:
            away = away + 0.5 * np.minimum(np.hypot(x - place[0], y - place[1]), FARTHEST)
        if len(away):
            best = int(away.argmax())
            place = float(x[best]), float(y[best])
            if hypot(place[0] - robot[0], place[1] - robot[1]) >= NEAREST:
                return place, None
        assert self._memory.pose is not None  # it has seen something, or it would wait for that
        return robot, self._memory.pose[2] + 0.9 * pi

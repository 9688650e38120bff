"""A place aside: where the robot is in nobody's way who wants to come from where it is going, or from where it was."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import PASSED
from apps.indoor_navigation.algorithms.planning.search import Way, costs_to, find_way
from apps.indoor_navigation.algorithms.planning.terrain import Strip, Terrain, covered
from apps.indoor_navigation.data import Place

ROOM = 0.5  # m beside the robot that somebody needs who passes
VIEW = 1.1  # m that somebody looks ahead who does not want to bump into the robot
EASY = 3.0  # cost of a metre where the robot stands well
FARTHEST = 5.0  # cost of the way


def way_aside(
    ground: Terrain, robot: Place, ways: Sequence[Way], barred: Place | None, half_width: float
) -> Way | None:
    """The cheapest way to known floor beside other ways, and away from where they are barred; None if none is near.

    half_width: of the robot, m.
    """
    strips = [Strip(*piece, half_width + ROOM) for way in ways for piece in pairwise(way)]
    strips += [Strip(barred, barred, half_width + VIEW)] if barred is not None else []
    is_place = (ground.area.evidence <= PASSED) & (ground.cost <= EASY) & ~covered(ground.area, strips)
    costs = np.where(is_place, costs_to(ground, robot, 0.0), np.inf)
    row, column = np.unravel_index(int(costs.argmin()), costs.shape)
    if not costs[row, column] * ground.area.resolution <= FARTHEST:
        return None
    return find_way(ground, robot, ground.area.place(int(row), int(column)), 0.0)

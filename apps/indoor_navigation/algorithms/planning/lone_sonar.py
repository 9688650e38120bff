"""What sonar shows where no laser looks: which cells are free, and where echoes come from.

A disc measures the nearest object somewhere in a wide cone. If each echo were on the axis of its disc, the frame of a
door would be an arc across the door, and a robot that has sonar only would find hardly any door open. So an echo comes
from an obstacle that is known at this distance in the cone. Only without one there is a new obstacle on the axis,
unless another disc hears that the place is free. The cone is free before the echo. What is known to be an obstacle
stays until the axis of a disc passes it from a similar direction as that from which it was heard: from another one a
smooth surface reflects the sound elsewhere, and beside the axis what is thin is missed.

Source: the cone and its free part are those of Moravec and Elfes, "High resolution maps from wide angle sonar", 1985.
"""

from math import cos
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import OCCUPIED, Area
from apps.indoor_navigation.algorithms.planning.believed_rays import NARROW_CONE, SIMILAR, BelievedRays
from apps.indoor_navigation.data import Floats, Ints

ASIDE = (0.07, -0.07, 0.14, -0.14)  # rad from the axis of lines in the cone that are free; at most 7 cm apart at 1 m
FREE_BEFORE = 0.1  # m before an echo up to which these lines are free
SAME_RANGE = 0.1  # m between the distances of an echo and of the obstacle that it comes from


class HeardPlaces(NamedTuple):
    """Where echoes come from.

    x, y: in odom, m. directions: from there to the discs, rad.
    """

    x: Floats
    y: Floats
    directions: Floats


def free_cells(part: Area, sonar: BelievedRays) -> Ints:
    """Return the numbers of the cells of a part of the area that sonar shows to be free."""
    evidence, heard_from = part.evidence.reshape(-1), part.heard_from.reshape(-1)
    cells, of = sonar.passed_by(part)
    # What the laser has seen was heard from nowhere: a disc passes it from any direction.
    is_elsewhere = np.cos(sonar.to_origins[of] - heard_from[cells]) <= cos(SIMILAR)
    free = [cells[(evidence[cells] < OCCUPIED) | ~is_elsewhere]]
    for angle in ASIDE:
        cells = sonar.turned(angle, FREE_BEFORE).passed(part)
        free.append(cells[evidence[cells] < OCCUPIED])
    return np.concatenate(free)


def echoes(part: Area, sonar: BelievedRays) -> HeardPlaces:
    """Return where the echoes of sonar come from."""
    hits = sonar.chosen(sonar.hits)
    heard = hits.chosen(~sonar.are_silent(hits.end_x, hits.end_y, hits.to_origins))
    rows, columns = np.nonzero(part.evidence >= OCCUPIED)
    if not len(heard.lengths) or not len(rows):
        return HeardPlaces(heard.end_x, heard.end_y, heard.to_origins)
    x = np.asarray(part.x + (columns + 0.5) * part.resolution + part.surface_x[rows, columns], np.float64)
    y = np.asarray(part.y + (rows + 0.5) * part.resolution + part.surface_y[rows, columns], np.float64)
    along = heard.along_echoes(x, y, NARROW_CONE, SAME_RANGE)
    nearest_axis, is_known = along.argmax(axis=1), np.isfinite(along).any(axis=1)
    return HeardPlaces(
        np.where(is_known, x[nearest_axis], heard.end_x),
        np.where(is_known, y[nearest_axis], heard.end_y),
        heard.to_origins,
    )

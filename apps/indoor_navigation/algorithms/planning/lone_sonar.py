"""What sonar shows where no laser looks: which cells are free, where echoes come from, and what may be a person.

A disc measures the nearest object somewhere in a wide cone. If each echo were on the axis of its disc, the frame of a
door would be an arc across the door, and a robot that has sonar only would find hardly any door open. So an echo comes
from an obstacle that is known at this distance in the cone. Only without one there is a new obstacle on the axis,
unless another disc hears that the place is free. The cone is free before the echo. What is known to be an obstacle
stays until the axis of a disc passes it from a similar direction as that from which it was heard: from another one a
smooth surface reflects the sound elsewhere, and beside the axis what is thin is missed.

Sonar shows neither legs nor, beyond the first metre, that something moves. What a robot without laser hears for the
first time may be the end of a wall as well as somebody who walks on in a moment. It counts as somebody, for whom the
robot waits, until it has been heard at the same place for too long, or is found to be larger than a person.

Source: the cone and its free part are those of Moravec and Elfes, "High resolution maps from wide angle sonar", 1985.
"""

from math import cos
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import OCCUPIED, Area
from apps.indoor_navigation.algorithms.planning.believed_rays import NARROW_CONE, SIMILAR, BelievedRays
from apps.indoor_navigation.data import Bools, Floats, Ints

ASIDE = (0.07, -0.07, 0.14, -0.14)  # rad from the axis of lines in the cone that are free; at most 7 cm apart at 1 m
FREE_BEFORE = 0.1  # m before an echo up to which these lines are free
SAME_RANGE = 0.1  # m between the distances of an echo and of the obstacle that it comes from
LARGEST = 0.7  # m, of what may be a person, with the errors of sonar
GAP = 0.36  # m between echoes of one thing: the axes of two neighbouring discs are 0.35 m apart at 1 m


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


def may_be_people(area: Area, stamp: float, stands: float) -> Bools:
    """Return the cells of what may be people.

    Args:
        area: The floor near the robot.
        stamp: The present time, s.
        stands: s from the first echo, after which what is still heard at the same place is no person.
    """
    found = np.zeros(area.evidence.shape, bool)
    rows, columns = np.nonzero(area.evidence >= OCCUPIED)
    age = np.nan_to_num(stamp - area.first_hit[rows, columns], nan=0.0)  # below 0 where the floor was free before
    is_new = (age < stands) & ~area.fixed[rows, columns]
    x, y = (np.asarray(each * area.resolution, np.float64) for each in (columns, rows))
    left = is_new.copy()
    while left.any():
        thing = _thing_at(int(left.argmax()), x, y)
        left &= ~thing
        if is_new[thing].all() and _size(x[thing], y[thing]) <= LARGEST:
            found[rows[thing], columns[thing]] = True
    return found


def _thing_at(start: int, x: Floats, y: Floats) -> Bools:
    """Return which places are of the same thing as one of them; only some of them where it is larger than a person."""
    thing = np.zeros(len(x), bool)
    added = np.arange(len(x)) == start
    while added.any() and _size(x[thing], y[thing]) <= LARGEST:
        thing |= added
        are_near = np.hypot(x[added][:, None] - x, y[added][:, None] - y) <= GAP
        added = are_near.any(axis=0) & ~thing
    return thing


def _size(x: Floats, y: Floats) -> float:
    return float(np.hypot(np.ptp(x), np.ptp(y))) if len(x) else 0.0

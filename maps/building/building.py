"""The map of a building from key scans: an occupancy grid, lines, and points that lie on none."""

from collections.abc import Sequence

import numpy as np

from geometry import Cairn, Pose2D
from maps.building.evidence import Evidence, EvidenceGatherer
from maps.building.laser_builder import KeyScan
from maps.building.lines import fitted, thinned
from maps.building.readings import moved, turned
from maps.building.surfaces import joined
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid

RESOLUTION = 0.05
"""m, of the grid."""
HOME = "RobotHome"


def grid_of_evidence(evidence: Evidence) -> OccupancyGrid:
    """Return hits and passes as a grid."""
    return OccupancyGrid(evidence.occupancy(), evidence.resolution, Pose2D(*evidence.low, 0.0))


def evidence_of(keys: Sequence[KeyScan], gatherer: EvidenceGatherer) -> Evidence:
    """Count hits and passes of key scans; the gatherer remembers those that it has counted.

    Raises:
        ValueError: There is none.
    """
    return gatherer.gathered([(key.pose, key.view) for key in keys])


def map_of(
    keys: Sequence[KeyScan],
    base: BuildingMap | None = None,
    gatherer: EvidenceGatherer | None = None,
    *,
    with_lines: bool = True,
) -> BuildingMap:
    """Make a map of key scans; what people and other moving bodies have left is not in it.

    Args:
        keys: At least one.
        base: The map that they extend: what they have not seen anew stays, what they have seen through goes.
        gatherer: That has counted earlier scans of these.
        with_lines: Not for sonar, whose echoes are no lines: points are the middles of occupied cells.
    Raises:
        ValueError: There is no key scan.
    """
    evidence = evidence_of(keys, gatherer or EvidenceGatherer(RESOLUTION))
    home = Cairn(HOME, keys[0].pose, "")
    grid = grid_of_evidence(evidence)
    if not with_lines:
        made = BuildingMap((), grid.centres(grid.is_occupied()), grid, (home,))
        return made if base is None else joined(base, made, evidence.resolution)
    points = np.concatenate([moved(key.view.points, key.pose) for key in keys])
    normals = np.concatenate([turned(key.normals, key.pose.heading) for key in keys])
    standing = evidence.standing(points)
    points, normals = points[standing], normals[standing]
    lines, apart = fitted(points, normals)
    left, _, _ = thinned(points[apart], normals[apart]) if apart.any() else (np.empty((0, 2)), None, None)
    made = BuildingMap(tuple(lines), left, grid, (home,))
    return made if base is None else joined(base, made, evidence.resolution)

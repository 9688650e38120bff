"""What a finished map says of surfaces: points on them with normals, and the map after new ones were seen.

So a map can be matched with scans, extended by them, or joined with the map of another robot.
"""

from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from geometry import Cairn, Pose2D, Segment, wrap_angle
from maps.building.lines import fitted, thinned
from maps.building.readings import Floats, moved, turned
from maps.building_map import BuildingMap
from maps.occupancy import UNKNOWN, OccupancyGrid
from maps.rasterization import grid_of, points_along

STEP = 0.03
"""m from one point on a line to the next."""
TOGETHER = 0.08
"""m within which points of two maps are of one surface, and face one way."""
SAME_PLACE, SAME_TURN = 0.3, 0.3
"""m and rad within which places of two maps are one; more than the errors of a placement."""


def surface_points(map_: BuildingMap) -> tuple[Floats, Floats]:
    """Return points on all surfaces of a map, m, and their normals, shape (n, 2).

    The normals of lines are to their left, and those of a map that is a grid alone towards free cells. A map of another
    program may have them the other way round. Points that lie on no line have none: NaN.
    """
    points = [points_along([line], STEP) for line in map_.lines]
    normals = []
    for line, own in zip(map_.lines, points, strict=True):
        length = max(line.length, 1e-9)
        normals.append(np.tile([-(line.y2 - line.y1) / length, (line.x2 - line.x1) / length], (len(own), 1)))
    points.append(map_.points)
    normals.append(_normals_of_scattered(map_.points))
    if map_.grid is not None and not map_.lines and not len(map_.points):
        cells, facing = _grid_surfaces(map_.grid)
        points.append(cells)
        normals.append(facing)
    return np.concatenate(points).reshape(-1, 2), np.concatenate(normals).reshape(-1, 2)


def map_at(map_: BuildingMap, pose: Pose2D) -> BuildingMap:
    """Return a map in the frame that its own frame has a pose in."""
    lines = np.array(map_.lines, np.float64).reshape(-1, 2, 2)
    ends = moved(lines.reshape(-1, 2), pose).reshape(-1, 4)
    grid = None if map_.grid is None else replace(map_.grid, origin=pose.compose(map_.grid.origin))
    places = tuple(_place_at(place, pose) for place in map_.places)
    return replace(
        map_,
        lines=tuple(Segment(*map(float, row)) for row in ends),
        points=moved(map_.points, pose) if len(map_.points) else map_.points,
        grid=grid,
        places=places,
    )


def joined(older: BuildingMap, newer: BuildingMap, resolution: float = 0.05) -> BuildingMap:
    """Return one map of two in one frame; where both have looked, the newer is right.

    Args:
        older: What of it the newer has seen to be free is left out.
        newer: With a grid. Its RobotHome, and places that the older has at about the same pose, are left out.
        resolution: Of the grid, m.
    """
    points, normals = surface_points(older)
    seen = newer.grid.values_at(points) if newer.grid is not None else np.full(len(points), UNKNOWN, np.int8)
    around = _wide(newer.grid) if newer.grid is not None else None
    stays = (seen == UNKNOWN) | (around.values_at(points) > 0 if around is not None else True)
    points, normals = points[stays], normals[stays]
    new_points, new_normals = surface_points(newer)
    normals = _facing_as(points, normals, new_points, new_normals)
    every, facing = np.concatenate((points, new_points)), np.concatenate((normals, new_normals))
    lines, apart = fitted(every, facing)
    left = thinned(every[apart], facing[apart])[0] if apart.any() else np.empty((0, 2))
    added = tuple(
        place
        for place in newer.places
        if place.kind != "RobotHome" and not any(_is_same_place(place, other) for other in older.places)
    )
    grid = _grids_joined(grid_of(older, resolution), grid_of(newer, resolution), resolution)
    return BuildingMap(tuple(lines), left, grid, older.places + added, older.info or newer.info)


def _place_at(place: Cairn, pose: Pose2D) -> Cairn:
    """A place in another frame. The ends of a line are moved; an area keeps its corners and is turned."""
    if place.extent is None:
        return replace(place, pose=pose.compose(place.pose))
    ends = np.array(place.extent).reshape(2, 2)
    if place.kind.endswith("Line"):
        return replace(place, extent=Segment(*map(float, moved(ends, pose).reshape(-1))))
    # Corners are given before a turn about the map's origin: turn the shift back by the new heading.
    heading = place.pose.heading + pose.heading
    shift = turned(np.array([[pose.x, pose.y]]), -heading)
    extent = Segment(*map(float, (ends + shift).reshape(-1)))
    return replace(
        place, pose=replace(place.pose, heading=Pose2D(0, 0, 0).compose(Pose2D(0, 0, heading)).heading), extent=extent
    )


def _is_same_place(one: Cairn, other: Cairn) -> bool:
    """Whether two places in one frame are one: kind and name are equal, and they nearly coincide."""
    if (one.kind, one.name) != (other.kind, other.name) or (one.extent is None) != (other.extent is None):
        return False
    if one.extent is None or other.extent is None:
        is_turned = abs(wrap_angle(one.pose.heading - other.pose.heading)) > SAME_TURN
        return not is_turned and hypot(one.pose.x - other.pose.x, one.pose.y - other.pose.y) < SAME_PLACE
    corners, others = _corners(one), _corners(other)
    away = np.hypot(*(corners[:, None] - others[None]).transpose(2, 0, 1))  # corners may be in another order
    return bool((away.min(axis=0) < SAME_PLACE).all() and (away.min(axis=1) < SAME_PLACE).all())


def _corners(place: Cairn) -> Floats:
    """Ends of a line, or all corners of an area, m, shape (n, 2)."""
    assert place.extent is not None
    x1, y1, x2, y2 = place.extent
    if place.kind.endswith("Line"):
        return np.array([(x1, y1), (x2, y2)])
    return turned(np.array([(x1, y1), (x2, y1), (x2, y2), (x1, y2)]), place.pose.heading)


def _normals_of_scattered(points: Floats) -> Floats:
    return np.full(points.shape, np.nan)


def _grid_surfaces(grid: OccupancyGrid) -> tuple[Floats, Floats]:
    """Occupied cells beside free ones, and the directions of these."""
    occupied, free = grid.is_occupied(), (grid.cells >= 0) & (grid.cells < 50)
    padded = np.pad(free, 2)
    rows, columns = occupied.shape
    x, y = np.zeros(occupied.shape), np.zeros(occupied.shape)
    for dy in range(-2, 3):
        for dx in range(-2, 3):
            beside = padded[2 + dy : 2 + dy + rows, 2 + dx : 2 + dx + columns]
            x += dx * beside
            y += dy * beside
    length = np.hypot(x, y)
    chosen = occupied & (length > 0.5)
    facing = np.stack((x[chosen], y[chosen]), axis=1) / length[chosen][:, None]
    return grid.centres(chosen), turned(facing, grid.origin.heading)


def _wide(grid: OccupancyGrid) -> OccupancyGrid:
    """The same with every occupied cell one cell wider, and all else 0."""
    wide = grid.cells >= 50
    solid = wide.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            wide |= np.roll(solid, step, axis)
    return replace(grid, cells=np.where(wide, 100, 0).astype(np.int8))


def _facing_as(points: Floats, normals: Floats, others: Floats, theirs: Floats) -> Floats:
    """Turn normals round where another map has seen the surface from the other side only."""
    from maps.building.scan_matching import SurfaceField

    known = np.isfinite(theirs[:, 0])
    if not known.any() or not len(points):
        return normals
    field = SurfaceField(others[known], theirs[known])
    found = field.nearest(points)
    near = (found >= 0) & (np.hypot(*(field.points[found] - points).T) < TOGETHER)
    against = near & ((field.normals[found] * np.nan_to_num(normals)).sum(axis=1) < 0.0)
    return np.where(against[:, None], -normals, normals)


def _grids_joined(older: OccupancyGrid, newer: OccupancyGrid, resolution: float) -> OccupancyGrid:
    """Cells of the newer grid, and where it has not looked, of the older one."""
    corners = np.array(
        [grid.origin.transform(x, y) for grid in (older, newer) for x in (0.0, grid.width) for y in (0.0, grid.height)]
    )
    low = np.floor(corners.min(axis=0) / resolution + 1e-6) * resolution
    columns, rows = np.ceil((corners.max(axis=0) - low) / resolution - 1e-6).astype(np.int64)
    empty = OccupancyGrid(np.zeros((int(rows), int(columns)), np.int8), resolution, Pose2D(*map(float, low)))
    centres = empty.centres(np.ones(empty.cells.shape, np.bool_))
    new, old = newer.values_at(centres), older.values_at(centres)
    cells: NDArray[np.int8] = np.where(new != UNKNOWN, new, old).reshape(empty.cells.shape)
    return replace(empty, cells=cells)

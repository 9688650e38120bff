"""How a map compares with the world that it shows."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry import Polygon, Pose2D, Segment, polygon_edges
from maps.building.laser_builder import KeyScan
from maps.building.readings import Floats, moved, turned
from maps.building.scan_matching import SurfaceField
from maps.building.surfaces import surface_points
from maps.building_map import BuildingMap
from maps.rasterization import points_along
from p2os_emu.world import WorldSpec

EXACT = 0.04  # m within which a wall is where it is
DOUBLE = 0.3  # m from a wall within which a second line that faces the same way doubles it
STEP = 0.03  # m between samples


@dataclass(frozen=True, slots=True)
class MapScore:
    """A map in figures.

    exact: share of the walls of the map within 4 cm of true ones. complete: share of the true walls seen that are in
    the map, within 4 cm. double: m of lines beside a wall that is there already. off: greatest error of a pose of a key
    scan, m. placed: the map's frame in the world.
    """

    exact: float
    complete: float
    double: float
    off: float
    placed: Pose2D


def true_edges(world: WorldSpec, standing: Sequence[Polygon], height: float) -> list[Segment]:
    """Edges of all that a scanner at some height can see."""
    blocks = [each for each in (*world.walls, *world.furniture) if each.bottom <= height <= each.top and not each.glass]
    outlines = [each.footprint for each in blocks] + list(standing)
    return [edge for outline in outlines for edge in polygon_edges(outline)]


def score(made: BuildingMap, keys: Sequence[KeyScan], truth: Sequence[Pose2D], edges: Sequence[Segment]) -> MapScore:
    """Judge a map.

    Args:
        made: The map.
        keys: That it was made of. truth: true poses of these.
        edges: Of the world.
    """
    walls = points_along(edges, STEP)
    normals = np.concatenate([_normals(edge, len(points_along([edge], STEP))) for edge in edges])
    field = SurfaceField(walls, normals, one_sided=False)
    points, facing = surface_points(BuildingMap(made.lines, made.points))
    guess = truth[0].compose(Pose2D().relative_to(keys[0].pose))
    match = field.align(points, facing, guess, coarsest=0.1)
    placed = guess if match is None else match.pose
    points, facing = moved(points, placed), turned(facing, placed.heading)
    away = _distances(field, points)
    return MapScore(
        float(np.mean(away <= EXACT)),
        _complete(walls, normals, points, keys, truth),
        _doubled(points, facing, away),
        max(_apart(placed.compose(key.pose), pose) for key, pose in zip(keys, truth, strict=True)),
        placed,
    )


def _normals(edge: Segment, count: int) -> Floats:
    length = max(edge.length, 1e-9)
    return np.tile([-(edge.y2 - edge.y1) / length, (edge.x2 - edge.x1) / length], (count, 1))


def _distances(field: SurfaceField, points: Floats) -> Floats:
    """From points to the nearest walls, m; large where none is near."""
    found = field.nearest(points)
    offsets = points - field.points[found]
    along = np.abs((offsets * np.stack((field.normals[found][:, 1], -field.normals[found][:, 0]), axis=1)).sum(axis=1))
    across = np.abs((offsets * field.normals[found]).sum(axis=1))
    away: Floats = np.where(found >= 0, np.hypot(across, np.maximum(0.0, along - STEP)), np.inf)
    return away


def _complete(
    walls: Floats, normals: Floats, points: Floats, keys: Sequence[KeyScan], truth: Sequence[Pose2D]
) -> float:
    """Share of the true walls that were seen, by true poses, near which the map has something."""
    field = SurfaceField(walls, normals, one_sided=False)
    seen = np.zeros(len(walls), np.int64)
    for key, pose in zip(keys, truth, strict=True):
        at = moved(key.view.points, pose)
        found = field.nearest(at)
        near = (found >= 0) & (np.hypot(*(field.points[found] - at).T) < 0.05)
        np.add.at(seen, np.unique(found[near]), 1)
    drawn = SurfaceField(points, np.tile([1.0, 0.0], (len(points), 1)), one_sided=False)
    known = walls[seen >= 2]
    found = drawn.nearest(known)
    near = (found >= 0) & (np.hypot(*(drawn.points[found] - known).T) < EXACT + STEP)
    return float(near.mean())


def _doubled(points: Floats, facing: Floats, away: Floats) -> float:
    """Metres of lines off the walls beside which a line that faces the same way is on a wall."""
    right = (away <= EXACT) & np.isfinite(facing[:, 0])
    wrong = np.flatnonzero((away > 1.5 * EXACT) & np.isfinite(facing[:, 0]))
    if not right.any() or not len(wrong):
        return 0.0
    field = SurfaceField(points[right], facing[right])
    found = field.nearest(points[wrong])
    offsets = points[wrong] - field.points[found]
    across = np.abs((offsets * field.normals[found]).sum(axis=1))
    alike = (field.normals[found] * facing[wrong]).sum(axis=1) > 0.9
    return STEP * float(np.count_nonzero((found >= 0) & alike & (across < DOUBLE) & (across > 1.5 * EXACT)))


def _apart(pose: Pose2D, other: Pose2D) -> float:
    return float(np.hypot(pose.x - other.x, pose.y - other.y))

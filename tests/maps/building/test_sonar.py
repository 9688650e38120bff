"""Maps of sonar alone: rooms are free, walls are where they are, and what no disc heard stays unknown."""

from functools import cache
from math import inf

import numpy as np

from geometry import Pose2D, Segment
from maps.building.building import grid_of_evidence, map_of
from maps.building.evidence import EvidenceGatherer
from maps.building.laser_builder import LaserMapBuilder
from maps.building.readings import Mount, OdometryTrack
from maps.building.sonar import MATCHING, DiscReading, SonarViews, echo_normals
from maps.occupancy import OccupancyGrid
from tests.maps.building.drawn_rooms import poses_along, room

BEARINGS = np.radians(range(-90, 270, 24))
DISCS = {number: Mount(0.15 * np.cos(a), 0.15 * np.sin(a), a) for number, a in enumerate(BEARINGS)}
CONE = np.radians(np.linspace(-12.0, 12.0, 9))
WALLS = room(0.0, 0.0, 5.0, 4.0)


def heard(pose: Pose2D) -> float:
    """The nearest surface in the cone of a disc that it meets at no more than 30 degrees; infinite without one."""
    ranges = []
    for bearing in CONE:
        direction = pose.heading + bearing
        hit, wall = min((wall.hit_by(pose.x, pose.y, direction), wall) for wall in WALLS)
        if abs(_facing(wall, direction)) > 0.86:
            ranges.append(hit)
    return min(ranges, default=inf)


def _facing(wall: Segment, direction: float) -> float:
    return float(((wall.y2 - wall.y1) * np.cos(direction) - (wall.x2 - wall.x1) * np.sin(direction)) / wall.length)


@cache
def built() -> tuple[LaserMapBuilder, OccupancyGrid]:
    views, track = SonarViews(DISCS), OdometryTrack()
    builder = LaserMapBuilder(MATCHING, Pose2D(1.0, 1.0), normals_of=echo_normals)
    way = ((1.0, 1.0), (4.0, 1.0), (4.0, 3.0), (1.0, 3.0), (1.0, 1.0), (4.0, 1.0))
    rng = np.random.default_rng(1)
    for number, pose in enumerate(poses_along(way, 0.1)):
        track.add(0.2 * number, pose.relative_to(Pose2D(1.0, 1.0)))
        for disc, mount in DISCS.items():
            length = heard(pose.compose(Pose2D(*mount))) + rng.normal(0.0, 0.01)
            view = views.add(DiscReading(0.2 * number, disc, length), track)
            if view is not None:
                builder.add(view)
    return builder, grid_of_evidence(EvidenceGatherer(0.05).gathered([(key.pose, key.view) for key in builder.keys]))


def test_the_floor_of_a_room_is_free() -> None:
    _, grid = built()
    x, y = np.meshgrid(np.arange(0.8, 4.3, 0.2), np.arange(0.8, 3.3, 0.2))
    values = grid.values_at(np.stack((x.reshape(-1), y.reshape(-1)), axis=1))
    assert np.mean((values >= 0) & (values < 30)) > 0.95


def test_occupied_cells_lie_on_walls_within_the_width_of_a_cone() -> None:
    builder, _ = built()
    made = map_of(builder.keys, with_lines=False)
    away = np.array([min(wall.distance_to(*point) for wall in WALLS) for point in made.points.tolist()])
    assert len(made.points) > 60
    assert np.median(away) < 0.1, "two cells"
    assert np.max(away) < 2.5 * np.sin(CONE[-1]) + 0.05, "half a cone at the farthest echo, and a cell"
    assert made.lines == ()


def test_what_lies_beyond_the_walls_is_unknown() -> None:
    _, grid = built()
    beyond = np.array([[2.5, -0.45], [2.5, 4.45], [-0.45, 2.0], [5.45, 2.0]])
    assert (grid.values_at(beyond) == -1).all()

"""Where a robot can stand: clear of walls, furniture and other robots."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from math import hypot, inf

from geometry import Point, Polygon, Pose2D, Segment, polygon_edges, polygons_overlap
from p2os_emu.world.spec import Block

CLEARANCE = 0.1  # m that stays free round a robot that was not given a place
PITCH = 1.0  # m between the places tried round a start
RINGS = 12


class Obstacles:
    """Obstacles, prepared for many queries."""

    def __init__(self, blocks: Iterable[Block]) -> None:
        self._blocks = [(block, polygon_edges(block.footprint)) for block in blocks]

    def overlapping(self, footprint: Polygon, height: float = inf) -> str:
        """Return what a robot of some height (m) on this footprint would overlap, as text; empty where it is free."""
        x, y, reach = _circle(footprint)
        near = (
            (block.name or "a wall", block.footprint) for block, _ in self._near(x, y, reach) if block.bottom < height
        )
        return overlapping(footprint, near)

    def leave_room(self, x: float, y: float, radius: float, height: float = inf) -> bool:
        """Return whether a circle is free of blocks up to a height, m."""
        return not any(
            block.contains(x, y) or any(edge.distance_to(x, y) <= radius for edge in edges)
            for block, edges in self._near(x, y, radius)
            if block.bottom < height
        )

    def hide(self, line: Segment) -> bool:
        """Return whether a block stands between the ends of a line."""
        start = Pose2D(line.x1, line.y1)
        direction = start.bearing_to(line.x2, line.y2)
        x, y = (line.x1 + line.x2) / 2, (line.y1 + line.y2) / 2
        return any(
            edge.hit_by(line.x1, line.y1, direction) < line.length
            for _, edges in self._near(x, y, line.length / 2)
            for edge in edges
        )

    def _near(self, x: float, y: float, radius: float) -> Iterator[tuple[Block, tuple[Segment, ...]]]:
        for block, edges in self._blocks:
            if hypot(block.x - x, block.y - y) <= radius + hypot(block.length, block.width) / 2:
                yield block, edges


def overlapping(footprint: Polygon, others: Iterable[tuple[str, Polygon]]) -> str:
    """The name of the first polygon that a footprint overlaps; empty if there is none."""
    return next((name for name, other in others if polygons_overlap(footprint, other)), "")


def free_pose(
    starts: Sequence[Pose2D],
    obstacles: Obstacles,
    others: Sequence[tuple[float, float, float]],
    radius: float,
    height: float = inf,
) -> Pose2D | None:
    """Choose where a robot begins.

    Tries the starts of the world in order, then places in rings round each start and in sight of it.

    Args:
        starts: Where the world wants robots to begin.
        obstacles: What does not move.
        others: Circles that other robots need to turn: x, y, radius, m.
        radius: Of the circle that this robot needs to turn, m.
        height: Of this robot, m; it can stand below what begins higher.
    Returns:
        The first place where the robot can turn without touching anything, or None.
    """

    def is_free(pose: Pose2D) -> bool:
        apart = all(hypot(pose.x - x, pose.y - y) > radius + r + CLEARANCE for x, y, r in others)
        return apart and obstacles.leave_room(pose.x, pose.y, radius + CLEARANCE, height)

    for pose in starts:
        if is_free(pose):
            return pose
    for start in starts:
        for x, y in _rings(start):
            if is_free(place := Pose2D(x, y, start.heading)) and not obstacles.hide(Segment(start.x, start.y, x, y)):
                return place
    return None


def _rings(start: Pose2D) -> Iterator[Point]:
    """Places of a square grid round a start and turned with it, nearest first."""
    steps = range(-RINGS, RINGS + 1)
    grid = sorted(((i, j) for i in steps for j in steps), key=lambda step: (hypot(*step), step))
    return (start.transform(i * PITCH, j * PITCH) for i, j in islice(grid, 1, None))


def _circle(polygon: Polygon) -> tuple[float, float, float]:
    """Centre and radius of a circle round a rectangle."""
    x = sum(corner[0] for corner in polygon) / len(polygon)
    y = sum(corner[1] for corner in polygon) / len(polygon)
    return x, y, max(hypot(corner[0] - x, corner[1] - y) for corner in polygon)

"""Straight segments and convex polygons in the plane: distances, rays, overlap. All lengths in m."""

from collections.abc import Iterator
from math import cos, hypot, inf, sin
from typing import NamedTuple

Point = tuple[float, float]
"""x and y, m."""
Polygon = tuple[Point, ...]
"""Corners in their order along the outline, m; the last one is joined to the first."""


class Segment(NamedTuple):
    """A straight line from (x1, y1) to (x2, y2), m."""

    x1: float
    y1: float
    x2: float
    y2: float

    @property
    def length(self) -> float:
        """Distance between the ends, m."""
        return hypot(self.x2 - self.x1, self.y2 - self.y1)

    def distance_to(self, x: float, y: float) -> float:
        """Distance from the nearest point of the segment to a point, m."""
        dx, dy = self.x2 - self.x1, self.y2 - self.y1
        squared = dx * dx + dy * dy
        along = ((x - self.x1) * dx + (y - self.y1) * dy) / squared if squared else 0.0
        along = min(1.0, max(0.0, along))
        return hypot(self.x1 + along * dx - x, self.y1 + along * dy - y)

    def hit_by(self, x: float, y: float, direction: float) -> float:
        """Length of a ray from (x, y) along `direction` (rad) up to this segment, m.

        Returns `inf` where the ray misses, and where it runs along the segment.
        """
        dx, dy = self.x2 - self.x1, self.y2 - self.y1
        ray_x, ray_y = cos(direction), sin(direction)
        cross = ray_x * dy - ray_y * dx
        if cross == 0.0:
            return inf
        to_x, to_y = self.x1 - x, self.y1 - y
        range_ = (to_x * dy - to_y * dx) / cross
        along = (to_x * ray_y - to_y * ray_x) / cross
        return range_ if range_ >= 0.0 and 0.0 <= along <= 1.0 else inf


def polygon_edges(corners: Polygon) -> tuple[Segment, ...]:
    """Edges of a closed polygon, in the order of its corners."""
    following = corners[1:] + corners[:1]
    return tuple(Segment(*a, *b) for a, b in zip(corners, following, strict=True))


def polygons_overlap(first: Polygon, second: Polygon) -> bool:
    """Tell whether two convex polygons share a point; touching counts.

    Source: the separating axis theorem (two convex shapes are apart if and only if an edge of one of them parts them).
    """
    return not any(_parts(edge, first, second) for polygon in (first, second) for edge in polygon_edges(polygon))


def _parts(edge: Segment, first: Polygon, second: Polygon) -> bool:
    """Tell whether the shadows of two polygons on the normal of an edge are apart."""
    normal = edge.y1 - edge.y2, edge.x2 - edge.x1
    ours, theirs = list(_shadow(first, normal)), list(_shadow(second, normal))
    return max(ours) < min(theirs) or max(theirs) < min(ours)


def _shadow(polygon: Polygon, axis: Point) -> Iterator[float]:
    return (x * axis[0] + y * axis[1] for x, y in polygon)

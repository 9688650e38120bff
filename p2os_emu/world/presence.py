"""Footprints: outlines on the floor with bounding circles, which answer most queries."""

from collections.abc import Iterable
from math import hypot
from typing import NamedTuple

from geometry import Polygon, polygons_overlap


class Footprint(NamedTuple):
    """Something on the floor: the circle that it stands in, m, and its convex outline."""

    x: float
    y: float
    reach: float
    outline: Polygon

    def meets(self, other: "Footprint") -> bool:
        """Return whether two share a point of the floor."""
        return self.is_near(other.x, other.y, other.reach) and polygons_overlap(self.outline, other.outline)

    def is_near(self, x: float, y: float, reach: float) -> bool:
        """Return whether the circle round it reaches another circle."""
        return hypot(self.x - x, self.y - y) <= self.reach + reach

    @classmethod
    def of(cls, outline: Polygon) -> "Footprint":
        """Of an outline: the circle is about the mean of its corners."""
        x = sum(corner[0] for corner in outline) / len(outline)
        y = sum(corner[1] for corner in outline) / len(outline)
        return cls(x, y, max(hypot(corner[0] - x, corner[1] - y) for corner in outline), outline)


def is_met(area: Footprint, others: Iterable[Footprint]) -> bool:
    """Return whether any of the others is on an area."""
    return any(area.meets(other) for other in others)

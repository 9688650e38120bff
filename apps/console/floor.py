"""What is known of the floor: walls, furniture and points of a map, in the frame of the map."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

Point = tuple[float, float]
"""x and y, m."""


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """A map for drawing; lengths in m.

    name: of the map, for people; empty without one. lines: walls without thickness, each x0, y0, x1, y1. shapes and
    things: outlines of walls and of furniture. points: that a laser saw. places: named points. map_file: name of the
    map file that it is made of; empty for a world without one.
    """

    name: str = ""
    lines: Sequence[tuple[float, float, float, float]] = ()
    shapes: Sequence[Sequence[Point]] = ()
    things: Sequence[Sequence[Point]] = ()
    points: Sequence[Point] = ()
    places: Sequence[tuple[str, float, float]] = ()
    map_file: str = ""

    @property
    def is_known(self) -> bool:
        """Whether there are walls."""
        return bool(self.lines or self.shapes or self.points)

    def to_json(self) -> dict[str, Any]:
        """Return it for the browser; lengths in whole mm."""
        return {
            "name": self.name,
            "lines": [[_mm(value) for value in line] for line in self.lines],
            "shapes": [[_mm(value) for point in shape for value in point] for shape in self.shapes],
            "things": [[_mm(value) for point in thing for value in point] for thing in self.things],
            "points": [_mm(value) for point in self.points for value in point],
            "places": [[name, _mm(x), _mm(y)] for name, x, y in self.places],
        }


def _mm(length: float) -> int:
    return round(length * 1000.0)

"""Pictures of maps: grid, lines, points, named places, and robots with their paths."""

from collections.abc import Mapping, Sequence
from math import cos, sin
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from configs.extras import require
from geometry import Point, Pose2D
from maps.building_map import BuildingMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL, POINT, PLACE, FORBIDDEN = "#202428", "#7a4fa3", "#1f6f4a", "#b5382f"
ROBOTS = ("#c2571a", "#1f5f9f", "#1f6f4a", "#7a4fa3")
WIDEST = 12.0  # inches of a picture


def draw_map(
    path: Path,
    drawn: BuildingMap,
    title: str = "",
    robots: Mapping[str, Pose2D] | None = None,
    frontiers: Sequence[Point] = (),
) -> None:
    """Draw a map as PNG or SVG, by the ending of the path; an existing picture is replaced at once.

    Args:
        path: Of the picture.
        drawn: The map.
        title: Above it.
        robots: Where robots are, by their names.
        frontiers: Where known floor ends, m.
    Raises:
        ExtraMissing: matplotlib is not installed.
        ValueError: The map is empty.
        OSError: The picture cannot be written.
    """
    require("pictures of maps", "plots")
    from matplotlib.figure import Figure

    x_min, y_min, x_max, y_max = drawn.bounds
    scale = WIDEST / max(x_max - x_min, y_max - y_min, 1.0)
    page = Figure(
        figsize=(max(4.0, scale * (x_max - x_min)) + 0.8, max(3.0, scale * (y_max - y_min)) + 0.8),
        layout="constrained",
    )
    axes = page.subplots()
    _draw_grid(axes, drawn)
    for line in drawn.lines:
        axes.plot((line.x1, line.x2), (line.y1, line.y2), color=WALL, linewidth=1.2)
    if len(drawn.points):
        axes.plot(*drawn.points.T, ".", color=POINT, markersize=1.5)
    for line in drawn.forbidden_lines:
        axes.plot((line.x1, line.x2), (line.y1, line.y2), color=FORBIDDEN, linewidth=1.5, linestyle="--")
    for area in drawn.forbidden_areas:
        axes.fill(*zip(*area, strict=True), color=FORBIDDEN, alpha=0.2, linewidth=0)
    for place in drawn.places:
        if place.extent is None:
            axes.plot(place.pose.x, place.pose.y, "o", color=PLACE, markersize=5)
            axes.annotate(place.name or place.kind, (place.pose.x, place.pose.y), (4, 4), textcoords="offset points")
    for (name, pose), colour in zip((robots or {}).items(), ROBOTS * 8, strict=False):
        axes.plot(pose.x, pose.y, "o", color=colour, markersize=9)
        axes.plot((pose.x, pose.x + 0.5 * cos(pose.heading)), (pose.y, pose.y + 0.5 * sin(pose.heading)), color=colour)
        axes.annotate(name, (pose.x, pose.y), (8, -12), textcoords="offset points", color=colour)
    if frontiers:
        axes.plot(*zip(*frontiers, strict=True), "*", color="#d9a520", markersize=11)
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_title(title, loc="left", fontsize=10)
    beside = path.with_name(f".{path.name}.part{path.suffix}")
    try:
        page.savefig(beside, dpi=90)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)  # it is gone if all went well


def _draw_grid(axes: "Axes", drawn: BuildingMap) -> None:
    """Unknown grey, free white, occupied dark."""
    grid = drawn.grid
    if grid is None:
        return
    from matplotlib.transforms import Affine2D

    shade = np.where(grid.cells < 0, 0.82, 1.0 - np.clip(grid.cells, 0, 100) / 100.0)
    image = axes.imshow(
        shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=(0.0, grid.width, 0.0, grid.height)
    )
    turned = Affine2D().rotate(grid.origin.heading).translate(grid.origin.x, grid.origin.y)
    image.set_transform(turned + axes.transData)
    corners = [grid.origin.transform(x, y) for x in (0.0, grid.width) for y in (0.0, grid.height)]
    axes.set_xlim(min(x for x, _ in corners), max(x for x, _ in corners))
    axes.set_ylim(min(y for _, y in corners), max(y for _, y in corners))

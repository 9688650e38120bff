"""Plots of a drive in formation: all trajectories, and the distances from the virtual points; and its film."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from apps.film import FilmWriter, TopView, moments
from apps.formation.record import FormationRecord
from apps.pictures import save_picture
from configs.extras import require
from geometry import Polygon

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 250  # points of a curve
MOMENTS = 8  # at which the formation is drawn as a polygon
COLOURS = ("#3d4248", "#1f77b4", "#d9730d", "#2a9d4a", "#9467bd", "#c2409a", "#0f9aa8", "#8c6239")


def draw_formation(file: Path, record: FormationRecord, title: str, walls: Sequence[Polygon] = ()) -> None:
    """Draw a record as a file in the format of its ending; the same record gives the same bytes.

    Args:
        file: SVG or PNG.
        record: What happened.
        title: Above the trajectories.
        walls: Outlines of what stands there, m.
    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of a formation", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(9, 7.5), layout="constrained")
    plan, distances = page.subplots(2, 1, height_ratios=(2.2, 1))
    for wall in walls:
        plan.fill([x for x, _ in wall], [y for _, y in wall], color="#b9b4a8", linewidth=0)
    for colour, name in zip(_colours(len(record.poses)), record.poses, strict=True):
        _draw_robot(plan, distances, record, name, colour)
    _draw_moments(plan, record)
    plan.set_title(title, loc="left", fontsize=10)
    plan.set_aspect("equal", adjustable="datalim")
    plan.set_xlabel("x, m")
    plan.set_ylabel("y, m")
    plan.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    distances.set_xlabel("time, s")
    distances.set_ylabel("from its point, m")
    distances.set_ylim(bottom=0.0)
    distances.grid(visible=True, linewidth=0.3)
    save_picture(page, file)


def write_film(file: Path, record: FormationRecord) -> int:
    """Write a record as a film from above, with the virtual points; returns the number of frames.

    Raises:
        OSError: The file cannot be written.
    """
    view, writer = TopView(record.poses), FilmWriter(file)
    for moment in moments(record.times):
        points = [found for each in record.points.values() if (found := each[moment]) is not None]
        writer.add(view.draw(moment, f"{record.times[moment]:.1f} s", points))
    return writer.close()


def _draw_robot(plan: "Axes", distances: "Axes", record: FormationRecord, name: str, colour: str) -> None:
    step = max(1, len(record.times) // MOST)
    seen = [pose for pose in record.poses[name][::step] if pose]
    role = f"{name}, leader" if name == record.leader else name
    plan.plot([p.x for p in seen], [p.y for p in seen], color=colour, linewidth=1.4, label=role)
    if name in record.points:
        distances.plot(record.times[::step], record.errors(name)[::step], color=colour, linewidth=1.0)


def _draw_moments(plan: "Axes", record: FormationRecord) -> None:
    """Connect the leader with its followers at a few moments, and show where all look."""
    count = len(record.times)
    for moment in {round(number * (count - 1) / MOMENTS) for number in range(MOMENTS + 1)} if count else ():
        leader = record.poses[record.leader][moment]
        for poses in record.poses.values():
            if leader and (pose := poses[moment]):
                plan.plot([leader.x, pose.x], [leader.y, pose.y], color="#9aa0a6", linewidth=0.6, zorder=1)
                tip = pose.x + 0.25 * math.cos(pose.heading), pose.y + 0.25 * math.sin(pose.heading)
                plan.plot([pose.x, tip[0]], [pose.y, tip[1]], color="black", linewidth=1.6, zorder=3)


def _colours(count: int) -> list[str]:
    return [COLOURS[number % len(COLOURS)] for number in range(count)]

"""Plots of a drive by optical flow: the path with its situations, and the time to contact."""

from collections.abc import Sequence
from pathlib import Path

from apps.optical_flow.record import FlowRecord
from apps.optical_flow.situation import FlowSituation
from apps.pictures import save_picture
from configs.extras import require
from geometry import Polygon

MOST = 400  # points of a curve
LONGEST = 12.0  # s of time to contact that are shown
COLOURS = {
    FlowSituation.FREE: "#2a9d4a",
    FlowSituation.UNKNOWN: "#9aa0a6",
    FlowSituation.LEFT: "#1f77b4",
    FlowSituation.RIGHT: "#0f9aa8",
    FlowSituation.FRONT: "#d9a30d",
    FlowSituation.NEAR: "#d9530d",
    FlowSituation.CORNER: "#b5382f",
    FlowSituation.BLIND: "#3d4248",
    FlowSituation.CONTACT: "#c2409a",
}


def draw_wandering(file: Path, record: FlowRecord, title: str, walls: Sequence[Polygon] = ()) -> None:
    """Draw a record as a file in the format of its ending; the same record gives the same bytes.

    Args:
        file: SVG or PNG.
        record: What happened.
        title: Above the path.
        walls: Outlines of what stands there, m.
    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of a drive", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(8, 8), layout="constrained")
    plan, graph = page.subplots(2, 1, height_ratios=(2.6, 1))
    for wall in walls:
        plan.fill([x for x, _ in wall], [y for _, y in wall], color="#b9b4a8", linewidth=0)
    step = max(1, len(record.times) // MOST)
    times, poses = record.times[::step], record.poses[::step]
    plan.plot([pose.x for pose in poses], [pose.y for pose in poses], color="#c9ccd1", linewidth=0.8, zorder=1)
    for situation, colour in COLOURS.items():
        own = [number for number, each in enumerate(record.situations[::step]) if each is situation]
        if own:
            xs, ys = [poses[number].x for number in own], [poses[number].y for number in own]
            plan.scatter(xs, ys, s=3.0, color=colour, linewidths=0, label=situation.value, zorder=2)
            shown = [min(record.contacts[::step][number], LONGEST) for number in own]
            graph.scatter([times[number] for number in own], shown, s=3.0, color=colour, linewidths=0)
    if poses:
        plan.plot([poses[0].x], [poses[0].y], "k^", markersize=6, label="start")
    plan.set_title(title, loc="left", fontsize=10)
    plan.set_aspect("equal", adjustable="datalim")
    plan.set_xlabel("x, m")
    plan.set_ylabel("y, m")
    plan.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, markerscale=3.0)
    graph.set_xlabel("time, s")
    graph.set_ylabel("least time to contact, s")
    graph.set_ylim(0.0, LONGEST)
    graph.grid(visible=True, linewidth=0.3)
    save_picture(page, file)

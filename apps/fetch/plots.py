"""The plot of a drive to fetch an object."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from apps.fetch.record import FetchRecord
from apps.fetch.states import FetchState
from apps.pictures import save_picture
from configs.extras import require
from geometry import Point, Polygon

_PARTS = {  # of the path: name and colour
    "search": ("#8a8f98", (FetchState.SEARCH, FetchState.WANDER)),
    "approach and grip": (
        "#1f77b4",
        (FetchState.APPROACH, FetchState.ALIGN, FetchState.ADVANCE, FetchState.GRIP, FetchState.LIFT, FetchState.RETRY),
    ),
    "carry and put down": (
        "#d9730d",
        (
            FetchState.CARRY,
            FetchState.TURN_BACK,
            FetchState.DELIVER,
            FetchState.LOWER,
            FetchState.RELEASE,
            FetchState.BACK_OFF,
        ),
    ),
}


def draw_fetching(
    file: Path, record: FetchRecord, title: str, walls: Sequence[Polygon] = (), others: Sequence[Point] = ()
) -> None:
    """Draw a record as a file in the format of its ending.

    Args:
        file: SVG or PNG.
        record: The drive.
        title: Above it.
        walls: Outlines of what stands there, in the frame of the record, m.
        others: Objects that are not to be fetched, likewise.
    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of fetching", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(7.5, 6.5), layout="constrained")
    axes = page.subplots()
    for wall in walls:
        axes.fill([x for x, _ in wall], [y for _, y in wall], color="#b9b4a8", linewidth=0)
    for name, (ink, states) in _PARTS.items():
        label: str | None = name
        for begin, end in _runs(record, states):
            poses = record.poses[begin : end + 1]
            axes.plot([each.x for each in poses], [each.y for each in poses], color=ink, linewidth=1.5, label=label)
            label = None
    if record.poses:
        axes.plot(record.poses[0].x, record.poses[0].y, "o", color="#3d4248", label="start")
    if record.gripped_at is not None:
        axes.plot(*record.gripped_at, "s", color=record.colour, markersize=9, label="object")
    axes.plot(*record.place, "x", color="#b5382f", markersize=10, markeredgewidth=2.5, label="place")
    if others:
        axes.plot([x for x, _ in others], [y for _, y in others], "s", color="#6b7078", markersize=6, label="others")
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(frameon=False)
    save_picture(page, file)


def _runs(record: FetchRecord, states: Sequence[FetchState]) -> list[tuple[int, int]]:
    """Return first and last entry of each run of entries in some states."""
    is_in = [state in states for state in record.states]
    edges = [0, *(number for number, (a, b) in enumerate(pairwise(is_in), 1) if a != b), len(is_in)]
    return [(begin, min(end, len(is_in) - 1)) for begin, end in pairwise(edges) if begin < end and is_in[begin]]

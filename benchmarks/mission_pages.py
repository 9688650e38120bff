"""Pages of many missions: true paths over the plan, panel by panel."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.matrix import Result
from acromovi.missions.picture import BAD, GOOD, OBSTACLE, PERSON, THING, WALL, draw_world

BAR = 2.0  # m, of the scale below panels without axes


def draw_sheet(path: Path, results: Sequence[Result[Job]], world: str) -> None:
    """Draw all missions in one world, a panel for each case and condition."""
    page = Figure(figsize=(22, 12), layout="constrained")
    panels = page.subplots(len(Case), len(Condition), squeeze=False)
    for row, case in zip(panels, Case, strict=True):
        for axes, condition in zip(row, Condition, strict=True):
            here = [r for r in results if (r.job.case, r.job.condition, r.job.world) == (case, condition, world)]
            for number, result in enumerate(here):
                _draw_path(axes, result, is_first=number == 0)
            good = sum(result.is_good for result in here)
            axes.set_title(f"{case}, {condition}: {good} of {len(here)}", loc="left", fontsize=10)
            axes.set_axis_off()
    page.suptitle(f"World '{world}': true paths; a bar is {BAR:g} m", x=0.01, ha="left")
    _explain(page)
    page.savefig(path, dpi=70)


def draw_grid(path: Path, results: Sequence[Result[Job]]) -> None:
    """Draw missions one beside the other, each in its own world."""
    columns = 6
    rows = max(1, -(-len(results) // columns))
    page = Figure(figsize=(24, 3.4 * rows), layout="constrained")
    panels = list(page.subplots(rows, columns, squeeze=False).flat)
    for axes in panels:
        axes.set_axis_off()
    for axes, result in zip(panels, results, strict=False):
        _draw_path(axes, result)
        job = result.job
        axes.set_title(f"{job.case}, {job.condition}, {job.seed}: {job.robot}", loc="left", fontsize=8)
    page.suptitle(f"True paths, each in a world of its own; a bar is {BAR:g} m", x=0.01, ha="left")
    _explain(page)
    page.savefig(path, dpi=60)


def _explain(page: Figure) -> None:
    """Add the legend of a page of panels that have no axes."""
    areas = {"walls": WALL, "furniture": THING, "obstacles": OBSTACLE}
    lines = {"path, reached": GOOD, "path, failed": BAD}
    marks = {"start": "o", "goal": "*"}
    shown = [
        *(Line2D([], [], color=colour, label=what) for what, colour in lines.items()),
        Line2D([], [], color=PERSON, linestyle=":", label="ways of people"),
        *(Line2D([], [], color=GOOD, linestyle="", marker=mark, label=what) for what, mark in marks.items()),
        *(Patch(color=colour, label=what) for what, colour in areas.items()),
    ]
    page.legend(handles=shown, loc="outside lower left", ncols=len(shown), frameon=False, fontsize=10)


def _draw_bar(axes: Axes) -> None:
    """Show how long `BAR` m are, below a panel without axes."""
    left, bottom = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.plot([left, left + BAR], [bottom, bottom], color="black", linewidth=1.5, solid_capstyle="butt")


def _draw_path(axes: Axes, result: Result[Job], *, is_first: bool = True) -> None:
    """A path with its start and its goal, over its world."""
    if (task := result.task) is None:
        return
    draw_world(axes, task.world, is_first=is_first)
    if is_first:
        _draw_bar(axes)
    colour = GOOD if result.is_good else BAD
    axes.plot([p.x for p in result.path], [p.y for p in result.path], color=colour, linewidth=1.2)
    axes.plot(task.start.x, task.start.y, "o", color=GOOD, markersize=3)
    axes.plot(*task.goal, "*", color=GOOD, markersize=6)

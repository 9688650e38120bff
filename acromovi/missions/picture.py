"""Pictures of missions: paths over the plan."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.missions.matrix import Result
from acromovi.missions.tasks import Case, Condition
from geometry import Polygon
from p2os_emu.world import WorldSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Page

WALL, THING, OBSTACLE, PERSON = "#3d4248", "#cfc9bd", "#d9a520", "#7a4fa3"
BAR = 2.0  # m, of the scale below panels without axes
GOOD, BAD, BELIEVED, SHORTEST = "#1f6f4a", "#b5382f", "#c2571a", "#4f7fb5"


def draw_mission(path: Path, result: Result) -> None:
    """Draw one mission as a PNG or SVG, by the ending of `path`."""
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(11, 8), layout="constrained")
    axes = page.subplots()
    if (task := result.task) is not None:
        _draw_world(axes, task.world)
        _line(axes, task.way.points, SHORTEST, "shortest way", linestyle=":")
        _line(axes, [(p.x, p.y) for p in result.believed], BELIEVED, "as odometry has it", linestyle="--")
        _line(axes, [(p.x, p.y) for p in result.path], GOOD if result.is_good else BAD, "path", linewidth=2.0)
        axes.plot(task.start.x, task.start.y, "o", color=GOOD, label="start")
        axes.plot(*task.goal, "*", color=GOOD, markersize=14, label="goal")
    axes.set_title(_title(result), loc="left", fontsize=10)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    page.savefig(path, dpi=100)


def draw_sheet(path: Path, results: Sequence[Result], world: str) -> None:
    """Draw all missions in one world, a panel for each case and condition."""
    from matplotlib.figure import Figure

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


def draw_grid(path: Path, results: Sequence[Result]) -> None:
    """Draw missions one beside the other, each in its own world."""
    from matplotlib.figure import Figure

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


def _explain(page: "Page") -> None:
    """Add the legend of a page of panels that have no axes."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

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


def _draw_bar(axes: "Axes") -> None:
    """Show how long `BAR` m are, below a panel without axes."""
    left, bottom = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.plot([left, left + BAR], [bottom, bottom], color="black", linewidth=1.5, solid_capstyle="butt")


def _draw_path(axes: "Axes", result: Result, *, is_first: bool = True) -> None:
    """A path with its start and its goal, over its world."""
    if (task := result.task) is None:
        return
    _draw_world(axes, task.world, is_first=is_first)
    if is_first:
        _draw_bar(axes)
    _line(axes, [(p.x, p.y) for p in result.path], GOOD if result.is_good else BAD, linewidth=1.2)
    axes.plot(task.start.x, task.start.y, "o", color=GOOD, markersize=3)
    axes.plot(*task.goal, "*", color=GOOD, markersize=6)


def _draw_world(axes: "Axes", world: WorldSpec, *, is_first: bool = True) -> None:
    """Walls, furniture, obstacles, and the ways of people. Walls and furniture only once for a panel."""
    if is_first:
        _fill(axes, [block.footprint for block in world.walls], WALL, "walls")
        _fill(axes, [block.footprint for block in world.furniture], THING, "furniture")
    _fill(axes, [thing.footprint(thing.pose) for thing in world.objects], OBSTACLE, "obstacles")
    for number, person in enumerate(world.people):
        label = "ways of people" if number == 0 else ""
        _line(axes, person.route, PERSON, label, linewidth=0.6, linestyle=":")
    axes.set_aspect("equal")


def _title(result: Result) -> str:
    verdict = result.verdict
    if verdict is None:
        return f"{result.job.command}\ncrashed"
    said = "reached" if verdict.reached else f"not reached: {verdict.why_not}"
    touched = f"; touched {', '.join(verdict.touched)}" if verdict.touched else ""
    figures = f"{verdict.length:.1f} m, {verdict.over_shortest:.2f} of the shortest way, {verdict.seconds:.1f} s"
    return f"{result.job.command}  ({result.job.robot}, {result.job.world})\n{said}{touched}\n{figures}"


def _line(axes: "Axes", points: Sequence[tuple[float, float]], colour: str, label: str = "", **style: Any) -> None:
    axes.plot([x for x, _ in points], [y for _, y in points], color=colour, label=label or None, **style)


def _fill(axes: "Axes", polygons: Sequence[Polygon], colour: str, label: str) -> None:
    for number, polygon in enumerate(polygons):
        outline = [x for x, _ in polygon], [y for _, y in polygon]
        axes.fill(*outline, color=colour, linewidth=0, label=label if number == 0 else None)

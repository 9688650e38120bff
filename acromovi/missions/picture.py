"""Pictures of missions: paths over the plan."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.missions.matrix import Result
from geometry import Polygon
from p2os_emu.world import WorldSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL, THING, OBSTACLE, PERSON = "#3d4248", "#cfc9bd", "#d9a520", "#7a4fa3"
GOOD, BAD, BELIEVED, SHORTEST = "#1f6f4a", "#b5382f", "#c2571a", "#4f7fb5"


def draw_mission(path: Path, result: Result[Any]) -> None:
    """Draw one mission as a PNG or SVG, by the ending of `path`."""
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(11, 8), layout="constrained")
    axes = page.subplots()
    if (task := result.task) is not None:
        draw_world(axes, task.world)
        if task.way is not None:
            _line(axes, task.way.points, SHORTEST, "shortest way", linestyle=":")
        _line(axes, [(p.x, p.y) for p in result.believed], BELIEVED, "as odometry has it", linestyle="--")
        _line(axes, [(p.x, p.y) for p in result.path], GOOD if result.is_good else BAD, "path", linewidth=2.0)
        axes.plot(task.start.x, task.start.y, "o", color=GOOD, label="start")
        axes.plot(*task.goal, "*", color=GOOD, markersize=14, label="goal")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes.set_title(_title(result), loc="left", fontsize=10)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    page.savefig(path, dpi=100)


def draw_world(axes: "Axes", world: WorldSpec, *, is_first: bool = True) -> None:
    """Walls, furniture, obstacles, and the ways of people. Walls and furniture only once for a panel."""
    if is_first:
        _fill(axes, [block.footprint for block in world.walls], WALL, "walls")
        _fill(axes, [block.footprint for block in world.furniture], THING, "furniture")
    _fill(axes, [thing.footprint(thing.pose) for thing in world.objects], OBSTACLE, "obstacles")
    for number, person in enumerate(world.people):
        label = "ways of people" if number == 0 else ""
        _line(axes, person.route, PERSON, label, linewidth=0.6, linestyle=":")
    axes.set_aspect("equal")


def _title(result: Result[Any]) -> str:
    verdict = result.verdict
    if verdict is None:
        return f"{result.job.command}\nnot played: {result.error.strip().splitlines()[-1] if result.error else ''}"
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

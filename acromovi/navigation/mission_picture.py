"""The picture of a mission: grid, path, plan, doors, and the motion commands of all sources."""

from collections.abc import Iterator, Mapping, Sequence
from math import cos, pi, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acromovi.navigation.snapshot import Snapshot
from configs.extras import require

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Points = Sequence[tuple[float, float]]

UNKNOWN, FREE, OBSTACLE = "#e2e5ea", "#ffffff", "#3d4248"
TRAVELLED, PLANNED, GOAL, DOOR, WAYS, ROBOT = "#1f6f4a", "#1f77b4", "#b5382f", "#d9730d", "#b9a7d6", "#111827"
SOURCES = ("#9467bd", "#0f9aa8", "#d4487a", "#8c6239", "#5b6abf", "#7a8a1f")
AHEAD = 2.0  # s of the motion of a command that is drawn
NEAR = 1.2  # m around the robot in the small panel
RADIUS = 0.3  # m of the outline of a robot of unknown size
WIDTH, FLOOR, LOWEST, HIGHEST = 12.3, 8.0, 7.8, 12.0  # inches, of the page and of the floor on it


def draw(path: Path, shot: Snapshot) -> None:
    """Draw an SVG or a PNG, by the suffix of `path`; equal snapshots give equal files.

    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("a picture of a mission", "plots")
    import matplotlib as mpl
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(WIDTH, height := _height(shot)))
    # Without an automatic layout: the panels beside the floor are as wide as their texts, and the floor takes the rest.
    axes = page.add_axes((0.8 / WIDTH, 0.6 / height, FLOOR / WIDTH, 1.0 - 1.1 / height), anchor="NW")
    near = page.add_axes(((FLOOR + 1.3) / WIDTH, 2.1 / height, 2.2 / WIDTH, 2.2 / height), anchor="NW")
    _draw_floor(axes, shot.planning.get("grid"))
    _draw_doors(axes, shot.planning.get("doors", ()))
    _draw_ways(axes, shot)
    _draw_robot(axes, shot)
    axes.set_xlabel("x in odom, m")
    axes.set_ylabel("y in odom, m")
    axes.set_title(_wrapped(shot.title), loc="left", fontsize=11)
    _draw_commands(near, shot)
    near.tick_params(labelsize=7)
    near.spines[["top", "right"]].set_visible(False)
    axes.set_aspect("equal")
    near.set_aspect("equal")
    axes.spines[["top", "right"]].set_visible(False)
    if axes.get_legend_handles_labels()[0]:
        place = (FLOOR + 1.0) / WIDTH, 1.0 - 0.4 / height
        page.legend(
            *axes.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=place, frameon=False, fontsize=9
        )
    with mpl.rc_context({"svg.hashsalt": "acromovi"}):
        page.savefig(path, dpi=110, metadata={"Date": None} if path.suffix == ".svg" else None)


def _height(shot: Snapshot) -> float:
    """Return the size of the page for the shape of the floor, inches."""
    grid = shot.planning.get("grid") or {}
    rows, columns = grid.get("rows") or 1, grid.get("columns") or 1
    return min(max(FLOOR * rows / columns + 1.2, LOWEST), HIGHEST)


def floor_of(grid: Mapping[str, Any] | None) -> NDArray[np.int8]:
    """Return the cell values in rows of rising y: 0 unknown, 1 free, 2 obstacle."""
    if not grid or not grid["runs"]:
        return np.zeros((0, 0), np.int8)
    runs = np.array(grid["runs"], np.int64)
    return np.repeat(runs[:, 0], runs[:, 1]).astype(np.int8).reshape(grid["rows"], grid["columns"])


def _draw_floor(axes: "Axes", grid: Mapping[str, Any] | None) -> None:
    from matplotlib.colors import ListedColormap

    floor = floor_of(grid)
    axes.set_facecolor(UNKNOWN)
    if grid is None or not floor.size:
        return
    left, low, edge = grid["x"], grid["y"], grid["resolution"]
    extent = (left, left + edge * floor.shape[1], low, low + edge * floor.shape[0])
    colours = ListedColormap([UNKNOWN, FREE, OBSTACLE])
    axes.imshow(floor, cmap=colours, vmin=0, vmax=2, origin="lower", extent=extent, interpolation="nearest")
    for what, colour in (("obstacles seen", OBSTACLE), ("seen to be free", FREE), ("not seen", UNKNOWN)):
        axes.plot([], [], "s", color=colour, markeredgecolor="grey", markeredgewidth=0.4, label=what)


def _draw_doors(axes: "Axes", doors: Sequence[Mapping[str, Any]]) -> None:
    """Draw each door as a bar of its width, with its confidence; dashed while it is not believed."""
    for number, door in enumerate(doors):
        x, y, normal, half = door["x"], door["y"], door["normal"], door["width"] / 2
        across = half * cos(normal + pi / 2), half * sin(normal + pi / 2)
        believed = door.get("is_believed", True)
        axes.plot(
            (x - across[0], x + across[0]),
            (y - across[1], y + across[1]),
            color=DOOR,
            linewidth=3.5,
            alpha=0.3 + 0.7 * door["confidence"],
            linestyle="-" if believed else (0, (1, 1)),
            label="doors, with confidence" if number == 0 else None,
        )
        passed = f", passed {door['passed']}" if door.get("passed") else ""
        text = f"{door['confidence']:.2f}{passed}"
        axes.annotate(text, (x, y), (4, 4), textcoords="offset points", fontsize=7, color=DOOR)


def _draw_ways(axes: "Axes", shot: Snapshot) -> None:
    planning = shot.planning
    for number, way in enumerate(planning.get("ways", ())):
        _line(axes, way["points"], color=WAYS, linewidth=3.0, label="ways remembered" if number == 0 else None)
    _line(axes, planning.get("trail", ()), color=TRAVELLED, linewidth=2.0, label="path travelled")
    route = planning.get("route") or ()
    _line(axes, route, color=PLANNED, linewidth=1.6, linestyle="--", label="plan")
    _line(
        axes, planning.get("ends") or (), color=PLANNED, linestyle="", marker="o", markersize=4, label="ends of pieces"
    )
    if target := planning.get("sub_target"):
        axes.plot(*target, "o", color=PLANNED, markersize=10, markerfacecolor="none", label="sub-target now")
    goal = planning.get("goal") or {}
    if goal.get("x") is not None and goal.get("y") is not None:
        axes.plot(goal["x"], goal["y"], "*", color=GOAL, markersize=14, label="goal")
        if goal.get("heading") is not None:
            step = 0.6 * cos(goal["heading"]), 0.6 * sin(goal["heading"])
            axes.annotate(
                "", (goal["x"] + step[0], goal["y"] + step[1]), (goal["x"], goal["y"]), arrowprops=_arrow(GOAL, 1.5)
            )


def _draw_robot(axes: "Axes", shot: Snapshot) -> None:
    pose = shot.planning.get("pose")
    if pose is None:
        return
    xs, ys = zip(*_placed(outline(shot.body), pose), strict=True)
    axes.fill(xs, ys, color=ROBOT, alpha=0.35, linewidth=0)
    axes.plot(xs, ys, color=ROBOT, linewidth=1.2, label=_plain(str(shot.body.get("model", "robot"))))
    for name, colour, width, command in _commands(shot):
        points = list(_placed(_motion(command), pose))
        if name == "fused" and len(points) > 1:
            _line(axes, points, color=colour, linewidth=width)


def _draw_commands(axes: "Axes", shot: Snapshot) -> None:
    """Draw the robot from above, heading up, and the motion of each command within `AHEAD`."""
    xs, ys = zip(*_placed(outline(shot.body), (0.0, 0.0, pi / 2)), strict=True)
    axes.fill(xs, ys, color=ROBOT, alpha=0.15, linewidth=0)
    for name, colour, width, command in _commands(shot):
        points = list(_placed(_motion(command), (0.0, 0.0, pi / 2)))
        shaft, style = points[:-3] or points, "-" if command.get("is_young", True) else ":"
        axes.plot(*zip(*shaft, strict=True), color=colour, linewidth=width, linestyle=style, label=_said(name, command))
        if len(points) > len(shaft):
            axes.annotate("", points[-1], shaft[-1], arrowprops=_arrow(colour, width))
    axes.set_xlim(-NEAR, NEAR)
    axes.set_ylim(-NEAR / 2, 1.5 * NEAR)
    axes.set_xlabel("to the right, m", fontsize=8)
    axes.set_ylabel("ahead, m", fontsize=8)
    axes.set_title(f"what is wanted of the wheels, {AHEAD:g} s ahead", loc="left", fontsize=9)
    if shot.commands:
        axes.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.2), frameon=False, fontsize=8)
    else:
        axes.text(0.0, NEAR, "the fuser does not answer", ha="center", fontsize=8)


def outline(body: Mapping[str, Any]) -> Points:
    """Return the closed outline of the robot about its axle, m; a default where its size is unknown."""
    front, rear = float(body.get("front", RADIUS)), float(body.get("rear", RADIUS))
    half = float(body.get("width", 2 * RADIUS)) / 2
    nose = front - half / 2
    return ((front, 0.0), (nose, half), (-rear, half), (-rear, -half), (nose, -half), (front, 0.0))


def _commands(shot: Snapshot) -> Iterator[tuple[str, str, float, Mapping[str, Any]]]:
    """Yield name, colour, line width and command of each source; the fused one last, narrow, on top."""
    for number, (name, command) in enumerate(sorted(shot.commands.get("sources", {}).items())):
        yield name, SOURCES[number % len(SOURCES)], 3.0 + min(2.0, float(command["weight"])), command
    if fused := shot.commands.get("fused"):
        yield "fused", ROBOT, 1.6, fused


def _said(name: str, command: Mapping[str, Any]) -> str:
    if not command.get("is_young", True):
        return f"{name}: too old to be used"
    limit = f"at most {command['limit']:.2f} m/s" if command.get("limit") is not None else ""
    weight = f"weight {command['weight']:.2g}" if name != "fused" and command["weight"] else ""
    wants = f"{command['linear']:.2f} m/s, {command['angular']:+.2f} rad/s" if command["weight"] else "nothing"
    more = ", ".join(filter(None, (weight, limit)))
    return _plain(f"{name}: {wants}" + (f"\n{more}" if more else ""))


def _motion(command: Mapping[str, Any]) -> Points:
    """Return the motion of a command in the robot's frame; a turn on the spot is an arc around it."""
    if not command["weight"]:
        return [(0.0, 0.0)]
    times = np.linspace(0.0, AHEAD, 20)
    linear, angular = float(command["linear"]), float(command["angular"])
    if abs(linear) < 0.02:
        return [(1.5 * RADIUS * cos(angular * t), 1.5 * RADIUS * sin(angular * t)) for t in times]
    if abs(angular) < 1e-3:
        return [(linear * t, 0.0) for t in times]
    radius = linear / angular
    return [(radius * sin(angular * t), radius * (1.0 - cos(angular * t))) for t in times]


def _placed(points: Points, pose: Sequence[float]) -> Iterator[tuple[float, float]]:
    x, y, heading = pose
    for along, left in points:
        yield x + along * cos(heading) - left * sin(heading), y + along * sin(heading) + left * cos(heading)


def _line(axes: "Axes", points: Sequence[Sequence[float]], **style: Any) -> None:
    if len(points):
        axes.plot([x for x, _ in points], [y for _, y in points], **style)


def _arrow(colour: str, width: float) -> dict[str, Any]:
    return {
        "arrowstyle": "-|>",
        "color": colour,
        "linewidth": width,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 6 + 4 * width,
    }


def _wrapped(title: str) -> str:
    from textwrap import fill

    return _plain(fill(title, 100))


def _plain(text: str) -> str:
    """Return a text without the characters that matplotlib sets as a formula."""
    return text.replace("$", r"\$")

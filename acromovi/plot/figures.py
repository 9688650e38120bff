"""Draws the curves of a recording: paths over the map, speeds, ranges, battery, latency."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from acromovi.plot.series import MAP_FRAME, Curve, RobotSeries, worst_each_second
from acromovi.svg import COLOURS
from apps.pictures import save_picture
from bus import keys
from geometry import Polygon, Pose2D

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 2000  # points of a curve that are drawn
WALL, SEEN = "#b9b4a8", "#c4c9d0"


@dataclass(frozen=True, slots=True)
class Background:
    """What the paths are drawn over, m.

    walls: outlines. lines: walls without a width. grid: occupancy in %, -1 where it is not known, row 0 at the bottom,
    shape (height, width), with its left, right, lower and upper edge. frame: in which all of them are.
    """

    walls: Sequence[Polygon] = ()
    lines: Sequence[tuple[tuple[float, float], tuple[float, float]]] = ()
    grid: tuple[NDArray[np.int8], tuple[float, float, float, float]] | None = None
    frame: str = MAP_FRAME

    @classmethod
    def of_grid(cls, message: Any) -> Self:
        """Return a recorded occupancy grid; its rotation is passed over, which map builders leave at 0."""
        info = message.info
        left, lower = info.origin.position.x, info.origin.position.y
        cells = np.asarray(message.data, np.int8).reshape(info.height, info.width)
        right, upper = left + info.width * info.resolution, lower + info.height * info.resolution
        return cls(grid=(cells, (left, right, lower, upper)), frame=message.header.frame_id)

    @property
    def is_map(self) -> bool:
        """Whether it is a map, and not empty."""
        return bool(self.walls or self.lines or self.grid)


@dataclass(frozen=True, slots=True)
class PlottedRecording:
    """What all figures are made of.

    title: above the paths. starts: where the odometry frame of a robot is in the map, by its name.
    """

    title: str
    robots: Sequence[RobotSeries]
    background: Background
    starts: Mapping[str, Pose2D]

    def origin(self, robot: RobotSeries) -> Pose2D | None:
        """Return where a robot's odometry frame is in the map, None if it is not known; without a map, the origin."""
        known = self.starts.get(robot.name) or robot.in_map
        if self.background.frame == keys.frame(robot.name, "odom"):
            known = Pose2D(0.0, 0.0, 0.0)
        return known if known is not None or self.background.is_map else Pose2D(0.0, 0.0, 0.0)

    def not_in_map(self) -> list[str]:
        """Return the robots whose place in the map is not known, and whose paths are therefore not drawn."""
        return [robot.name for robot in self.robots if self.origin(robot) is None]

    def coloured(self) -> Iterator[tuple[RobotSeries, str]]:
        """Yield the robots with their colours."""
        for number, robot in enumerate(self.robots):
            yield robot, COLOURS[number % len(COLOURS)]


def draw(plotted: PlottedRecording, output: Path, is_folder: bool) -> list[Path]:
    """Draw all figures: on one page, or each in a file of its own in a folder.

    Returns:
        The files.
    Raises:
        OSError: A file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import, and only needed here

    if not is_folder:
        page = Figure(figsize=(13, 8), layout="constrained")
        grid = page.add_gridspec(len(FIGURES) - 1, 2, width_ratios=(1.15, 1))
        names = list(FIGURES)
        FIGURES[names[0]](plotted, page.add_subplot(grid[:, 0]))
        for row, name in enumerate(names[1:]):
            FIGURES[name](plotted, page.add_subplot(grid[row, 1]))
        save_picture(page, output)
        return [output]
    output.mkdir(parents=True, exist_ok=True)
    files = []
    for name, figure in FIGURES.items():
        page = Figure(figsize=(7, 6) if name == "paths" else (8, 3.2), layout="constrained")
        figure(plotted, page.add_subplot())
        files.append(output / f"{name}.png")
        save_picture(page, files[-1])
    return files


def _draw_paths(plotted: PlottedRecording, axes: "Axes") -> None:
    if plotted.background.grid is not None:
        cells, edges = plotted.background.grid
        shade = np.where(cells < 0, 0.9, 1.0 - np.clip(cells, 0, 100) / 100.0)
        axes.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=edges, zorder=-1)
    for wall in plotted.background.walls:
        axes.fill([x for x, _ in wall], [y for _, y in wall], color=WALL, linewidth=0)
    for (x1, y1), (x2, y2) in plotted.background.lines:
        axes.plot([x1, x2], [y1, y2], color="#6b665c", linewidth=1.0)
    for robot, colour in plotted.coloured():
        origin = plotted.origin(robot)
        if origin is None:
            continue
        seen = [origin.transform(x, y) for x, y in robot.seen]
        axes.scatter([x for x, _ in seen], [y for _, y in seen], s=1.0, color=SEEN, linewidths=0, zorder=0)
        thinned = robot.path[:: max(1, len(robot.path) // MOST)] + robot.path[-1:]
        places = [origin.transform(pose.x, pose.y) for _, pose in thinned]
        axes.plot([x for x, _ in places], [y for _, y in places], color=colour, linewidth=1.6, label=_shown(robot.name))
        axes.plot(*places[0], "o", color=colour, markersize=6)
        axes.plot(*places[-1], "s", color=colour, markersize=6)
    axes.set_title(plotted.title, loc="left", fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x, m (circle: start, square: end)")
    axes.set_ylabel("y, m")
    if len(plotted.not_in_map()) < len(plotted.robots):
        axes.legend(loc="upper right", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def _draw_speeds(plotted: PlottedRecording, axes: "Axes") -> None:
    for robot, colour in plotted.coloured():
        _draw_curve(axes, robot.actual, colour, f"{_shown(robot.name)}, actual")
        _draw_curve(axes, robot.commanded, colour, f"{_shown(robot.name)}, commanded", "--")
    _finish(axes, "forward speed, m/s")


def _draw_turns(plotted: PlottedRecording, axes: "Axes") -> None:
    for robot, colour in plotted.coloured():
        _draw_curve(axes, robot.actual_turn, colour, f"{_shown(robot.name)}, actual")
        _draw_curve(axes, robot.commanded_turn, colour, f"{_shown(robot.name)}, commanded", "--")
    _finish(axes, "turn rate, rad/s")


def _draw_ranges(plotted: PlottedRecording, axes: "Axes") -> None:
    for robot, colour in plotted.coloured():
        _draw_curve(axes, robot.laser, colour, f"{_shown(robot.name)}, laser")
        _draw_curve(axes, robot.sonar, colour, f"{_shown(robot.name)}, sonar", ":")
    _finish(axes, "nearest range, m")


def _draw_battery(plotted: PlottedRecording, axes: "Axes") -> None:
    for robot, colour in plotted.coloured():
        _draw_curve(axes, robot.battery, colour, _shown(robot.name))
    _finish(axes, "battery, V")


def _draw_latency(plotted: PlottedRecording, axes: "Axes") -> None:
    for robot, colour in plotted.coloured():
        worst = [(time, 1e3 * value) for time, value in worst_each_second(robot.latency)]
        _draw_curve(axes, worst, colour, _shown(robot.name))
    _finish(axes, "latency, ms")
    axes.set_xlabel("time, s")


FIGURES: dict[str, Callable[[PlottedRecording, "Axes"], None]] = {
    "paths": _draw_paths,
    "speeds": _draw_speeds,
    "turns": _draw_turns,
    "ranges": _draw_ranges,
    "battery": _draw_battery,
    "latency": _draw_latency,
}
"""The figures by the names of their files; the first is the large one of the page."""


def _draw_curve(axes: "Axes", curve: Curve, colour: str, label: str, style: str = "-") -> None:
    if curve:
        thinned = curve[:: max(1, len(curve) // MOST)]
        axes.plot([t for t, _ in thinned], [v for _, v in thinned], style, color=colour, linewidth=1.0, label=label)


def _finish(axes: "Axes", what: str) -> None:
    axes.set_ylabel(what, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(visible=True, linewidth=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    if axes.lines:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05), fontsize=6, frameon=False)
    else:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", va="center", color="#8a8f98")


def _shown(name: str) -> str:
    """A robot's name without what matplotlib takes as a formula or as no label."""
    return name.replace("$", r"\$").removeprefix("_") or "_"

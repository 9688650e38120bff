"""Pictures of the localization: the path on the map, and errors over time."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

from geometry import Pose2D
from maps.building_map import BuildingMap

_SHOWN = 300.0  # s of the path


class TracedStep(Protocol):
    """What is drawn of a step."""

    @property
    def time(self) -> float:
        """s."""

    @property
    def guess(self) -> Pose2D | None:
        """In the map."""

    @property
    def true(self) -> Pose2D:
        """Likewise."""

    @property
    def error(self) -> float:
        """m."""


def draw_path(map_: BuildingMap, laser: Sequence[TracedStep], sonar: Sequence[TracedStep], file: Path) -> None:
    """Draw the first part of the true path, and those that laser and sonar give, on the map."""
    from matplotlib.figure import Figure as Sheet

    sheet = Sheet(figsize=(9, 7), layout="constrained")
    axes = sheet.subplots()
    for x1, y1, x2, y2 in map_.lines:
        axes.plot((x1, x2), (y1, y2), color="black", linewidth=1.0)
    for steps, colour, name in ((sonar, "tab:orange", "16 sonar discs"), (laser, "tab:blue", "laser")):
        part = [step.guess for step in steps if step.time < steps[0].time + _SHOWN and step.guess is not None]
        axes.plot([pose.x for pose in part], [pose.y for pose in part], color=colour, linewidth=1.2, label=name)
    part = [step.true for step in laser if step.time < laser[0].time + _SHOWN]
    axes.plot([p.x for p in part], [p.y for p in part], color="grey", linestyle=":", linewidth=1.0, label="true path")
    axes.set_aspect("equal")
    axes.set_xlabel("x in map, m")
    axes.set_ylabel("y in map, m")
    axes.legend(loc="lower center", ncols=3, bbox_to_anchor=(0.5, 1.0))
    sheet.savefig(file)


def draw_errors(traces: Mapping[str, Sequence[TracedStep]], file: Path) -> None:
    """Draw the distance of the pose from the truth over time, for each sensor."""
    from matplotlib.figure import Figure as Sheet

    sheet = Sheet(figsize=(9, 3.5), layout="constrained")
    axes = sheet.subplots()
    for sensor, colour in (("sonar", "tab:orange"), ("laser", "tab:blue")):
        steps = traces[sensor][::20]
        minutes = [(step.time - steps[0].time) / 60.0 for step in steps]
        axes.plot(minutes, [100.0 * step.error for step in steps], color=colour, linewidth=0.8, label=sensor)
    axes.set_xlabel("time, min")
    axes.set_ylabel("error, cm")
    axes.set_ylim(0.0, 40.0)
    axes.legend()
    sheet.savefig(file)

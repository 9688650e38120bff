"""A measured figure beside the one to reach, and the page of them."""

import json
import math
import platform
import statistics
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Figure:
    """One number of the benchmark.

    name: what was measured, as a person would say it.
    value, reach: in `unit`; the figure is reached when value <= reach.
    samples: how many measurements the value summarises.
    group: the benchmark it belongs to, and the argument that repeats it.
    spread: between the smallest and the largest round, as a share of the median; None without rounds.
    doubt: why the machine was too noisy to trust the value; empty if it was not.
    """

    group: str
    name: str
    value: float
    reach: float
    unit: str
    samples: int = 1
    spread: float | None = None
    doubt: str = ""

    @property
    def is_reached(self) -> bool:
        """Whether the value is within what was asked for."""
        return self.value <= self.reach

    @property
    def command(self) -> str:
        """What to type to measure this figure again."""
        return f".venv/bin/python -m benchmarks {self.group}"


def percentile(samples: Sequence[float], percent: float) -> float:
    """The smallest sample that `percent` of all samples do not exceed (nearest rank)."""
    ordered = sorted(samples)
    return ordered[max(0, math.ceil(percent / 100 * len(ordered)) - 1)]


def p50_p99(group: str, name: str, samples: Sequence[float], reach: tuple[float, float], unit: str) -> list[Figure]:
    """The median and the 99th percentile of some samples as two figures."""
    return [
        Figure(group, f"{name}, p50", statistics.median(samples), reach[0], unit, len(samples)),
        Figure(group, f"{name}, p99", percentile(samples, 99), reach[1], unit, len(samples)),
    ]


def as_text(figure: Figure) -> str:
    """One line for a terminal, with the spread and the doubt where there are such."""
    mark = "ok  " if figure.is_reached else "MISS"
    spread = "" if figure.spread is None else f" spread {figure.spread:.0%}"
    doubt = figure.doubt and f" NOT TRUSTWORTHY: {figure.doubt}"
    return f"{mark} {figure.name:<88} {figure.value:>10.3f} {figure.unit:<4} (reach {figure.reach:g}){spread}{doubt}"


def write_json(figures: Sequence[Figure], path: Path) -> None:
    """Write all figures with the commands that repeat them and the machine they come from."""
    rows = [{**asdict(f), "is_reached": f.is_reached, "command": f.command} for f in figures]
    machine = {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system()}
    path.write_text(json.dumps({"machine": machine, "figures": rows}, indent=2) + "\n", encoding="utf-8")


def write_picture(figures: Sequence[Figure], path: Path) -> None:
    """Draw each figure as a bar of what was asked for: left of the line is reached."""
    from matplotlib.figure import Figure as Page

    page = Page(figsize=(13, 1.2 + 0.34 * len(figures)), layout="constrained")
    axes = page.subplots()
    ratios = [min(f.value / f.reach if f.reach else float(f.value > 0), 3.0) for f in figures]
    colours = ["#3b7a57" if f.is_reached else "#b5382f" for f in figures]
    rows = range(len(figures), 0, -1)
    axes.barh(rows, ratios, color=colours, height=0.62)
    for row, ratio, figure in zip(rows, ratios, figures, strict=True):
        axes.text(ratio + 0.01, row, f"{figure.value:.3g} / {figure.reach:g} {figure.unit}", va="center", fontsize=8)
    axes.set_yticks(list(rows), [f.name for f in figures], fontsize=8)
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.set_xlim(0, max(1.3, *(r + 0.25 for r in ratios)))
    axes.set_xlabel("measured / to reach")
    axes.set_title("Acromovi: figures reached (green) and missed (red)", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    page.savefig(path, dpi=110)

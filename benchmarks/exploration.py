"""Exploration of generated floors by one robot and by two, in lockstep; writes exploration.md and a picture of a map.

A floor has 190 to 350 square metres in its outline. Robots begin beside each other, and know nothing of where the
other's map lies until they have seen the same rooms.
"""

import argparse
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from acromovi.mapping.picture import draw_map
from benchmarks.drives import drive_all
from benchmarks.exploration_course import Explored, explore
from benchmarks.figures import Figure
from p2os_emu.world import load_world

GROUP = "exploration"
FAMILIES = ("corridors", "skew", "hall")
SEEDS = range(600, 606)  # house, seed 7, was looked at
SHARE = 0.65  # of the time of one robot that two may need
MOST_UNSEEN = 0.02  # share of the floor that can be reached: corners behind furniture


@dataclass(frozen=True, slots=True)
class ExplorationScore:
    """One floor, explored by one robot and by two."""

    floor: str
    alone: Explored
    together: Explored

    @property
    def share(self) -> float:
        """Of the time of one robot that two needed."""
        return self.together.seconds / self.alone.seconds


def measure(options: argparse.Namespace) -> list[Figure]:
    """Explore all floors, several at the same time, and judge by the truth."""
    options.out.mkdir(parents=True, exist_ok=True)
    scores = drive_all(explore_floor, options.seeds or SEEDS, options, row)
    (options.out / "exploration.md").write_text(page(scores), encoding="utf-8")
    return figures(scores)


def explore_floor(seed: int, out: Path | None = None) -> ExplorationScore:
    """Explore the floor of a seed by one robot, then by two; draw the map of the one into a folder."""
    floor = f"{FAMILIES[seed % len(FAMILIES)]}:{seed}"
    world = load_world(floor)
    alone, together = (explore(world, seed, robots=robots) for robots in (1, 2))
    if out is not None:
        draw_map(out / "exploration.png", alone.made, f"{floor}, explored by one robot")
    return ExplorationScore(floor, alone, together)


def figures(scores: Sequence[ExplorationScore]) -> list[Figure]:
    """Return the figures of several floors."""
    explored = [each for score in scores for each in (score.alone, score.together)]
    count = len(explored)
    unseen = max(1.0 - each.seen for each in explored)
    unended = sum(not each.ended for each in explored)
    share = statistics.median(score.share for score in scores)
    touched = sum(bool(each.touched) for each in explored)
    return [
        Figure(GROUP, "explorations that did not end by themselves", unended, 0, "", count),
        Figure(GROUP, "floor not seen, worst exploration", unseen, MOST_UNSEEN, "", count),
        Figure(GROUP, "explorations with a contact", touched, 0, "", count),
        Figure(GROUP, "time of two robots / time of one, median", share, SHARE, "", len(scores)),
    ]


def row(score: ExplorationScore) -> str:
    """Return one floor as a row of the table."""
    cells = [score.floor]
    for each in (score.alone, score.together):
        ended = f"{each.seconds:.0f} s" + ("" if each.ended else ", not ended")
        cells += [ended, f"{each.driven:.0f} m", f"{each.missions}", f"{each.seen:.1%}"]
        cells.append(", ".join(each.touched) or "nothing")
    return f"| {' | '.join([*cells, f'{score.share:.2f}'])} |"


def page(scores: Sequence[ExplorationScore]) -> str:
    """Return a table of all floors."""
    each = ("time", "driven", "missions", "seen", "touched")
    head = ("floor", *(f"one: {name}" for name in each), *(f"two: {name}" for name in each), "two / one")
    lines = ["# Exploration", "", f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}", *map(row, scores)]
    return "\n".join(lines) + "\n"

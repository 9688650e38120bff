"""Docking from seeded starts in lockstep; writes docking.md."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

from acromovi.process_pool import process_pool
from apps.docking.cycle import DockingState
from apps.docking.settings import DockingSettings
from benchmarks.docking_course import MODELS, ROBOT, DockingCourse, docking_room
from benchmarks.figures import Figure, percentile
from geometry import Pose2D

SEEDS = range(300, 350)  # it was tried on seeds 0 to 13, and the rooms on 100 to 249
LONGEST = 300.0  # s of one drive
GROUP = "docking"


@dataclass(frozen=True, slots=True)
class DockingScore:
    """One drive in figures.

    end: how the application ended. off: from the place of a robot that is charged to where it stands, m and rad.
    touched: what was touched, with times. left: it left the dock afterwards, and is charged no more. seconds: of the
    drive until it was charged.
    """

    seed: int
    model: str
    end: str
    off: Pose2D
    touched: tuple[str, ...]
    is_charged: bool
    left: bool
    seconds: float


def measure(options: argparse.Namespace) -> list[Figure]:
    """Dock from all starts, several at the same time, and judge by the truth."""
    options.out.mkdir(parents=True, exist_ok=True)
    with process_pool() as pool:
        scores = list(pool.map(dock, SEEDS))
    (options.out / "docking.md").write_text(page(scores), encoding="utf-8")
    return figures(scores)


def dock(seed: int) -> DockingScore:
    """Dock in the room of a seed, and leave the dock."""
    model = MODELS[seed % len(MODELS)]
    with DockingCourse(docking_room(seed), DockingSettings.load(), model=model, seed=seed) as course:
        course.run(LONGEST)
        end = course.cycle.state
        words = end.value if end is DockingState.CHARGED else f"{end.value}: {course.cycle.reason}"
        off, seconds = course.lockstep.truth(ROBOT).relative_to(course.dock), course.lockstep.time
        is_charged = course.is_charged
        left = False
        if is_charged:
            course.leave()
            course.run(LONGEST)
            left = course.cycle.state is DockingState.LEFT and not course.is_charged
        return DockingScore(seed, model, words, off, tuple(course.touched()), is_charged, left, seconds)


def figures(scores: Sequence[DockingScore]) -> list[Figure]:
    """Return the figures of several drives."""
    count = len(scores)
    missed, stayed = sum(not each.is_charged for each in scores), sum(not each.left for each in scores)
    touched = sum(bool(each.touched) for each in scores)
    seconds = [each.seconds for each in scores]
    return [
        Figure(GROUP, f"starts of {count} without charge contact", missed, 1, "", count),
        Figure(GROUP, f"starts of {count} in which something was touched", touched, 0, "", count),
        Figure(GROUP, f"robots of {count} that did not leave the dock", stayed, 0, "", count),
        Figure(GROUP, "time until the robot is charged, p50", percentile(seconds, 50), 60.0, "s", count),
    ]


def page(scores: Sequence[DockingScore]) -> str:
    """Return a table of all drives."""
    rows = [
        f"| {s.seed} | {s.model} | {'yes' if s.is_charged else 'no'} | {100 * s.off.x:.1f} | {100 * s.off.y:.1f} "
        f"| {s.off.heading:.3f} | {s.seconds:.0f} | {'yes' if s.left else 'no'} | {'; '.join(s.touched) or 'nothing'} "
        f"| {s.end} |"
        for s in scores
    ]
    head = (
        "| seed | robot | charged | along, cm | across, cm | turned, rad | s | left | touched | end |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n"
    )
    return "# Docking\n\n" + head + "\n".join(rows) + "\n"

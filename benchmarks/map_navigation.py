"""Missions on a map in lockstep, judged by the truth; writes map-navigation.json and map-navigation.png.

The whole benchmark takes an hour or more. Each floor is kept in map-navigation.jsonl as it ends, so a run that was
interrupted goes on with `--resume`.
"""

import argparse
import json
import math
import statistics
from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any

from acromovi.missions.results_file import ResultsFile
from acromovi.process_pool import process_pool
from benchmarks.figures import Figure, percentile
from benchmarks.map_course import FloorJob, GoalScore, MapCondition, play_floor
from p2os_emu.world import load_world

GROUP = "map_navigation"
FIRST_SEED = 900  # it was tried on seeds and plans below 100
GOALS = 10  # on one floor
SHARES = {MapCondition.STATIC: 0.5, MapCondition.CHANGED: 3.0, MapCondition.BUSY: 3.0}
"""Conditions that are played, with the percentage of goals that may be missed."""
MOST_PICTURES = 12
PICTURE_COLUMNS = 4


def measure(options: argparse.Namespace) -> list[Figure]:
    """Play all goals, several floors at the same time."""
    options.out.mkdir(parents=True, exist_ok=True)
    floors = jobs(options.goals, FIRST_SEED if options.first_seed is None else options.first_seed)
    with (
        ResultsFile(options.out / "map-navigation.jsonl", GoalScore, resume=options.resume) as kept,
        process_pool() as pool,
    ):
        scores = of_whole_floors(kept.earlier, floors)
        played = {score.job for score in scores}
        waiting = [pool.submit(play_floor, job) for job in floors if job not in played]
        for number, future in enumerate(as_completed(waiting), len(floors) - len(waiting) + 1):
            ended = future.result()
            kept.add(ended)
            scores += ended
            _print(f"{number} of {len(floors)}", ended)
    scores.sort(key=lambda score: (str(score.job.condition), score.job.seed, score.number))
    table = [as_row(score) for score in scores]
    (options.out / "map-navigation.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    draw(options.out / "map-navigation.png", scores)
    return figures(scores)


def jobs(goals: int, first_seed: int = FIRST_SEED) -> list[FloorJob]:
    """Return the floors with so many goals of each condition: generated plans, and the office each third time."""
    found = []
    for number, first in enumerate(range(0, goals, GOALS)):
        seed = first_seed + number
        for condition in SHARES:
            # The office has no doors that close.
            is_office = number % 3 == 1 and condition is not MapCondition.CHANGED
            world = "office" if is_office else f"plan:{seed}"
            found.append(FloorJob(world, seed, condition, min(GOALS, goals - first)))
    return found


def figures(scores: Sequence[GoalScore]) -> list[Figure]:
    """Return the figures of some goals."""
    found = []
    for condition in SHARES:
        here = [score for score in scores if score.job.condition is condition]
        if not here:
            continue
        missed = 100.0 * sum(not score.is_reached for score in here) / len(here)
        found.append(Figure(GROUP, f"{condition}: goals not reached", missed, SHARES[condition], "%", len(here)))
        touched = sum(bool(score.touched) for score in here)
        found.append(Figure(GROUP, f"{condition}: goals with a contact", touched, 0, "", len(here)))
        reached = [score for score in here if score.is_reached]
        if condition is MapCondition.STATIC and reached:
            ratios = [score.length / score.shortest for score in reached]
            about = "static: path over the shortest path"
            found.append(Figure(GROUP, f"{about}, mean", statistics.mean(ratios), 1.15, "", len(reached)))
            found.append(Figure(GROUP, f"{about}, p95", percentile(ratios, 95), 1.3, "", len(reached)))
    return found


def draw(path: Path, scores: Sequence[GoalScore]) -> None:
    """Draw one static floor, and the goals that were missed or with a contact."""
    from matplotlib.figure import Figure as Page  # slow to import, and only needed here

    from acromovi.missions.picture import draw_world

    bad = [score for score in scores if not score.is_reached or score.touched]
    first = [score for score in scores if score.job == scores[0].job and score not in bad]
    panels = [first, *([score] for score in bad[:MOST_PICTURES])]
    rows = math.ceil(len(panels) / PICTURE_COLUMNS)
    columns = min(len(panels), PICTURE_COLUMNS)
    page = Page(figsize=(5.5 * columns, 4.5 * rows), layout="constrained")
    for panel, axes in zip(panels, page.subplots(rows, columns, squeeze=False).ravel(), strict=False):
        if not panel:
            continue
        draw_world(axes, load_world(panel[0].job.world))
        for score in panel:
            axes.plot([p.x for p in score.path], [p.y for p in score.path], linewidth=1.5)
            axes.plot(*score.goal, "*", color="black")
        job, why = panel[0].job, panel[0].why if len(panel) == 1 else ""
        title = f"{job.condition}, {job.world}, seed {job.seed}"
        touched = f"touched {', '.join(panel[0].touched)}" if len(panel) == 1 and panel[0].touched else ""
        axes.set_title("\n".join(filter(None, (title, why[:80], touched[:80]))), fontsize=8)
    page.savefig(path, dpi=80)


def as_row(score: GoalScore) -> dict[str, Any]:
    """Return a goal as JSON, without its path."""
    row = asdict(score)
    about = row.pop("job")
    del row["path"], about["goals"]
    return {**about, **row}


def of_whole_floors(scores: Sequence[GoalScore], floors: Sequence[FloorJob]) -> list[GoalScore]:
    """Return the goals on these floors that an earlier run has played; none of a floor that was not written whole."""
    found = []
    for floor in floors:
        here = [score for score in scores if score.job == floor][-floor.goals :]
        found += here if [score.number for score in here] == list(range(floor.goals)) else []
    return found


def _print(number: str, ended: Sequence[GoalScore]) -> None:
    job, reached, touched = ended[0].job, sum(s.is_reached for s in ended), sum(bool(s.touched) for s in ended)
    what = f"{job.condition} {job.world} {job.seed}: {reached} of {len(ended)}, {touched} with a contact"
    print(f"   {number} floors, {what}", flush=True)

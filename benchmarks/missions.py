"""Three hundred missions of the indoor navigation in lockstep; writes missions.md and pictures."""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

from acromovi.missions.command import play_many
from acromovi.missions.jobs import Job
from acromovi.missions.matrix import Result
from acromovi.missions.page import Results, page
from acromovi.missions.picture import draw_mission
from benchmarks.figures import Figure
from benchmarks.free_space_block import BlockGoto

MINUTES = 15.0
MOST_PICTURES = 12  # of failures
BESIDE = 4  # seeds for which the free-space-block method is played too
SMOOTHNESS = ("turned, rad/m", "turns per m", "jerk, m/s3")


def measure(options: argparse.Namespace) -> list[Figure]:
    """Play all of them, and judge them by the truth."""
    began = time.monotonic()
    results = Results(play_many(Job.matrix()))
    print("-- the same with the free-space-block method", flush=True)
    others = Results(play_many(Job.matrix(range(BESIDE)), {"goto": BlockGoto}))
    minutes = (time.monotonic() - began) / 60
    options.out.mkdir(parents=True, exist_ok=True)
    pictures = _draw(results, options.out)
    (options.out / "missions.md").write_text(page(results, others, pictures), encoding="utf-8")
    still, busy = results.still, results.busy
    return [
        _figure("missions not reached in static worlds", 100 * (1 - still.share_reached), 1.0, "%", len(still)),
        _figure("missions not reached with obstacles or people", 100 * (1 - busy.share_reached), 3.0, "%", len(busy)),
        _figure("missions in which anything was touched", float(len(results.with_touches)), 0.0, "", len(results)),
        _figure("path over the shortest path, median", results.median("path / shortest"), 1.15, "", 300),
        _figure(
            "time over path at cruising speed, median",
            results.median("time / path at cruising speed"),
            1.35,
            "",
            len(results),
        ),
        *(
            _figure(f"{name}: beside the free-space-block method's", *beside(results, others, name), "", len(others))
            for name in SMOOTHNESS
        ),
        _figure("time for all missions", minutes, MINUTES, "min", len(results)),
    ]


def beside(results: Results, others: Results, name: str) -> tuple[float, float]:
    """The median of a measure where both have come there, as a part of the other method's; and what to reach."""
    ours, theirs = results.also_reached(others), others.also_reached(results)
    return ours.median(name) / theirs.median(name), 1.0


def _figure(name: str, value: float, reach: float, unit: str, samples: int) -> Figure:
    return Figure("missions", name, value, reach, unit, samples)


def _draw(results: Sequence[Result[Job]], out: Path) -> list[str]:
    """The pictures, by their names."""
    from benchmarks.mission_pages import draw_grid, draw_sheet  # only this benchmark needs matplotlib to be loaded

    draw_sheet(out / "missions-house.png", results, "house")
    draw_grid(out / "missions-plans.png", [r for r in results if r.job.world != "house" and r.job.condition == "all"])
    names = ["missions-house.png", "missions-plans.png"]
    for result in [result for result in results if not result.is_good and result.path][:MOST_PICTURES]:
        job = result.job
        names.append(f"failed-{job.case}-{job.condition}-{job.seed}.png")
        draw_mission(out / names[-1], result)
    return names

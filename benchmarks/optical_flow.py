"""Wandering by optical flow through textured rooms in lockstep; writes optical-flow.md, pictures and a film."""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path

import cv2

from apps.film import FilmWriter, Pixels
from apps.optical_flow.application import least_contact
from apps.optical_flow.film import draw_frame
from apps.optical_flow.plots import draw_wandering
from apps.optical_flow.record import FlowRecord
from apps.optical_flow.settings import FlowSettings
from benchmarks.drives import drive_all, seconds_of
from benchmarks.figures import Figure, percentile
from benchmarks.flow_course import ROBOT, FloorCover, FlowCourse
from benchmarks.textured_rooms import textured_room

SEEDS = range(200, 220)  # seeds below 32, 60, 75, 83 and 86 were looked at
DURATION = 600.0  # s
TOUCHED, VISITED, CYCLE_MS = (
    1 / 20,
    0.4,
    15.0,
)  # rooms in which anything is touched, at most; the least of the floor; ms
FILM_FROM, FILM_TO, FILM_RATE = 20.0, 60.0, 2.0  # s and Hz, of the first seed
STRAIGHT = 0.1  # rad/s, below which a frame shows the flow of driving
GROUP = "optical_flow"


@dataclass(frozen=True, slots=True)
class FlowScore:
    """One drive in figures.

    touched: what was touched, with times. clean: s without contact. visited: share of the free floor. way: m.
    cycles: processor time of each cycle, ms.
    """

    seed: int
    touched: tuple[str, ...]
    clean: float
    visited: float
    way: float
    cycles: tuple[float, ...]


def measure(options: argparse.Namespace) -> list[Figure]:
    """Wander in all rooms, several at the same time, and judge by the truth."""
    options.out.mkdir(parents=True, exist_ok=True)
    drive = partial(wander, duration=seconds_of(options, DURATION))
    scores = drive_all(drive, options.seeds or SEEDS, options, row)
    (options.out / "optical-flow.md").write_text(page(scores), encoding="utf-8")
    return figures(scores)


def wander(seed: int, out: Path | None = None, *, duration: float) -> FlowScore:
    """Wander through the room of a seed for so many s; draw pictures and a film into a folder."""
    world = textured_room(seed)
    film = FilmWriter(out / "optical-flow.gif", 1000) if out is not None else None
    record = FlowRecord(ROBOT)
    with FlowCourse(world, FlowSettings.load(), seed=seed, has_vectors=film is not None) as course:
        clean = math.inf
        nearest: tuple[float, Pixels | None] = math.inf, None
        while course.time < duration:
            orders = course.step()
            if course.touched() and math.isinf(clean):
                clean = course.time
            record.add(course.time, course.path[-1], least_contact(course.columns), orders.situation)
            number = len(record.times)
            if film is not None and FILM_FROM <= course.time < FILM_TO and number % round(10 / FILM_RATE) == 0:
                assert course.image is not None  # it drives
                assert course.columns is not None
                words = f"{course.time:.0f} s  {orders.situation.value}: {orders.reason}"
                frame, contact = draw_frame(course.image, course.columns, course.vectors, words), record.contacts[-1]
                film.add(frame)
                if contact < nearest[0] and orders.twist.linear and abs(orders.twist.angular) < STRAIGHT:
                    nearest = contact, frame
        visited, touched = FloorCover(world).share(course.path), tuple(course.touched())
        way = sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(course.path))
        cycles = tuple(1e3 * each for each in course.cycles[20:])
    if film is not None and out is not None:
        film.close()
        if nearest[1] is not None:
            cv2.imwrite(str(out / "optical-flow-frame.png"), nearest[1])
        walls = [block.footprint for block in (*world.walls, *world.furniture)]
        draw_wandering(out / "optical-flow.svg", record, f"{duration / 60:.0f} min by optical flow, seed {seed}", walls)
    return FlowScore(seed, touched, min(clean, duration), visited, way, cycles)


def figures(scores: Sequence[FlowScore]) -> list[Figure]:
    """Return the figures of several drives."""
    count = len(scores)
    cycles = [each for score in scores for each in score.cycles]
    touched = sum(bool(score.touched) for score in scores)
    worst = min(score.visited for score in scores)
    return [
        Figure(GROUP, f"rooms of {count} in which anything was touched", touched, count * TOUCHED, "", count),
        # A figure is reached from above, so these are what was not visited.
        Figure(GROUP, "free floor not visited, worst room", 1.0 - worst, 1.0 - VISITED, "", count),
        Figure(GROUP, "computation per cycle at 160x120, p50", percentile(cycles, 50), CYCLE_MS, "ms", len(cycles)),
        Figure(GROUP, "computation per cycle at 160x120, p95", percentile(cycles, 95), CYCLE_MS, "ms", len(cycles)),
    ]


def row(score: FlowScore) -> str:
    """Return one drive as a row of the table."""
    return (
        f"| {score.seed} | {score.clean / 60:.1f} | {100 * score.visited:.0f} | {score.way:.0f} "
        f"| {percentile(score.cycles, 50):.1f} | {percentile(score.cycles, 95):.1f} "
        f"| {'; '.join(score.touched) or 'nothing'} |"
    )


def page(scores: Sequence[FlowScore]) -> str:
    """Return a table of all drives."""
    head = (
        "| seed | min without contact | floor visited, % | way, m | cycle p50, ms | p95, ms | touched |\n"
        "|---|---|---|---|---|---|---|\n"
    )
    return "# Wandering by optical flow\n\n" + head + "\n".join(map(row, scores)) + "\n"

"""Drives of a benchmark by their seeds: which ones, how long, and in how many processes at the same time."""

import argparse
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from acromovi.process_pool import process_pool

Score = TypeVar("Score")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of benchmarks whose drives have seeds."""
    parser.add_argument(
        "--seeds",
        type=seeds_of,
        metavar="FIRST-LAST",
        help="seeds of optical_flow, following, fetch, formation and exploration: 20-39, or 20,25,31 (default: those "
        "of each)",
    )
    parser.add_argument(
        "--drive-minutes", type=float, help="length of a drive of optical_flow [10] and of a pair of following [5]"
    )
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count(), help="drives at the same time (default: number of processors)"
    )


def seeds_of(text: str) -> tuple[int, ...]:
    """Return the seeds that a text names: numbers and ranges, separated by commas.

    Raises:
        argparse.ArgumentTypeError: A part is neither a number nor a range that goes up.
    """
    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = part.partition("-")
        try:
            found = range(int(first), int(last if dash else first) + 1)
        except ValueError:
            found = range(0)
        if not found:
            raise argparse.ArgumentTypeError(f"{part!r} names no seeds; write 20-39 or 20,25,31")
        seeds += found
    return tuple(dict.fromkeys(seeds))


def seconds_of(options: argparse.Namespace, usual: float) -> float:
    """Return the length of a drive, s."""
    return usual if options.drive_minutes is None else 60.0 * options.drive_minutes


def drive_all(
    drive: Callable[[int, Path | None], Score],
    seeds: Sequence[int],
    options: argparse.Namespace,
    row: Callable[[Score], str],
) -> list[Score]:
    """Drive all seeds, several at the same time, and print the row of each.

    drive: takes a seed, and the folder into which it draws; None for all seeds but the first. It must be a function of
    a module, or a `partial` of one.
    """
    scores = []
    with process_pool(options.jobs) as pool:
        for score in pool.map(partial(_in_turn, drive, options.out, seeds[0]), seeds):
            print(f"     {row(score)}", flush=True)
            scores.append(score)
    return scores


def _in_turn(drive: Callable[[int, Path | None], Score], out: Path, drawn: int, seed: int) -> Score:
    return drive(seed, out if seed == drawn else None)

"""The page of missions on floors that nobody has seen: tuned and other families side by side, and every failure."""

import statistics
from collections.abc import Callable, Iterable, Sequence

from acromovi.missions.fresh import CONDITIONS, TUNED, FreshScore
from acromovi.missions.page import MEASURES, table
from acromovi.missions.report import fault

EASY = 0.15  # m beside the robot, from which on a way is easy
LENGTHS = tuple(MEASURES)[:3]  # of path and time


def fresh_page(results: Sequence[FreshScore], seed: int, pictures: Iterable[str] = ()) -> str:
    """Return a page in Markdown: tuned and other families, their difference, and every failure.

    Args:
        results: Of the missions.
        seed: Of their floors.
        pictures: Files beside the page, to be shown.
    """
    without = sum(not result.has_room for result in results)
    results = [result for result in results if result.has_room]
    parts = [
        "# Missions on fresh floors",
        f"Seeds from {seed}, with all errors of odometry and sensors. Parameters were tuned on the families "
        f"{', '.join(TUNED)} only. A mission is good when the goal is reached and nothing was touched."
        + (f" {without} of the missions have no room on their floors; they do not count." if without else ""),
        _sides(results),
        _lengths(results),
        _by("family", results, lambda result: result.job.family),
        _by("robot", results, lambda result: result.job.job.carrier),
        _failures(results),
        *(f"![{picture}]({picture})" for picture in pictures),
    ]
    return "\n\n".join(parts) + "\n"


def _sides(results: Sequence[FreshScore]) -> str:
    """Return the table of tuned and other families, and their difference."""
    rows = []
    for condition, name in CONDITIONS.items():
        for least, words in ((0.0, "all"), (EASY, f"≥ {100 * EASY:.0f} cm beside the robot")):
            here = [
                r
                for r in results
                if r.job.job.has_laser and r.job.job.condition is condition and (r.clearance or 0.0) >= least
            ]
            tuned, others = _apart(here)
            apart = f"{100 * (_share(tuned) - _share(others)):+.1f}" if tuned and others else "-"
            rows.append((name, words, _counted(tuned), _counted(others), apart))
    touched = sum(bool(result.verdict and result.verdict.touched) for result in results)
    rows.append(("all", "touched something", f"{touched} of {len(results)}", "", ""))
    return "## Tuned and other families\n\n" + table(
        ("condition", "ways", "tuned", "others", "difference, points"), rows
    )


def _apart(results: Sequence[FreshScore]) -> tuple[list[FreshScore], list[FreshScore]]:
    """Return the results on tuned families, and on the others."""
    return (
        [result for result in results if result.job.family in TUNED],
        [result for result in results if result.job.family not in TUNED],
    )


def _lengths(results: Sequence[FreshScore]) -> str:
    """Return the table of path and time, of the missions that were reached."""
    rows = []
    for condition, name in CONDITIONS.items():
        here = [r for r in results if r.job.job.condition is condition]
        tuned, others = _apart(here)
        rows += [(name, measure, _median(tuned, measure), _median(others, measure)) for measure in LENGTHS]
    head = ("condition", "median of the missions that were reached", "tuned", "others")
    return "## Path and time\n\n" + table(head, rows)


def _by(what: str, results: Sequence[FreshScore], key: Callable[[FreshScore], str]) -> str:
    """Return the table by family or by robot."""
    rows = []
    for value in dict.fromkeys(key(result) for result in results):
        here = [result for result in results if key(result) == value]
        cells = [_counted([r for r in here if r.job.job.condition is condition]) for condition in CONDITIONS]
        rows.append((value, *cells))
    return f"## By {what}\n\n" + table((what, *CONDITIONS.values()), rows)


def _failures(results: Sequence[FreshScore]) -> str:
    failed = [result for result in results if not result.is_good]
    if not failed:
        return "## Failures\n\nNone."
    rows = []
    for result in failed:
        room, reason = result.clearance, fault(result.why, result.verdict).replace("|", "/")
        beside = f"{100 * room:.0f} cm" if room is not None else "-"
        rows.append((result.job.name, beside, reason, f"`{result.job.command}`"))
    return "## Failures\n\n" + table(("mission", "beside the robot", "what", "again"), rows)


def _share(results: Sequence[FreshScore]) -> float:
    return sum(result.is_good for result in results) / max(len(results), 1)


def _counted(results: Sequence[FreshScore]) -> str:
    if not results:
        return "-"
    return f"{sum(result.is_good for result in results)} of {len(results)} ({_share(results):.0%})"


def _median(results: Sequence[FreshScore], measure: str) -> str:
    reached = [result.verdict for result in results if result.verdict is not None and result.verdict.reached]
    return f"{statistics.median(map(MEASURES[measure], reached)):.2f}" if reached else "-"

"""The table of many missions: what was asked for, what was seen, and how to see each failure again."""

import statistics
from collections.abc import Callable, Iterable, Sequence

from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.tasks import Case, Condition

STILL = (Condition.STATIC, Condition.ERROR)

Measure = Callable[[MissionVerdict], float]

MEASURES: dict[str, Measure] = {
    "path / shortest": lambda verdict: verdict.over_shortest,
    "time / path at cruising speed": lambda verdict: verdict.over_time,
    "time / shortest path at cruising speed": lambda verdict: verdict.over_best_time,
    "turned, rad/m": lambda verdict: verdict.turned,
    "turns per m": lambda verdict: verdict.turns,
    "jerk, m/s3": lambda verdict: verdict.jerk,
    "angular jerk, rad/s3": lambda verdict: verdict.angular_jerk,
}


def share_reached(results: Iterable[Result]) -> float:
    """Part of the missions that were reached, 0 to 1."""
    all_of_them = list(results)
    return sum(r.verdict is not None and r.verdict.reached for r in all_of_them) / max(len(all_of_them), 1)


def in_still_worlds(results: Iterable[Result]) -> list[Result]:
    """Those where nothing unexpected stands or walks about."""
    return [result for result in results if result.job.condition in STILL]


def in_busy_worlds(results: Iterable[Result]) -> list[Result]:
    """The others."""
    return [result for result in results if result.job.condition not in STILL]


def with_touches(results: Iterable[Result]) -> list[Result]:
    """Those in which the robot bumped into something."""
    return [result for result in results if result.verdict is not None and result.verdict.touched]


def median(results: Iterable[Result], measure: Measure) -> float:
    """Of the missions that were reached; infinite where none was."""
    values = [measure(r.verdict) for r in results if r.verdict is not None and r.verdict.reached]
    return statistics.median(values) if values else float("inf")


def in_common(results: Iterable[Result], others: Iterable[Result]) -> tuple[list[Result], list[Result]]:
    """Of two ways to play, the missions that both have reached."""
    ours, theirs = ({r.job: r for r in played if r.verdict and r.verdict.reached} for played in (results, others))
    jobs = [job for job in ours if job in theirs]
    return [ours[job] for job in jobs], [theirs[job] for job in jobs]


def page(results: Sequence[Result], others: Sequence[Result] = (), pictures: Iterable[str] = ()) -> str:
    """Markdown.

    Args:
        results: Of the navigation.
        others: Of the free-space-block method in the same missions, if it was played.
        pictures: Files beside the page, to be shown.
    """
    parts = ["# Missions of the indoor navigation", _asked(results, others), _cells(results), _failures(results)]
    parts += [f"![{picture}]({picture})" for picture in pictures]
    return "\n\n".join(parts) + "\n"


def _asked(results: Sequence[Result], others: Sequence[Result]) -> str:
    still, busy = in_still_worlds(results), in_busy_worlds(results)
    rows = [
        ("reached, static worlds", f"{share_reached(still):.1%} of {len(still)}", "≥ 99 %"),
        ("reached, with obstacles and people", f"{share_reached(busy):.1%} of {len(busy)}", "≥ 97 %"),
        ("missions that touched something", f"{len(with_touches(results))} of {len(results)}", "0"),
        ("path over the shortest path, median", f"{median(results, MEASURES['path / shortest']):.3f}", "≤ 1.15"),
        (
            "time over path at cruising speed, median",
            f"{median(results, MEASURES['time / path at cruising speed']):.3f}",
            "≤ 1.35",
        ),
    ]
    ours, theirs = in_common(results, others) if others else (list(results), [])
    for name in list(MEASURES)[3:]:
        said = f"less than {median(theirs, MEASURES[name]):.3f} (free-space-block)" if others else "-"
        rows.append((f"{name}, median", f"{median(ours, MEASURES[name]):.3f}", said))
    return _table(("what", "seen", "asked for"), rows)


def _cells(results: Sequence[Result]) -> str:
    rows = []
    for case in Case:
        for condition in Condition:
            here = [r for r in results if (r.job.case, r.job.condition) == (case, condition)]
            if here:
                figures = [f"{median(here, measure):.2f}" for measure in MEASURES.values()]
                reached = f"{share_reached(here):.0%} of {len(here)}"
                rows.append((str(case), str(condition), reached, str(len(with_touches(here))), *figures))
    head = ("case", "condition", "reached", "touched", *MEASURES)
    return "## By case and condition\n\n" + _table(head, rows)


def _failures(results: Sequence[Result]) -> str:
    failed = [result for result in results if not result.is_good]
    if not failed:
        return "## Failures\n\nNone."
    rows = [
        (result.job.robot, result.job.world, _why(result).replace("|", "/"), f"`{result.job.command}`")
        for result in failed
    ]
    return "## Failures\n\n" + _table(("robot", "world", "what", "again"), rows)


def _why(result: Result) -> str:
    """What went wrong, in a line."""
    if result.verdict is None:
        return f"crashed: {result.error.strip().splitlines()[-1]}"
    touched = f"touched {', '.join(result.verdict.touched)}" if result.verdict.touched else ""
    return "; ".join(filter(None, (result.verdict.why_not, touched)))


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)

"""The table of many missions: what was asked for, what was seen, and how to see each failure again."""

import statistics
from collections.abc import Callable, Iterable, Sequence

from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.report import fault, why

STILL = (Condition.STATIC, Condition.ERROR)

MEASURES: dict[str, Callable[[MissionVerdict], float]] = {
    "path / shortest": lambda verdict: verdict.over_shortest,
    "time / path at cruising speed": lambda verdict: verdict.over_time,
    "time / shortest path at cruising speed": lambda verdict: verdict.over_best_time,
    "turned, rad/m": lambda verdict: verdict.turned,
    "turns per m": lambda verdict: verdict.turns,
    "jerk, m/s3": lambda verdict: verdict.jerk,
    "angular jerk, rad/s3": lambda verdict: verdict.angular_jerk,
}


class Results(tuple[Result[Job], ...]):
    """Results of missions, and what is counted of them."""

    __slots__ = ()

    @property
    def share_reached(self) -> float:
        """Part of the missions that were reached, 0 to 1."""
        return len(self._reached) / max(len(self), 1)

    @property
    def still(self) -> "Results":
        """Those where nothing unexpected stands or walks about."""
        return Results(result for result in self if result.job.condition in STILL)

    @property
    def busy(self) -> "Results":
        """The others."""
        return Results(result for result in self if result.job.condition not in STILL)

    @property
    def with_touches(self) -> "Results":
        """Those in which the robot bumped into something."""
        return Results(result for result in self if result.verdict is not None and result.verdict.touched)

    def median(self, measure: str) -> float:
        """Of one of `MEASURES`, over the missions that were reached; infinite where none was."""
        values = [MEASURES[measure](verdict) for verdict in self._reached.values()]
        return statistics.median(values) if values else float("inf")

    def also_reached(self, others: "Results") -> "Results":
        """Of the missions that were reached, those that were reached in the others too, played in another way."""
        return Results(result for result in self if result.job in self._reached and result.job in others._reached)

    @property
    def _reached(self) -> dict[Job, MissionVerdict]:
        return {each.job: each.verdict for each in self if each.verdict is not None and each.verdict.reached}


def page(results: Sequence[Result[Job]], others: Sequence[Result[Job]] = (), pictures: Iterable[str] = ()) -> str:
    """Markdown.

    Args:
        results: Of the navigation.
        others: Of the free-space-block method in the same missions, if it was played.
        pictures: Files beside the page, to be shown.
    """
    all_of_them = Results(results)
    asked, cells = _asked(all_of_them, Results(others)), _cells(all_of_them)
    parts = ["# Missions of the indoor navigation", asked, cells, _failures(results)]
    parts += [f"![{picture}]({picture})" for picture in pictures]
    return "\n\n".join(parts) + "\n"


def _asked(results: Results, others: Results) -> str:
    still, busy = results.still, results.busy
    rows = [
        ("reached, static worlds", f"{still.share_reached:.1%} of {len(still)}", "≥ 99 %"),
        ("reached, with obstacles and people", f"{busy.share_reached:.1%} of {len(busy)}", "≥ 97 %"),
        ("missions that touched something", f"{len(results.with_touches)} of {len(results)}", "0"),
        ("path over the shortest path, median", f"{results.median('path / shortest'):.3f}", "≤ 1.15"),
        (
            "time over path at cruising speed, median",
            f"{results.median('time / path at cruising speed'):.3f}",
            "≤ 1.35",
        ),
    ]
    ours, theirs = (results.also_reached(others), others.also_reached(results)) if others else (results, others)
    for name in list(MEASURES)[3:]:
        said = f"less than {theirs.median(name):.3f} (free-space-block)" if others else "-"
        rows.append((f"{name}, median", f"{ours.median(name):.3f}", said))
    return table(("what", "seen", "asked for"), rows)


def _cells(results: Results) -> str:
    rows = []
    for case in Case:
        for condition in Condition:
            here = Results(r for r in results if (r.job.case, r.job.condition) == (case, condition))
            if here:
                figures = [f"{here.median(measure):.2f}" for measure in MEASURES]
                reached = f"{here.share_reached:.0%} of {len(here)}"
                rows.append((str(case), str(condition), reached, str(len(here.with_touches)), *figures))
    head = ("case", "condition", "reached", "touched", *MEASURES)
    return "## By case and condition\n\n" + table(head, rows)


def _failures(results: Sequence[Result[Job]]) -> str:
    failed = [result for result in results if not result.is_good]
    if not failed:
        return "## Failures\n\nNone."
    rows = [
        (
            result.job.robot,
            result.job.world,
            fault(why(result), result.verdict).replace("|", "/"),
            f"`{result.job.command}`",
        )
        for result in failed
    ]
    return "## Failures\n\n" + table(("robot", "world", "what", "again"), rows)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)

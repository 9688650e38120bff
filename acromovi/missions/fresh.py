"""Missions on floors that nobody has seen: seeds are drawn when they are played, and families are kept apart.

The parameters of the navigation may be tuned on the families `TUNED`, and on no others. What it reaches on the others,
and the difference, shows whether it is tuned to its own worlds.
"""

import secrets
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from acromovi.missions.jobs import Case, Condition, Job, half_width
from acromovi.missions.matrix import Result
from acromovi.missions.page import table
from acromovi.missions.report import why
from acromovi.missions.task import Task, clearance
from p2os_emu.world.floors.families import FAMILIES

TUNED = ("plan", "hall", "corridors", "flat")
OTHERS = tuple(family for family in FAMILIES if family not in TUNED)
CONDITIONS = {Condition.ERROR: "static", Condition.ALL: "people and boxes"}
WITH_LASER = ("p3dx-sh", "p2at", "powerbot")
SONAR = "p2dx"  # the robot that has no laser
EASY = 0.15  # m beside the robot, from which on a way is easy
_SEEDS = 1_000_000  # of floors; nobody has looked at many of them


@dataclass(frozen=True, slots=True)
class FreshMission:
    """A mission on a floor of a family."""

    family: str
    job: Job

    @property
    def robot(self) -> str:
        """The model."""
        return self.job.robot

    @property
    def world(self) -> str:
        """The floor."""
        return self.job.world

    @property
    def command(self) -> str:
        """What to type to play it again."""
        return self.job.command

    @property
    def name(self) -> str:
        """For lists."""
        return f"{self.world} {CONDITIONS[self.job.condition]}, {self.job.case}, {self.job.carrier}"

    def task(self) -> Task:
        """Choose start, goal, obstacles and people, and find the widest way."""
        task = self.job.task()
        room = clearance(task.world, (task.start.x, task.start.y), task.goal, half_width(self.robot))
        return replace(task, clearance=room)


def fresh_seed() -> int:
    """Return a seed that nobody has chosen."""
    return secrets.randbelow(_SEEDS)


def fresh_missions(seed: int, floors: int) -> list[FreshMission]:
    """Return missions of all families, robots and conditions.

    Args:
        seed: Of the floors; the same missions for the same one.
        floors: For each family, robot and condition.
    """
    robots = (SONAR, *WITH_LASER)
    missions = []
    for family in FAMILIES:
        for number in range(floors):
            for place, robot in enumerate(robots):
                at = seed + len(robots) * number + place
                case = list(Case)[(number + place) % len(Case)]
                job = Job(case, Condition.ERROR, at, robot, f"{family}:{at}", has_laser=robot != SONAR)
                missions += [FreshMission(family, replace(job, condition=condition)) for condition in CONDITIONS]
    return missions


FreshResult = Result[FreshMission]


def fresh_page(results: Sequence[FreshResult], seed: int, pictures: Iterable[str] = ()) -> str:
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
        + (f" {without} floors have no room for such a mission; they do not count." if without else ""),
        _sides(results),
        _by("family", results, lambda result: result.job.family),
        _by("robot", results, lambda result: result.job.job.carrier),
        _failures(results),
        *(f"![{picture}]({picture})" for picture in pictures),
    ]
    return "\n\n".join(parts) + "\n"


def _sides(results: Sequence[FreshResult]) -> str:
    """Return the table of tuned and other families, and their difference."""
    rows = []
    for condition, name in CONDITIONS.items():
        for least, words in ((0.0, "all"), (EASY, f"≥ {100 * EASY:.0f} cm beside the robot")):
            here = [
                r
                for r in results
                if r.job.job.has_laser and r.job.job.condition is condition and (_room(r) or 0.0) >= least
            ]
            tuned = [result for result in here if result.job.family in TUNED]
            others = [result for result in here if result.job.family not in TUNED]
            apart = f"{100 * (_share(tuned) - _share(others)):+.1f}" if tuned and others else "-"
            rows.append((name, words, _counted(tuned), _counted(others), apart))
    touched = sum(bool(result.verdict and result.verdict.touched) for result in results)
    rows.append(("all", "touched something", f"{touched} of {len(results)}", "", ""))
    return "## Tuned and other families\n\n" + table(
        ("condition", "ways", "tuned", "others", "difference, points"), rows
    )


def _by(what: str, results: Sequence[FreshResult], key: Callable[[FreshResult], str]) -> str:
    """Return the table by family or by robot."""
    rows = []
    for value in dict.fromkeys(key(result) for result in results):
        here = [result for result in results if key(result) == value]
        cells = [_counted([r for r in here if r.job.job.condition is condition]) for condition in CONDITIONS]
        rows.append((value, *cells))
    return f"## By {what}\n\n" + table((what, *CONDITIONS.values()), rows)


def _failures(results: Sequence[FreshResult]) -> str:
    failed = [result for result in results if not result.is_good]
    if not failed:
        return "## Failures\n\nNone."
    rows = []
    for result in failed:
        room = _room(result)
        touched = ", ".join(result.verdict.touched) if result.verdict is not None else ""
        reason = "; ".join(filter(None, (why(result), touched and f"touched {touched}"))).replace("|", "/")
        beside = f"{100 * room:.0f} cm" if room is not None else "-"
        rows.append((result.job.name, beside, reason, f"`{result.job.command}`"))
    return "## Failures\n\n" + table(("mission", "beside the robot", "what", "again"), rows)


def _room(result: FreshResult) -> float | None:
    return result.task.clearance if result.task is not None else None


def _share(results: Sequence[FreshResult]) -> float:
    return sum(result.is_good for result in results) / max(len(results), 1)


def _counted(results: Sequence[FreshResult]) -> str:
    if not results:
        return "-"
    return f"{sum(result.is_good for result in results)} of {len(results)} ({_share(results):.0%})"

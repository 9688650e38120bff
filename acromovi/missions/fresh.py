"""Missions on floors that nobody has seen: seeds are drawn when they are played, and families are kept apart.

The parameters of the navigation may be tuned on the families `TUNED`, and on no others. What it reaches on the others,
and the difference, shows whether it is tuned to its own worlds.
"""

import secrets
from dataclasses import dataclass, replace

from acromovi.missions.jobs import Case, Condition, Job, half_width
from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.report import why
from acromovi.missions.task import Task, clearance
from p2os_emu.world.floors.families import FAMILIES

TUNED = ("plan", "hall", "corridors", "flat")
OTHERS = tuple(family for family in FAMILIES if family not in TUNED)
CONDITIONS = {Condition.ERROR: "static", Condition.ALL: "people and boxes"}
WITH_LASER = ("p3dx-sh", "p2at", "powerbot")
SONAR = "p2dx"  # the robot that has no laser
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


@dataclass(frozen=True, slots=True)
class FreshScore:
    """What is kept of a mission that has been played.

    clearance: of its task, m; None without one. verdict: None when it could not be played. why: it was not reached;
    empty where it was. has_room: whether the floor has a start and a goal for it.
    """

    job: FreshMission
    clearance: float | None
    verdict: MissionVerdict | None
    why: str
    has_room: bool

    @classmethod
    def of(cls, result: Result[FreshMission]) -> "FreshScore":
        """Return what is kept of a result."""
        clearance = result.task.clearance if result.task is not None else None
        return cls(result.job, clearance, result.verdict, why(result), result.has_room)

    @property
    def is_good(self) -> bool:
        """Reached, and nothing touched."""
        return self.verdict is not None and self.verdict.reached and not self.verdict.touched

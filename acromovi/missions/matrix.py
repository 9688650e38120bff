"""Many missions, spread over the cores of this machine; each the same whenever it is played."""

import math
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Generic, TypeVar

from acromovi.missions.course import Course
from acromovi.missions.judge import CRUISING, MissionVerdict, judge
from acromovi.missions.navigated_robot import Played
from acromovi.missions.task import Mission, NoRoom, Task
from acromovi.process_pool import process_pool
from apps.indoor_navigation.component import Component
from configs import ConfigError
from geometry import Pose2D
from p2os_emu.fit import FitError
from p2os_emu.world import WorldError

PATIENCE = 60.0  # s, beyond
SLOWNESS = 4.0  # times the time of the shortest way at cruising speed, after which a mission is late
KEPT = 5  # of so many samples of a path one is kept for pictures


M = TypeVar("M", bound=Mission)


@dataclass(frozen=True, slots=True)
class Result(Generic[M]):
    """A mission that has been played.

    task: None when there is no such mission. verdict: None when it could not be played; error then says why, with the
    traceback of a defect.
    path, believed: true, and as odometry had it, 4 Hz.
    has_room: whether the world has a start and a goal for it.
    told: what the navigation told the person. reports: what went wrong in its components.
    """

    job: M
    task: Task | None = None
    verdict: MissionVerdict | None = None
    path: tuple[Pose2D, ...] = ()
    believed: tuple[Pose2D, ...] = ()
    told: tuple[str, ...] = ()
    reports: tuple[str, ...] = ()
    error: str = ""
    has_room: bool = True

    @property
    def is_good(self) -> bool:
        """Reached, and nothing touched."""
        return self.verdict is not None and self.verdict.reached and not self.verdict.touched


Instead = Mapping[str, type[Component]]
"""Classes that take the place of components, by their names."""


def play(job: M, instead: Instead | None = None) -> Result[M]:
    """Play one mission; whatever is raised makes it a failed one."""
    task = None
    try:
        task = job.task()
        played = _perform(task, instead)
        return Result(
            job,
            task,
            judge(task, played),
            tuple(played.track.true[::KEPT]),
            tuple(played.track.believed[::KEPT]),
            played.told,
            played.reports,
        )
    except NoRoom as err:
        return Result(job, error=str(err), has_room=False)
    except (WorldError, ConfigError, FitError) as err:
        return Result(job, task, error=str(err))
    except Exception:
        return Result(job, task, error=traceback.format_exc())


def _perform(task: Task, instead: Instead | None = None) -> Played:
    """Let the robot do a task."""
    straight = math.dist((task.start.x, task.start.y), task.goal)
    limit = PATIENCE + SLOWNESS * (task.way.length if task.way is not None else straight) / CRUISING
    with Course(
        task.world,
        task.robot,
        fit=task.fit,
        start=task.start,
        seed=task.seed,
        perfect=task.is_perfect,
        instead=instead,
    ) as course:
        return course.go(task.goal, limit=limit)


def play_all(
    jobs: Sequence[M],
    on_result: Callable[[Result[M]], None] = lambda result: None,
    processes: int | None = None,
    instead: Instead | None = None,
) -> list[Result[M]]:
    """Play missions on all cores.

    Args:
        jobs: What is played.
        on_result: Told of each as it ends.
        processes: How many play at once; by default one for each core.
        instead: Classes that take the place of components, by their names.
    Returns:
        In the order of the jobs.
    """
    results: dict[int, Result[M]] = {}
    with process_pool(processes) as pool:
        under_way = {pool.submit(play, job, instead): number for number, job in enumerate(jobs)}
        futures: Iterable[Future[Result[M]]] = as_completed(under_way)
        for future in futures:
            number = under_way[future]
            try:
                results[number] = future.result()
            except BrokenProcessPool as err:
                results[number] = Result(jobs[number], error=f"the process that played it has died: {err}")
            on_result(results[number])
    return [results[number] for number in range(len(jobs))]

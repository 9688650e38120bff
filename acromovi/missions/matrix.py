"""Many missions, spread over the cores of this machine; each the same whenever it is played."""

import multiprocessing
import os
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

from acromovi.missions.course import Course, Played
from acromovi.missions.judge import CRUISING, MissionVerdict, judge
from acromovi.missions.tasks import ROBOTS, Job, Task
from apps.indoor_navigation.component import Component
from geometry import Pose2D

PATIENCE = 60.0  # s, beyond
SLOWNESS = 4.0  # times the time of the shortest way at cruising speed, after which a mission is late
KEPT = 5  # of so many samples of a path one is kept for pictures


@dataclass(frozen=True, slots=True)
class Result:
    """A mission that has been played.

    task, verdict: None when it crashed; error then holds the traceback.
    path, believed: true, and as odometry had it, 4 Hz.
    told: what the navigation told the person. reports: what went wrong in its components.
    """

    job: Job
    task: Task | None = None
    verdict: MissionVerdict | None = None
    path: tuple[Pose2D, ...] = ()
    believed: tuple[Pose2D, ...] = ()
    told: tuple[str, ...] = ()
    reports: tuple[str, ...] = ()
    error: str = ""

    @property
    def is_good(self) -> bool:
        """Reached, and nothing touched."""
        return self.verdict is not None and self.verdict.reached and not self.verdict.touched


Instead = Mapping[str, type[Component]]
"""Classes that take the place of components, by their names."""


def play(job: Job, instead: Instead | None = None) -> Result:
    """Play one mission; whatever is raised makes it a failed one."""
    try:
        task = Task.of(job)
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
    except Exception:
        return Result(job, error=traceback.format_exc())


def _perform(task: Task, instead: Instead | None = None) -> Played:
    """Let the robot do a task."""
    job = task.job
    limit = PATIENCE + SLOWNESS * task.way.length / CRUISING
    perfect = job.condition.is_perfect
    fit = ROBOTS[job.robot]
    with Course(task.world, job.robot, fit=fit, seed=job.seed, perfect=perfect, instead=instead) as course:
        return course.go(task.goal, limit=limit)


def play_all(
    jobs: Sequence[Job],
    on_result: Callable[[Result], None] = lambda result: None,
    processes: int | None = None,
    instead: Instead | None = None,
) -> list[Result]:
    """Play missions on all cores.

    Args:
        jobs: What is played.
        on_result: Told of each as it ends.
        processes: How many play at once; by default one for each core.
        instead: Classes that take the place of components, by their names.
    Returns:
        In the order of the jobs.
    """
    results = {}
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes or os.cpu_count(), spawn, _be_one_core) as pool:
        under_way = {pool.submit(play, job, instead): job for job in jobs}
        for result in _ended(under_way):
            results[result.job] = result
            on_result(result)
    return [results[job] for job in jobs]


def _ended(under_way: dict["Future[Result]", Job]) -> Iterator[Result]:
    futures: Iterable[Future[Result]] = as_completed(under_way)
    for future in futures:
        try:
            yield future.result()
        except BrokenProcessPool as err:
            yield Result(under_way[future], error=f"the process that played it has died: {err}")


def _be_one_core() -> None:
    """Each process has a core of its own: no threads of numpy's beside it."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"

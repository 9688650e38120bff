"""Pictures of played missions say what is drawn, and in which unit."""

from pathlib import Path

import pytest

from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.matrix import Result
from acromovi.missions.picture import draw_mission
from geometry import Pose2D

LEGEND = ("walls", "furniture", "obstacles", "ways of people", "start", "goal")


@pytest.fixture(scope="module")
def result() -> Result[Job]:
    """A mission with all that there is to see, that nobody has played."""
    job = Job(Case.ROOMS, Condition.ALL, 3, "p3at-sh", "office")
    task = job.task()
    return Result(job, task=task, path=(task.start, Pose2D(*task.goal, 0.0)))


def test_a_mission_has_labels_and_a_whole_legend(result: Result[Job], tmp_path: Path) -> None:
    draw_mission(tmp_path / "mission.svg", result)
    drawn = (tmp_path / "mission.svg").read_text(encoding="utf-8")
    for what in (*LEGEND, "path", "as odometry has it", "shortest way", "x, m", "y, m"):
        assert f"<!-- {what} -->" in drawn, what

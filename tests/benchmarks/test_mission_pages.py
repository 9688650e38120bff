"""Pages of played missions say what is drawn, and at which scale."""

from pathlib import Path

import pytest

from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.matrix import Result
from benchmarks.mission_pages import draw_grid, draw_sheet
from geometry import Pose2D

LEGEND = ("walls", "furniture", "obstacles", "ways of people", "start", "goal")


@pytest.fixture(scope="module")
def result() -> Result[Job]:
    """A mission with all that there is to see, that nobody has played."""
    job = Job(Case.ROOMS, Condition.ALL, 3, "p3at-sh", "office")
    task = job.task()
    return Result(job, task=task, path=(task.start, Pose2D(*task.goal, 0.0)))


@pytest.mark.parametrize("sheet", [True, False])
def test_a_page_of_missions_has_a_legend_and_a_scale(result: Result[Job], tmp_path: Path, sheet: bool) -> None:
    file = tmp_path / "page.svg"
    if sheet:
        draw_sheet(file, [result], "office")
    else:
        draw_grid(file, [result])
    drawn = file.read_text(encoding="utf-8")
    assert "a bar is 2 m -->" in drawn
    for what in (*LEGEND, "path, reached", "path, failed"):
        assert f"<!-- {what} -->" in drawn, what

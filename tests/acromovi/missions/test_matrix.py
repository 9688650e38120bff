import signal
import subprocess
import sys
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.matrix import Result, play, play_all
from acromovi.missions.page import page
from acromovi.missions.task import Task
from tests.waiting import end_of, exit_code, wait_until

SHORT = Job.of(Case.ROOM, Condition.ERROR, 0)
NOWHERE = Job.of(Case.ROOM, Condition.STATIC, 0, world="nowhere")


class Crashing(Job):
    """A job with a defect."""

    def task(self) -> Task:
        raise RuntimeError("a defect")


def test_mission_that_crashes_has_failed_and_keeps_its_traceback() -> None:
    result = play(Crashing.of(Case.ROOM, Condition.STATIC, 0))
    assert not result.is_good
    assert "Traceback" in result.error
    assert "a defect" in result.error


def test_mission_in_a_world_that_does_not_exist_has_failed_with_a_sentence() -> None:
    result = play(NOWHERE)
    assert not result.is_good
    assert result.error.startswith("there is no 'nowhere' among the worlds")


def test_page_tells_of_each_failure_how_to_see_it_again() -> None:
    text = page([play(NOWHERE)])
    assert f"`{NOWHERE.command}`" in text
    assert "not played: " in text


def test_page_of_nothing_but_good_missions_has_no_failures() -> None:
    assert "None." in page([])


def test_same_mission_ends_the_same_in_another_process() -> None:
    here, (there,) = play(SHORT), play_all([SHORT], processes=1)
    assert here == there
    assert repr(here) == repr(there)


def children(pid: int) -> list[str]:
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


def threads(pid: str) -> int:
    return len(list(Path(f"/proc/{pid}/task").iterdir()))


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGKILL, -signal.SIGKILL)])
def test_when_the_command_ends_early_no_process_plays_on(number: signal.Signals, code: int, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "acromovi", "missions", "--fresh", "1", "--workers", "2", "--out", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        wait_until(lambda: len([child for child in children(process.pid) if threads(child) > 1]) == 2, "two play")
        begun = children(process.pid)
        process.send_signal(number)
        assert exit_code(process) == code
        wait_until(lambda: not any(Path(f"/proc/{child}").exists() for child in begun), "all have ended")
        _, complaints = end_of(process)
    assert "Traceback" not in complaints


def test_smoke_missions_are_all_reached(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["missions", "--smoke"]) == 0, capsys.readouterr().out


def test_one_mission_is_played_told_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "mission.svg"
    assert main(["missions", "--picture", str(picture)]) == 0
    assert "of the shortest way" in capsys.readouterr().out
    assert picture.read_text(encoding="utf-8").startswith("<?xml")


def test_robot_that_there_is_not_is_refused_with_those_that_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["missions", "--robot", "p3dz"]) == 2
    error = capsys.readouterr().err
    assert "there is no 'p3dz' among the robots" in error
    assert "p3dx" in error


def test_result_without_verdict_is_not_good() -> None:
    assert not Result(SHORT).is_good

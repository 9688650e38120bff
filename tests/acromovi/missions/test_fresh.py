"""Missions on floors that nobody has seen: what is played, and what the page says of it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.missions.fresh import OTHERS, SONAR, TUNED, WITH_LASER, FreshMission, FreshScore, fresh_missions
from acromovi.missions.fresh_page import fresh_page
from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.results_file import ResultsFile
from acromovi.missions.task import Task
from geometry import Pose2D
from p2os_emu.world import WorldSpec
from p2os_emu.world.floors.families import FAMILIES

GOOD = MissionVerdict(True, "", (), 0.1, 0.0, 10.0, 4.0, 1.0, 1.2, 1.2, 0.1, 0.1, 1.0, 1.0)
LATE = replace(GOOD, reached=False, why_not="it ended as late")
TOUCHED = replace(GOOD, touched=("a wall",))


def score(family: str, condition: Condition, verdict: MissionVerdict, room: float = 0.2) -> FreshScore:
    mission = FreshMission(family, Job(Case.ROOM, condition, 3, "p2dx", f"{family}:3"))
    task = Task(WorldSpec("test", starts=(Pose2D(),)), "p2dx", "laser", (1.0, 0.0), None, clearance=room)
    return FreshScore.of(Result(mission, task, verdict))


def test_missions_are_of_all_families_robots_and_conditions_and_one_robot_has_no_laser() -> None:
    missions = fresh_missions(1000, 2)
    assert {mission.family for mission in missions} == set(FAMILIES) == {*TUNED, *OTHERS}
    assert {mission.robot for mission in missions} == {*WITH_LASER, SONAR}
    assert {mission.job.condition for mission in missions} == {Condition.ERROR, Condition.ALL}
    blind = [mission for mission in missions if not mission.job.has_laser]
    assert {mission.robot for mission in blind} == {SONAR}
    assert all(mission.command.endswith("--no-laser") for mission in blind)
    assert len(missions) == len({mission.name for mission in missions}) == len(FAMILIES) * 2 * 2 * (len(WITH_LASER) + 1)


def test_missions_are_the_same_by_the_same_seed_and_others_by_another() -> None:
    assert fresh_missions(7, 1) == fresh_missions(7, 1)
    assert not set(fresh_missions(7, 1)) & set(fresh_missions(700, 1))


@pytest.mark.parametrize("family", ["culs", "store"])
def test_a_mission_says_how_much_room_there_is_on_its_widest_way(family: str) -> None:
    mission = next(each for each in fresh_missions(5, 1) if each.family == family and not each.job.has_laser)
    task = mission.task()
    assert task.fit == ""
    assert task.clearance is not None
    assert task.clearance >= 0.06


def test_page_shows_tuned_and_other_families_their_difference_and_each_failure() -> None:
    scores = [
        score("plan", Condition.ERROR, GOOD),
        score("hall", Condition.ERROR, GOOD),
        score("desks", Condition.ERROR, GOOD),
        score("store", Condition.ERROR, LATE, 0.08),
        score("skew", Condition.ALL, TOUCHED),
    ]
    page = fresh_page(scores, 17, ["failed.png"])
    assert "| static | all | 2 of 2 (100%) | 1 of 2 (50%) | +50.0 |" in page
    assert "| static | ≥ 15 cm beside the robot | 2 of 2 (100%) | 1 of 1 (100%) | +0.0 |" in page
    assert "| all | touched something | 1 of 5 |" in page
    assert "store:3 static, room, p2dx | 8 cm | it ended as late |" in page
    assert "touched a wall" in page
    assert "`acromovi missions --case room --condition error --seed 3 --robot p2dx --world store:3`" in page
    assert "![failed.png](failed.png)" in page
    assert "None." in fresh_page(scores[:3], 17)


def test_page_shows_medians_of_path_and_time_of_what_was_reached() -> None:
    longer = replace(GOOD, over_shortest=1.1, over_time=1.3, over_best_time=1.43)
    scores = [score("plan", Condition.ERROR, each) for each in (GOOD, longer, longer, LATE)]
    page = fresh_page(scores, 17)
    assert "| static | path / shortest | 1.10 | - |" in page
    assert "| static | time / path at cruising speed | 1.30 | - |" in page
    assert "| static | time / shortest path at cruising speed | 1.43 | - |" in page


def test_missions_without_room_on_their_floors_do_not_count() -> None:
    good = score("plan", Condition.ERROR, GOOD)
    page = fresh_page([good, replace(good, verdict=None, why="no room", has_room=False)], 17)
    assert "| static | all | 1 of 1 (100%) |" in page
    assert "1 of the missions have no room" in page


def test_a_run_that_was_interrupted_goes_on_with_the_missions_that_were_not_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    missions = fresh_missions(7, 1)
    with ResultsFile(tmp_path / "fresh.jsonl", FreshScore, resume=False) as kept:
        kept.add(FreshScore(mission, 0.2, GOOD, "", True) for mission in missions[3:])
    played: list[FreshMission] = []

    def play_many(
        jobs: Sequence[FreshMission], *, processes: int | None, on_result: Callable[[Result[FreshMission]], None]
    ) -> None:
        played.extend(jobs)
        for job in jobs:
            on_result(Result(job, error="no room", has_room=False))

    monkeypatch.setattr("acromovi.missions.command.play_many", play_many)
    words = ["missions", "--fresh", "7", "--out", str(tmp_path), "--resume"]
    assert main(words) == 0
    assert played == missions[:3]
    assert "3 of the missions have no room" in (tmp_path / "fresh.md").read_text(encoding="utf-8")
    played.clear()
    assert main(words) == 0
    assert not played
    assert main(words[:-1]) == 0
    assert played == missions


@pytest.mark.parametrize(
    ("words", "why"),
    [(["--fresh", "--resume"], "--resume needs the seed"), (["--resume"], "is for a run with --fresh")],
)
def test_a_run_is_resumed_by_its_seed_only(words: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["missions", *words]) == 2
    assert why in capsys.readouterr().err

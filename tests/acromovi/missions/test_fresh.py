"""Missions on floors that nobody has seen: what is played, and what the page says of it."""

from dataclasses import replace

import pytest

from acromovi.missions.fresh import OTHERS, SONAR, TUNED, WITH_LASER, FreshMission, fresh_missions, fresh_page
from acromovi.missions.jobs import Case, Condition, Job
from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.task import Task
from geometry import Pose2D
from p2os_emu.world import WorldSpec
from p2os_emu.world.floors.families import FAMILIES

GOOD = MissionVerdict(True, "", (), 0.1, 0.0, 10.0, 4.0, 1.0, 1.2, 1.2, 0.1, 0.1, 1.0, 1.0)
LATE = replace(GOOD, reached=False, why_not="it ended as late")
TOUCHED = replace(GOOD, touched=("a wall",))


def result(family: str, condition: Condition, verdict: MissionVerdict, room: float = 0.2) -> Result[FreshMission]:
    job = Job(Case.ROOM, condition, 3, "p2dx", f"{family}:3")
    task = Task(WorldSpec("test", starts=(Pose2D(),)), "p2dx", "laser", (1.0, 0.0), None, clearance=room)
    return Result(FreshMission(family, job), task, verdict)


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
    results = [
        result("plan", Condition.ERROR, GOOD),
        result("hall", Condition.ERROR, GOOD),
        result("desks", Condition.ERROR, GOOD),
        result("store", Condition.ERROR, LATE, 0.08),
        result("skew", Condition.ALL, TOUCHED),
    ]
    page = fresh_page(results, 17, ["failed.png"])
    assert "| static | all | 2 of 2 (100%) | 1 of 2 (50%) | +50.0 |" in page
    assert "| static | ≥ 15 cm beside the robot | 2 of 2 (100%) | 1 of 1 (100%) | +0.0 |" in page
    assert "| all | touched something | 1 of 5 |" in page
    assert "store:3 static, room, p2dx | 8 cm | it ended as late |" in page
    assert "touched a wall" in page
    assert "`acromovi missions --case room --condition error --seed 3 --robot p2dx --world store:3`" in page
    assert "![failed.png](failed.png)" in page
    assert "None." in fresh_page(results[:3], 17)


def test_floors_without_room_for_a_mission_do_not_count() -> None:
    good = result("plan", Condition.ERROR, GOOD)
    page = fresh_page([good, replace(good, verdict=None, error="no room", has_room=False)], 17)
    assert "| static | all | 1 of 1 (100%) |" in page
    assert "1 floors have no room" in page

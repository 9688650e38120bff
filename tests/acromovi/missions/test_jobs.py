import math
from dataclasses import replace

import pytest

import configs
from acromovi.missions.jobs import ROBOTS, Case, Condition, Job
from p2os import RobotModel
from p2os_emu.world.free_space import FreeSpace


def test_matrix_has_three_hundred_missions_with_all_robots_in_both_kinds_of_world() -> None:
    jobs = Job.matrix()
    assert len(jobs) == len(set(jobs)) == 300
    assert {job.robot for job in jobs} == set(ROBOTS)
    for robot in ROBOTS:
        worlds = [job.world for job in jobs if job.robot == robot]
        assert 0 < sum(world == "house" for world in worlds) < len(worlds)


@pytest.mark.parametrize("condition", Condition)
def test_same_job_is_the_same_task(condition: Condition) -> None:
    job = Job.of(Case.ROOMS, condition, 3)
    assert job.task() == job.task()


def test_conditions_of_one_seed_share_start_and_goal() -> None:
    tasks = [Job.of(Case.CORRIDOR, condition, 2).task() for condition in Condition]
    assert len({(task.start, task.goal) for task in tasks}) == 1


@pytest.mark.parametrize("case", Case)
@pytest.mark.parametrize("seed", [0, 1, 2, 7])
def test_every_mission_is_possible_whatever_stands_in_the_way(case: Case, seed: int) -> None:
    task = Job.of(case, Condition.ALL, seed).task()
    model = configs.load(RobotModel, "robots", task.robot)
    assert task.way is not None
    assert FreeSpace(task.world, model.width / 2).has_way(task.way.points)
    assert math.dist(task.way.points[0], (task.start.x, task.start.y)) == 0.0
    assert task.way.points[-1] == task.goal
    assert task.world.objects
    assert len(task.world.people) >= 2


def test_a_person_who_does_not_fit_on_the_robot_s_way_walks_elsewhere() -> None:
    job = Job(Case.ROOMS, Condition.ALL, 9514, "p2at", "glass:9514")
    assert len(job.task().world.people) >= 2


def test_mission_in_a_room_passes_no_door_and_one_into_another_room_two() -> None:
    for seed in range(3):
        for case, passes in ((Case.ROOM, False), (Case.ROOMS, True)):
            task = Job.of(case, Condition.STATIC, seed).task()
            assert task.way is not None
            space = FreeSpace(replace(task.world, furniture=()), 0.65)
            assert passes != space.has_way((task.way.points[0], task.goal))


def test_command_of_a_job_names_what_is_unusual() -> None:
    assert Job.of(Case.ROOM, Condition.ALL, 5).command == "acromovi missions --case room --condition all --seed 5"
    assert Job.of(Case.ROOM, Condition.ALL, 2, "p2dx", "house").command.endswith("--seed 2 --robot p2dx")


def test_world_without_rooms_is_refused_in_a_sentence() -> None:
    with pytest.raises(ValueError, match="choose another world"):
        Job.of(Case.ROOM, Condition.STATIC, 0, world="empty").task()

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from acromovi.missions.jobs import Condition
from acromovi.missions.judge import judge
from acromovi.missions.navigated_robot import Played, Track
from acromovi.missions.task import Task
from geometry import Pose2D
from p2os_emu.world import WorldSpec
from p2os_emu.world.shortest_path import Path
from p2os_emu.world.spec import Block

PERIOD = 0.05


def straight(speed: float = 0.5, far: float = 4.0) -> Track:
    path = [Pose2D(speed * PERIOD * i) for i in range(round(far / speed / PERIOD) + 1)]
    return Track(path, list(path))


def task(condition: Condition = Condition.STATIC, goal: tuple[float, float] = (4.0, 0.0), wall: float = 9.0) -> Task:
    world = WorldSpec("test", walls=(Block(wall, 0.0, 0.0, 0.1, 4.0, 2.0, "a wall"),))
    return Task(world, "p2dx", "", goal, Path(((0.0, 0.0), goal)), is_perfect=condition.is_perfect)


def test_straight_drive_at_cruising_speed_is_the_measure_of_all() -> None:
    verdict = judge(task(), Played("done", 8.0, straight()))
    assert verdict.reached
    assert verdict.length == pytest.approx(4.0)
    assert verdict.over_shortest == pytest.approx(1.0)
    assert verdict.over_time == pytest.approx(1.0)
    assert verdict.turned == verdict.turns == 0.0
    assert verdict.jerk == pytest.approx(0.0, abs=1e-6)


def test_mission_is_not_reached_when_the_robot_only_says_so() -> None:
    verdict = judge(task(goal=(5.0, 0.0)), Played("done", 8.0, straight()))
    assert not verdict.reached
    assert "1.00 m away" in verdict.why_not


def test_mission_that_ends_otherwise_is_told_with_the_last_that_the_navigation_said() -> None:
    verdict = judge(task(), Played("failed", 8.0, straight(), told=("7.9 s path_planning: no way leads there",)))
    assert not verdict.reached
    assert verdict.why_not.endswith("no way leads there")


def test_odometry_excuses_what_it_is_off() -> None:
    track = straight(far=2.5)
    track.believed = [replace(pose, x=pose.x + 1.0) for pose in track.true]
    played = Played("done", 5.0, track)
    assert not judge(task(), played).reached
    assert judge(task(Condition.ERROR), played).reached
    assert not judge(task(Condition.ERROR, goal=(4.6, 0.0)), played).reached


def test_odometry_does_not_excuse_the_wrong_room() -> None:
    verdict = judge(task(Condition.ERROR, goal=(4.9, 0.0), wall=4.5), Played("done", 8.0, straight()))
    assert "a wall is between" in verdict.why_not


def test_turns_count_changes_of_sense_and_no_trifles() -> None:
    headings = [0.0, 0.3, 0.6, 0.58, 0.7, 0.2, -0.2, 0.0]
    track = Track([Pose2D(0.1 * i, 0.0, heading) for i, heading in enumerate(headings)])
    assert track.turns == 3
    assert track.turned == pytest.approx(sum(abs(b - a) for a, b in pairwise(headings)))
    assert track.length == pytest.approx(0.7)


def test_jerk_is_that_of_the_motion() -> None:
    """Of x = sin(t), the third derivative is -cos(t)."""
    track = Track([Pose2D(math.sin(PERIOD * i)) for i in range(round(2 * math.tau / PERIOD))])
    along, about = track.jerks
    assert along == pytest.approx(math.sqrt(0.5), rel=0.02)
    assert about == 0.0

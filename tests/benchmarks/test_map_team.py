"""How the goals of a team are shared out and scored; robots and floor are played."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from acromovi.missions.navigated_robot import Played, Track
from benchmarks.map_course import FloorJob, GoalScore, MapCondition
from benchmarks.map_team import LIMIT, PER_METRE, TeamRun, figures
from geometry import Point, Pose2D

WAY = 5.0  # m to each goal


class PlayedRobot:
    """A robot that is at its goal after so many seconds."""

    def __init__(self, name: str, needs: float) -> None:
        self.name, self.needs = name, needs
        self.pose, self.seconds = Pose2D(), 0.0
        self.goal: Point = 0.0, 0.0

    def tell(self, goal: Point, *, mission: str, on_map: bool) -> None:
        assert on_map
        self.goal, self.mission, self.seconds = goal, mission, 0.0

    def ended(self, mission: str) -> str | None:
        assert mission == self.mission
        return "done" if self.seconds >= self.needs else None

    def played(self, state: str, seconds: float) -> Played:
        self.pose = Pose2D(*self.goal) if state == "done" else self.pose
        return Played(state, seconds, Track())


class PlayedFloor:
    """Goals lie on a line. taken: for each goal, those of other robots at that time."""

    def __init__(self, goals: int, robots: Sequence[PlayedRobot], touches: int = 0) -> None:
        self.job = FloorJob("plan:1", 1, MapCondition.TEAM, goals)
        self.robots = robots
        self.taken: list[list[Point]] = []
        self.full_until = 0.0
        self.lockstep = SimpleNamespace(
            time=0.0, world=SimpleNamespace(touches=lambda name: SimpleNamespace(count=touches))
        )

    def run(self, seconds: float) -> None:
        self.lockstep.time += seconds
        for robot in self.robots:
            robot.seconds += seconds

    def goal(self, robot: PlayedRobot, taken: Sequence[Point]) -> tuple[Point, float]:
        if self.full_until > self.lockstep.time:
            raise ValueError("no goal")
        self.taken.append(list(taken))
        return (3.0 * len(self.taken), 0.0), WAY


def played(floor: Any) -> TeamRun:
    run = TeamRun(floor)
    run.play()
    return run


def test_a_robot_that_is_there_takes_the_next_goal_of_the_list_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    floor = PlayedFloor(7, [PlayedRobot("quick", 10.0), PlayedRobot("slow", 25.0)])
    scores = played(floor).scores
    assert sorted(score.number for score in scores) == list(range(7))
    assert [sum(score.robot == name for score in scores) for name in ("quick", "slow")] == [5, 2]
    assert all(score.is_reached for score in scores)
    assert "goal 6 of quick" in capsys.readouterr().out


def test_goals_and_standing_places_of_other_robots_are_taken() -> None:
    floor = PlayedFloor(3, [PlayedRobot("quick", 10.0), PlayedRobot("slow", 25.0)])
    played(floor)
    assert floor.taken[0] == [(0.0, 0.0)]  # nobody is under way yet
    assert floor.taken[1] == [(3.0, 0.0)]
    assert (6.0, 0.0) in floor.taken[2]


def test_robots_wait_for_a_goal_while_there_is_no_free_one() -> None:
    floor = PlayedFloor(2, [PlayedRobot("quick", 10.0)])
    floor.full_until = 5.0
    assert [score.is_reached for score in played(floor).scores] == [True, True]
    assert floor.lockstep.time == pytest.approx(26.0, abs=0.5)


def test_a_floor_without_free_goals_is_an_error() -> None:
    floor = PlayedFloor(2, [PlayedRobot("quick", 10.0)])
    floor.full_until = 1e9
    with pytest.raises(ValueError, match="no goal"):
        played(floor)


def test_a_robot_that_never_arrives_is_late_and_counts_as_missed() -> None:
    floor = PlayedFloor(2, [PlayedRobot("quick", 10.0), PlayedRobot("stuck", 1e6)], touches=1)
    run = played(floor)
    late = next(score for score in run.scores if score.robot == "stuck")
    assert isinstance(late, GoalScore)
    assert late.why == "it ended as late"
    assert late.seconds >= LIMIT + PER_METRE * WAY
    values = {figure.name.rpartition(": ")[2]: figure.value for figure in figures(floor.job, run)}
    assert values["goals not reached"] == 1
    assert values["contacts"] == 2

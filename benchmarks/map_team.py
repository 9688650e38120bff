"""Seven robots with a map in one building, in lockstep, judged by the truth; writes map-team.json and map-team.png.

The robots take goals from one list. A robot that has reached its goal takes the next one at once, so all of them drive
until the list is empty.
"""

import argparse
import json
import math
import statistics
from dataclasses import dataclass

from acromovi.missions.course import LOOK
from acromovi.missions.navigated_robot import NavigatedRobot
from benchmarks.figures import Figure
from benchmarks.map_course import FloorJob, GoalScore, MapCondition, MapFloor, why_missed
from benchmarks.map_navigation import as_row, draw
from geometry import Point, Pose2D
from p2os_emu.emulator import STEP

GROUP = "map_team"
FIRST_SEED = 950  # the navigation was tried on seeds below 100
FAMILIES = ("plan", "hall")
TEAM = ("happy", "grumpy", "doc", "sleepy", "bashful", "sneezy", "dopey")
GOALS = 70  # in one building
RETRY = 2.0  # s until a robot that found no free goal looks for one again
LIMIT, PER_METRE = 180.0, 10.0  # s: time for a goal, and more for each m of the shortest way


@dataclass(slots=True)
class Errand:
    """A robot under way. number: of the goal. way: the shortest one, m."""

    robot: NavigatedRobot
    number: int
    start: Pose2D
    goal: Point
    way: float

    @property
    def mission(self) -> str:
        """The name of the mission."""
        return f"goal-{self.number}"


class TeamRun:
    """A team on its floor. scores: of the goals so far."""

    def __init__(self, floor: MapFloor) -> None:
        """Begin with the first goals of all robots."""
        self.scores: list[GoalScore] = []
        self._floor = floor
        self._errands: dict[str, Errand] = {}
        self._begins: dict[str, float] = {}  # when a robot looks for a goal again, s
        self._begun = 0
        self._ended_at = floor.lockstep.time  # the last mission, s

    def play(self) -> None:
        """Play all goals."""
        goals = self._floor.job.goals
        while len(self.scores) < goals:
            for robot in self._floor.robots:
                is_free = robot.name not in self._errands and self._begun < goals
                if is_free and self._floor.lockstep.time >= self._begins.get(robot.name, 0.0):
                    self._begin(robot)
            self._floor.run(LOOK * STEP)
            for errand in list(self._errands.values()):
                self._look_at(errand)

    @property
    def contacts(self) -> dict[str, int]:
        """How often each robot has touched something since the start."""
        world = self._floor.lockstep.world
        return {robot.name: world.touches(robot.name).count for robot in self._floor.robots}

    def _begin(self, robot: NavigatedRobot) -> None:
        taken = [errand.goal for errand in self._errands.values()]
        standing = (other for other in self._floor.robots if other is not robot and other.name not in self._errands)
        taken += [(other.pose.x, other.pose.y) for other in standing]
        try:
            goal, way = self._floor.goal(robot, taken)
        except ValueError:  # other robots are everywhere; try again when they have moved
            if not self._errands and self._floor.lockstep.time > self._ended_at + LIMIT:
                raise
            self._begins[robot.name] = self._floor.lockstep.time + RETRY
            return
        errand = self._errands[robot.name] = Errand(robot, self._begun, robot.pose, goal, way)
        self._begun += 1
        robot.tell(goal, mission=errand.mission, on_map=True)

    def _look_at(self, errand: Errand) -> None:
        """Score a goal that was reached or given up."""
        robot = errand.robot
        state = robot.ended(errand.mission)
        if state is None and robot.seconds < LIMIT + PER_METRE * errand.way:
            return
        del self._errands[robot.name]
        self._ended_at = self._floor.lockstep.time
        played, end = robot.played(state or "late", robot.seconds), robot.pose
        off = math.dist((end.x, end.y), errand.goal)
        self.scores.append(
            GoalScore(
                self._floor.job,
                errand.number,
                robot.name,
                errand.start,
                errand.goal,
                why_missed(played, off, 0.0),
                robot.seconds,
                played.track.length,
                errand.way,
                off,
                played.touched,
                (),
                tuple(played.track.true[::5]),
                played.told,
                played.reports,
            )
        )
        told = self.scores[-1].why or f"reached after {robot.seconds:.0f} s"
        print(f"   {self._floor.job.world}: goal {errand.number} of {robot.name}: {told}", flush=True)


def measure(options: argparse.Namespace) -> list[Figure]:
    """Play all goals of each building, one after the other."""
    options.out.mkdir(parents=True, exist_ok=True)
    found: list[Figure] = []
    scores: list[GoalScore] = []
    first = FIRST_SEED if options.first_seed is None else options.first_seed
    for seed, family in enumerate(FAMILIES, first):
        job = FloorJob(f"{family}:{seed}", seed, MapCondition.TEAM, options.team_goals)
        with MapFloor(job, TEAM) as floor:
            run = TeamRun(floor)
            run.play()
            found += figures(job, run)
            scores += run.scores
    (options.out / "map-team.json").write_text(json.dumps([as_row(each) for each in scores], indent=1) + "\n", "utf-8")
    draw(options.out / "map-team.png", scores)
    return found


def figures(job: FloorJob, run: TeamRun) -> list[Figure]:
    """Return the figures of one building."""
    count = len(run.scores)
    missed = sum(not score.is_reached for score in run.scores)
    ratios = [score.length / score.shortest for score in run.scores if score.is_reached]
    about = f"seven robots, {job.world}"
    found = [
        Figure(GROUP, f"{about}: goals not reached", missed, 0, "", count),
        Figure(GROUP, f"{about}: contacts", sum(run.contacts.values()), 0, "", count),
    ]
    if ratios:
        found.append(
            Figure(GROUP, f"{about}: path over the shortest path, mean", statistics.mean(ratios), 1.5, "", len(ratios))
        )
    return found

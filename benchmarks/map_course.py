"""Robots that navigate with a map in lockstep: floors, goals and changes by a seed."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np

import configs
from acromovi.lockstep import SETTINGS, Lockstep
from acromovi.missions.course import BRISK, CONNECTING, LOOK, SETTLE
from acromovi.missions.navigated_robot import NavigatedRobot, Played, run_together
from agents.components.localization.localization_agent import LocalizationAgent
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from benchmarks.localization_drives import PERIOD, TURN, map_of_world
from bus import keys
from bus.bus import Closeable
from bus.messages import twist
from geometry import Point, Pose2D, wrap_angle
from maps.map_files import write_building_map
from p2os import RobotModel
from p2os_emu.emulator import STEP
from p2os_emu.world import WorldSpec, load_world
from p2os_emu.world.conditions import with_obstacles, with_people
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.shortest_path import shortest_path

T = TypeVar("T")
MODEL = "p3dx-sh"
FIRST, SECOND = "happy", "grumpy"
TURNING, PASSING = 0.12, 0.05  # m round a robot that turns at a goal, and beside one on the shortest way
LEAST = 3.0  # m of a way
NEAR, TURNED = 0.45, 0.25  # m and rad from the goal where it truly counts as reached: tolerance and localization
SPREAD = 1.2  # m from a named place of the world, of goals
TRIES = 300
PEOPLE = 3  # that walk about
OBSTACLES, MOVED = 3, 2  # things that are not on the map, and pieces of furniture that are on it only
LONGER = 1.1  # a closed door makes a way longer by this factor at least
APART, GOALS_APART = 2.5, 1.5  # m between the starts, and between the goals, of two robots


class MapCondition(StrEnum):
    """What is not as on the map.

    CHANGED: obstacles were added, furniture was taken away, and doors are closed. BUSY: people walk about, and a second
    robot drives to goals of its own. TEAM: as on the map, with a team of robots that all have goals.
    """

    STATIC = "static"
    CHANGED = "changed"
    BUSY = "busy"
    TEAM = "team"


@dataclass(frozen=True, slots=True)
class FloorJob:
    """One floor on which a robot is sent to goals, one after the other."""

    world: str
    seed: int
    condition: MapCondition
    goals: int


@dataclass(frozen=True, slots=True)
class GoalScore:
    """One goal. why: it was not reached; empty where it was. shortest: m. off: m at the end. shut: doors."""

    job: FloorJob
    number: int
    robot: str
    start: Pose2D
    goal: Point
    why: str
    seconds: float
    length: float
    shortest: float
    off: float
    touched: tuple[str, ...]
    shut: tuple[str, ...]
    path: tuple[Pose2D, ...]
    told: tuple[str, ...]
    reports: tuple[str, ...]

    @property
    def is_reached(self) -> bool:
        """Whether the robot says that it is there, and truly is."""
        return not self.why


class _LocalizationInStep(LocalizationAgent):
    """Works in the loop, since in virtual time nothing may wait for a thread."""

    @property
    def is_localized(self) -> bool:
        """Whether its pose is to be believed."""
        return self._state() == "localized"

    async def _in_thread(self, job: "Callable[[], T]") -> T:
        return job()


class MapFloor(Closeable):
    """A floor with one or two robots that know its map, and all that chance decides."""

    def __init__(self, job: FloorJob, names: Sequence[str] = ()) -> None:
        """Put the robots onto the floor, and localize them.

        Args:
            job: What to play.
            names: Of the robots; by default one, or two in the condition BUSY.
        """
        self.job = job
        self._chance = Random(f"map navigation {job.world} {job.seed} {job.condition}")
        self._folder = TemporaryDirectory(prefix="map-navigation-")
        whole = load_world(job.world)
        self.world = replace(whole, people=(), objects=(), moving_doors=tuple(self._left_open(whole)))
        model = configs.load(RobotModel, "robots", MODEL)
        self._half_width = model.width / 2.0
        self._sweep = math.hypot(max(model.length_front, model.length_rear), self._half_width) + TURNING
        map_file = write_building_map(map_of_world(self.world), Path(self._folder.name) / "floor.map")[0]
        names = names or ((FIRST, SECOND) if job.condition is MapCondition.BUSY else (FIRST,))
        poses = self._starts(names)
        if job.condition is MapCondition.CHANGED:
            self.world = self._changed(self.world)
        elif job.condition is MapCondition.BUSY:
            self.world = with_people(self.world, job.seed, PEOPLE, keep_clear=[(p.x, p.y) for p in poses.values()])
        self._space = FreeSpace(self.world, self._sweep)
        self.lockstep = Lockstep(
            self.world,
            dict.fromkeys(names, MODEL),
            fits=dict.fromkeys(names, "laser"),
            poses=poses,
            seed=job.seed,
            settings=replace(SETTINGS, limits=BRISK),
        )
        self.loop = VirtualTimeLoop()
        self.robots = [NavigatedRobot(name, self.lockstep, self.loop) for name in names]
        self._number = 0
        self._localizations = dict[str, _LocalizationInStep]()
        self.run(1.0)
        for robot in self.robots:
            robot.start_components()
            self._localize(robot, str(map_file))
        # For passages; it gives none in the first three seconds.
        self.robots[0].start_agent(Arbiter("arbiter@acromovi"))
        self.run(CONNECTING + 2.0)
        self._turn_those_that_are_not_localized()

    def run(self, seconds: float) -> None:
        """Let time pass."""
        run_together(self.lockstep, self.loop, self.robots, seconds)

    def play(self, number: int) -> GoalScore:
        """Send the first robot to a goal; the second one goes on to its own."""
        robot = self.robots[0]
        start, (goal, way) = robot.pose, self.goal(robot)
        shut: tuple[str, ...] = ()
        if self.job.condition is MapCondition.CHANGED:
            shut, way = self._shut_door(start, goal, way)
        heading = round(self._chance.uniform(-math.pi, math.pi), 2) if number % 2 else None
        robot.tell(goal, mission=f"goal-{number}", heading=heading, on_map=True)
        limit, state = 60.0 + 8.0 * way, None
        while state is None and robot.seconds < limit:
            self._keep_second_going()
            self.run(LOOK * STEP)
            state = robot.ended(f"goal-{number}")
        seconds = robot.seconds
        self.run(SETTLE)
        played, end = robot.played(state or "late", seconds), robot.pose
        off = math.dist((end.x, end.y), goal)
        turned = abs(wrap_angle(end.heading - heading)) if heading is not None else 0.0
        return GoalScore(
            self.job,
            number,
            robot.name,
            start,
            goal,
            why_missed(played, off, turned),
            seconds,
            played.track.length,
            way,
            off,
            played.touched,
            shut,
            tuple(played.track.true[::5]),
            played.told,
            played.reports,
        )

    def close(self) -> None:
        """End everything."""
        for robot in self.robots:
            robot.close()
        self.lockstep.close()
        self.loop.close()
        self._folder.cleanup()

    def _localize(self, robot: NavigatedRobot, map_file: str) -> None:
        description = self.lockstep.bus().query(keys.DESCRIPTION.key(robot.name))[0].value
        properties = LocalizationAgent.properties_of(description, {})
        agent = _LocalizationInStep(f"localization@{robot.name}", properties)
        robot.start_agent(agent)
        robot.do(agent.start(map_file, [robot.start.x, robot.start.y, robot.start.heading]))
        self._localizations[robot.name] = agent

    def _turn_those_that_are_not_localized(self) -> None:
        """Let them turn once on the spot, as the localization asks its user to do."""
        lost = [name for name, agent in self._localizations.items() if not agent.is_localized]
        if not lost:
            return
        bus = self.lockstep.bus()
        for _ in range(round(math.tau / TURN / PERIOD)):
            for name in lost:
                bus.put(keys.CMD_VEL.key(name), twist(0.0, TURN))
            self.run(PERIOD)
        for name in lost:
            bus.put(keys.CMD_VEL.key(name), twist(0.0, 0.0))
        self.run(SETTLE)

    def _left_open(self, whole: WorldSpec) -> "Iterator[MovingDoor]":
        """The doors of a floor, all open until somebody closes them."""
        return (replace(door, is_open=True, open_time=None, shut_time=None) for door in whole.moving_doors)

    def _starts(self, names: Sequence[str]) -> dict[str, Pose2D]:
        space, found = FreeSpace(self.world, self._sweep), list[Point]()
        for _ in names:
            free = [each for each in self._places(space) if all(math.dist(each, other) > APART for other in found)]
            found.append(free[0])
        turns = [round(self._chance.uniform(-math.pi, math.pi), 3) for _ in names]
        return {name: Pose2D(*place, turn) for name, place, turn in zip(names, found, turns, strict=True)}

    def _places(self, space: FreeSpace) -> "Iterator[Point]":
        """Free places near those that have a name, in an order by chance."""
        named = [self.world.places[name] for name in sorted(self.world.places)]
        for _ in range(TRIES):
            x, y = self._chance.choice(named)
            place = x + self._chance.uniform(-SPREAD, SPREAD), y + self._chance.uniform(-SPREAD, SPREAD)
            if space.is_free(place):
                yield place

    def _changed(self, world: WorldSpec) -> WorldSpec:
        """Take furniture away, and put other things onto the floor."""
        names = sorted({block.name for block in world.furniture if block.name})
        gone = set(self._chance.sample(names, min(MOVED, len(names))))
        less = replace(world, furniture=tuple(block for block in world.furniture if block.name not in gone))
        doors = [tuple(np.mean((door.jamb, door.post), axis=0).tolist()) for door in world.moving_doors]
        return with_obstacles(less, self.job.seed, OBSTACLES, keep_clear=doors)

    def _shut_door(self, start: Pose2D, goal: Point, way: float) -> tuple[tuple[str, ...], float]:
        """Close a door on the way where another way leads to the goal, otherwise any; the shortest way is then longer.

        All others are opened.
        """
        names = sorted(door.name for door in self.world.moving_doors)
        self._chance.shuffle(names)
        shut, length = tuple(names[:1]), way
        for name in names:
            around = self._way(start, goal, (name,))
            if around is not None and around > LONGER * way:
                shut, length = (name,), around
                break
        if self._way(start, goal, shut) is None:
            shut = ()
        for name in names:
            self.lockstep.world.set_door(name, name not in shut)
        self.run(3.0)
        return shut, length

    def _way(self, start: Pose2D, goal: Point, shut: Sequence[str] = ()) -> float | None:
        """Length of the shortest way, m; None without one."""
        for room in (PASSING, -PASSING):  # the robot may stand nearer to something than it passes
            way = shortest_path(self.world, (start.x, start.y), goal, self._half_width + room, shut=shut)
            if way is not None:
                return way.length
        return None

    def goal(self, robot: NavigatedRobot, taken: Sequence[Point] = ()) -> tuple[Point, float]:
        """Return a goal with a way of some length, and that length; goals of other robots are taken.

        Raises:
            ValueError: There is none.
        """
        for place in self._places(self._space):
            goal = round(place[0], 3), round(place[1], 3)
            if any(math.dist(goal, other) < GOALS_APART for other in taken):
                continue
            way = self._way(robot.pose, goal)
            if way is not None and way >= LEAST:
                return goal, way
        raise ValueError(f"{self.job.world} has no goal that {robot.name} can reach")

    def _keep_second_going(self) -> None:
        for robot in self.robots[1:]:
            if not self._number or robot.ended(f"second-{self._number}") is not None:
                self._number += 1
                robot.tell(self.goal(robot)[0], mission=f"second-{self._number}", on_map=True)


def play_floor(job: FloorJob) -> list[GoalScore]:
    """Play all goals of a floor."""
    with MapFloor(job) as floor:
        return [floor.play(number) for number in range(job.goals)]


def why_missed(played: Played, off: float, turned: float) -> str:
    """Why a goal was not reached; empty where it was."""
    if played.state != "done":
        return f"it ended as {played.state}" + (f": {played.told[-1]}" if played.told else "")
    if off > NEAR:
        return f"it says that it is there, and is {off:.2f} m away"
    return f"it is turned by {turned:.2f} rad from the heading" if turned > TURNED else ""

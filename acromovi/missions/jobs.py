"""Missions by case, condition and seed: what is asked of a robot, with all that chance decides about it."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache
from itertools import pairwise
from random import Random

import numpy as np

import configs
from acromovi.missions.task import NoRoom, Task
from geometry import Point, Pose2D, Segment
from p2os import RobotModel
from p2os_emu.world import WorldError, WorldSpec, load_world
from p2os_emu.world.conditions import LEAST_WALK, with_obstacles, with_people
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.shortest_path import Path, shortest_path

ROBOTS = ("p2dx", "peoplebot-sh", "powerbot-sh", "p3at-sh")  # of the matrix
SEEDS = 20
WIDER_THAN_DOORS = 0.65  # m; radius of a disc that fits through no door
PASSING = 0.05  # m beside the robot on the shortest way
TURNING = 0.15  # m round a robot that turns where a mission begins or ends
AT_EASE = (0.2, 0.1, PASSING)  # m beside the robot that obstacles leave it on some way: what the doors leave it, too
LEAST = {"room": 3.0, "corridor": 3.0, "rooms": 5.0}  # m of way
TRIES = 500
MOST_OBSTACLES = 4
PEOPLE = 2  # beside the one on the robot's way


class Case(StrEnum):
    """Where to."""

    ROOM = "room"
    CORRIDOR = "corridor"
    ROOMS = "rooms"


class Condition(StrEnum):
    """Under which circumstances. In the first, third and fourth odometry and sensors are perfect."""

    STATIC = "static"
    ERROR = "error"
    OBSTACLES = "obstacles"
    PEOPLE = "people"
    ALL = "all"

    @property
    def is_perfect(self) -> bool:
        """Whether the robot has no errors."""
        return self not in (Condition.ERROR, Condition.ALL)

    @property
    def has_obstacles(self) -> bool:
        """Whether things stand in the way."""
        return self in (Condition.OBSTACLES, Condition.ALL)

    @property
    def has_people(self) -> bool:
        """Whether people walk about."""
        return self in (Condition.PEOPLE, Condition.ALL)


@dataclass(frozen=True, slots=True)
class Job:
    """One cell of the matrix: what has to be known to play a mission again.

    has_laser: whether the robot has a laser beside its sonar.
    """

    case: Case
    condition: Condition
    seed: int
    robot: str
    world: str
    has_laser: bool = True

    @classmethod
    def of(cls, case: Case, condition: Condition, seed: int, robot: str = "", world: str = "") -> "Job":
        """Robots and worlds in turn, unless they are given: every other world is generated."""
        models = ROBOTS
        return cls(
            case,
            condition,
            seed,
            robot or models[seed % len(models)],
            world or ("house" if seed // len(models) % 2 == 0 else f"plan:{seed}"),
        )

    @classmethod
    def matrix(cls, seeds: Sequence[int] = range(SEEDS)) -> "list[Job]":
        """All cases and conditions, for each seed."""
        return [cls.of(case, condition, seed) for seed in seeds for condition in Condition for case in Case]

    @property
    def command(self) -> str:
        """What to type to play it."""
        said = f"acromovi missions --case {self.case} --condition {self.condition} --seed {self.seed}"
        usual = Job.of(self.case, self.condition, self.seed)
        said += f" --robot {self.robot}" if self.robot != usual.robot else ""
        said += f" --world {self.world}" if self.world != usual.world else ""
        return said if self.has_laser else f"{said} --no-laser"

    @property
    def name(self) -> str:
        """For lists."""
        return f"{self.case} {self.condition} {self.seed} {self.robot} {self.world}" + self._without

    @property
    def carrier(self) -> str:
        """The robot, and what it lacks."""
        return self.robot + self._without

    @property
    def _without(self) -> str:
        return "" if self.has_laser else ", sonar only"

    def task(self) -> Task:
        """Choose start and goal, put obstacles and people into the world: the same for the same job.

        Raises:
            WorldError, ConfigError: There is no such world or robot, or the world has no room for such a mission.
        """
        chooser, start, goal, way = _ends(self.case, self.world, self.robot, self.seed)
        world = replace(chooser.world, starts=(start,))
        if self.condition.has_obstacles:
            world = chooser.with_obstacles(world, way, self.seed)
            way = chooser.way(world, (start.x, start.y), goal) or way
        if self.condition.has_people:
            world = chooser.with_people(world, way, self.seed)
        fit = "laser" if self.has_laser else ""
        return Task(world, self.robot, fit, goal, way, self.seed, self.condition.is_perfect)


def half_width(robot: str) -> float:
    """Return half the width of a model, m."""
    return configs.load(RobotModel, "robots", robot).width / 2


@lru_cache(maxsize=16)  # all conditions of a few seeds, which are played one after the other
def _ends(case: Case, world: str, robot: str, seed: int) -> "tuple[_Chooser, Pose2D, Point, Path]":
    """Return what chooses the rest, start and goal, and the shortest way between them without obstacles."""
    chooser = _chooser(world, robot)
    return chooser, *chooser.ends(case, Random(f"{case} {world} {robot} {seed}"))


@lru_cache(maxsize=4)
def _chooser(world: str, robot: str) -> "_Chooser":
    whole = load_world(world)
    doors = [Segment(*door.jamb, *door.post) for door in whole.moving_doors]
    open_world = replace(whole, people=(), moving_doors=(), objects=())  # all doors stay open
    return _Chooser(open_world, doors, configs.load(RobotModel, "robots", robot))


class _Chooser:
    """Chance, bound by the world."""

    def __init__(self, world: WorldSpec, doors: Sequence[Segment], model: RobotModel) -> None:
        self.world = world
        self._doors = [((door.x1 + door.x2) / 2, (door.y1 + door.y2) / 2) for door in doors]
        self._half_width = model.width / 2
        self._sweep = math.hypot(max(model.length_front, model.length_rear), self._half_width)
        self._turning = FreeSpace(world, self._sweep + TURNING)
        self._rooms = FreeSpace(replace(world, furniture=()), WIDER_THAN_DOORS)
        names = sorted(world.places)
        self._corridor = [world.places[name] for name in names if name.startswith("corridor")]
        self._room = [world.places[name] for name in names if not name.startswith("corridor")]

    def ends(self, case: Case, chance: Random) -> tuple[Pose2D, Point, Path]:
        """Start, goal, and the shortest way between them; in small rooms ways may be short."""
        for least in (LEAST[case], LEAST[case] / 2) if self._corridor and len(self._room) > 1 else ():
            for _ in range(TRIES):
                room = chance.choice(self._room)
                start, goal = self._near(room, 0.8, chance), self._goal(case, room, chance)
                way = self._way_to(goal, start)
                if way is None or way.length < least or (case is Case.ROOMS and not self._passes_corridor(way)):
                    continue
                return Pose2D(*start, round(chance.uniform(-math.pi, math.pi), 3)), goal, way
        raise NoRoom(f"world {self.world.name!r} has no room for a mission of case {case}; choose another world")

    def _way_to(self, goal: Point, start: Point) -> Path | None:
        """The shortest way, if the robot has room to turn at both ends."""
        has_room = self._turning.is_free(start) and self._turning.is_free(goal)
        return self.way(self.world, start, goal) if has_room else None

    def way(self, world: WorldSpec, start: Point, goal: Point) -> Path | None:
        """The shortest way for the robot, if there is one."""
        return shortest_path(world, start, goal, radius=self._half_width + PASSING)

    def with_obstacles(self, world: WorldSpec, way: Path, seed: int) -> WorldSpec:
        """Things on the way or beside it; another way stays free."""
        ends = way.points[0], way.points[-1]
        ease = next(ease for ease in AT_EASE if shortest_path(world, *ends, radius=self._half_width + ease) is not None)
        bounded = _between(world, *ends)
        for count in range(MOST_OBSTACLES, 0, -1):
            with suppress(WorldError):  # no room for so many: try fewer
                radius = self._half_width + ease
                fuller = with_obstacles(bounded, seed, count, radius=radius, keep_clear=self._doors)
                return replace(fuller, places=world.places)
        return world

    def with_people(self, world: WorldSpec, way: Path, seed: int) -> WorldSpec:
        """Somebody who goes the same way or comes towards the robot, and others who walk about."""
        start = way.points[0]
        if way.length > 2 * LEAST_WALK:
            with suppress(WorldError):  # the robot may go where a person does not fit between boxes
                met = with_people(_between(world, start, way.points[-1]), seed, 1, keep_clear=[start])
                world = replace(met, places=world.places)
        try:
            return with_people(world, seed, PEOPLE, keep_clear=[start])
        except WorldError as err:
            raise NoRoom(str(err)) from err

    def _goal(self, case: Case, room: Point, chance: Random) -> Point:
        if case is Case.ROOM:
            return self._near(room, 4.0, chance)
        if case is Case.CORRIDOR:
            return self._near(chance.choice(self._corridor), 1.5, chance)
        return self._near(chance.choice([other for other in self._room if other != room]), 0.8, chance)

    def _near(self, place: Point, most: float, chance: Random) -> Point:
        """A place in the same room, or the same corridor."""
        for _ in range(TRIES):
            x, y = (round(value + chance.uniform(-most, most), 3) for value in place)
            near = x, y
            if self._rooms.is_free(near) and self._rooms.reachable(place, np.array([near]))[0]:
                return near
        return place

    def _passes_corridor(self, way: Path) -> bool:
        middle = np.array([_along(way, share * way.length) for share in np.linspace(0.1, 0.9, 17)])
        return any(bool(self._rooms.reachable(place, middle).any()) for place in self._corridor)


def _along(way: Path, far: float) -> Point:
    """The place so far along a way, m."""
    for a, b in pairwise(way.points):
        if far <= (step := math.dist(a, b)):
            share = far / step if step else 0.0
            return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
        far -= step
    return way.points[-1]


def _between(world: WorldSpec, start: Point, goal: Point) -> WorldSpec:
    """The world, as if nobody went anywhere else."""
    return replace(world, places={"start": start, "goal": goal})

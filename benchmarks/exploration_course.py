"""Exploration in lockstep: the indoor navigation drives a robot to frontiers until it has seen every room."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from acromovi.lockstep import SETTINGS, Lockstep
from acromovi.missions.course import BRISK, CONNECTING
from acromovi.missions.navigated_robot import ENDED, NavigatedRobot, run_together
from agents.components.mapping.mapping_tools import MapWork, sensors_of
from agents.components.mapping.settings import MappingAgentSettings
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Sample, keys
from geometry import Pose2D
from maps.building.exploring import Explorer, ExploringOrder, MissionStanding, RobotSight
from maps.building.frontiers import ways_from
from maps.building.merging import CommonFrame
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid
from p2os_emu.world import WorldSpec
from p2os_emu.world.free_space import FreeSpace

ROBOTS = ("happy", "doc")
APART = 1.4  # m between two robots at the beginning
STANDING = 0.45  # m of a disc that is free where the second one stands
LOOK = 1.0  # s between two decisions, as of `acromovi map build --explore`
LIMIT = 1800.0  # s after which it is given up
ROOM = 0.05  # m beside the robot
RASTER = 0.1  # m, of the floor that is to be seen
REACHING = 0.3  # m, of a disc that can reach it


@dataclass(frozen=True, slots=True)
class Explored:
    """One exploration.

    robots: how many. ended: whether it did by itself. seconds: until then. driven, missions: of all robots. seen: share
    of the floor that a robot can reach. made, way: map and true way of the first robot.
    """

    robots: int
    ended: bool
    seconds: float
    driven: float
    missions: int
    seen: float
    touched: tuple[str, ...]
    made: BuildingMap
    way: tuple[Pose2D, ...]


def explore(world: WorldSpec, seed: int, *, robots: int = 1, model: str = "p3dx-sh", fit: str = "laser") -> Explored:
    """Let robots that begin in one room explore a world, and see what they have seen."""
    names = ROBOTS[:robots]
    starts = dict(zip(names, _starts(world), strict=False))
    models, fits = dict.fromkeys(names, model), dict.fromkeys(names, fit)
    settings = replace(SETTINGS, limits=BRISK)
    with Lockstep(world, models, fits=fits, poses=starts, seed=seed, settings=settings) as lockstep:
        team = _ExploringTeam(lockstep, names)
        try:
            team.explore()
            return team.result(world)
        finally:
            team.close()


class _ExploringTeam:
    """Robots of one lockstep that explore as those of `acromovi map build --explore` do."""

    def __init__(self, lockstep: Lockstep, names: Sequence[str]) -> None:
        self._lockstep, self._loop = lockstep, VirtualTimeLoop()
        self._robots = {name: NavigatedRobot(name, lockstep, self._loop) for name in names}
        self._run(1.0)
        for robot in self._robots.values():
            robot.start_components()
        self._run(CONNECTING)
        self._members = {name: _Member(robot, lockstep) for name, robot in self._robots.items()}
        self._explorer = Explorer(max(each.half_width for each in self._members.values()) + ROOM)
        self._frame = CommonFrame(names[0])
        self._seconds = 0.0
        self._touched: set[str] = set()

    def explore(self) -> None:
        """Let them explore until nothing is left to see, or it is late."""
        began = self._lockstep.time
        while not self._explorer.is_finished and self._lockstep.time - began < LIMIT:
            self._run(LOOK)
            for name, member in self._members.items():
                member.take()
                self._touched |= {touch.what for touch in self._lockstep.world.touches(name).last}
            if any(member.work.is_empty for member in self._members.values()):
                continue
            sights = {name: member.sight() for name, member in self._members.items()}
            self._frame.look(self._lockstep.time, {name: sight.grid for name, sight in sights.items()})
            for name, order in self._explorer.decide(self._lockstep.time, sights, self._frame.poses).items():
                self._members[name].send(order)
        self._seconds = self._lockstep.time - began

    def result(self, world: WorldSpec) -> Explored:
        """Return how it went."""
        members = list(self._members.values())
        for member in members:
            member.work.refine()
        # A map begins in the frame of the odometry, which begins where the robot first stood.
        grids = [(member.work.grid(), member.robot.start) for member in members]
        return Explored(
            len(members),
            self._explorer.is_finished,
            self._seconds,
            sum(member.work.progress()["driven"] for member in members),
            sum(member.missions for member in members),
            _seen(world, members[0].robot.start, grids),
            tuple(self._touched),
            members[0].work.map(),
            tuple(members[0].way),
        )

    def close(self) -> None:
        for robot in self._robots.values():
            robot.close()
        self._loop.close()

    def _run(self, seconds: float) -> None:
        run_together(self._lockstep, self._loop, list(self._robots.values()), seconds)


class _Member:
    """One robot, its map and its missions."""

    def __init__(self, robot: NavigatedRobot, lockstep: Lockstep) -> None:
        self.robot = robot
        self.missions = 0
        self.way: list[Pose2D] = []
        self._samples: list[Sample] = []
        bus = lockstep.bus()
        for topic in (keys.ODOM, keys.SCAN):
            bus.subscribe(topic.key(robot.name), self._samples.append)
        description = bus.query(keys.DESCRIPTION.key(robot.name))[0].value
        self.half_width = float(description["geometry"]["width"]) / 2.0
        self.work = MapWork(sensors_of(description), MappingAgentSettings.load())

    def take(self) -> None:
        """Take what its sensors have said."""
        self.work.take(self._samples)
        self._samples.clear()
        self.way.append(self.robot.pose)

    def sight(self) -> RobotSight:
        return RobotSight(self.work.grid(), Pose2D(*self.work.progress()["pose"]), self._standing())

    def send(self, order: ExploringOrder) -> None:
        self.missions += order.goal is not None
        goal = heading = None
        if order.goal is not None:
            odom = Pose2D(*self.work.progress()["odom"])
            pose = self.robot.start.compose(order.goal.relative_to(odom))
            goal, heading = (pose.x, pose.y), pose.heading
        self.robot.tell(goal, mission=f"frontier {self.missions}", heading=heading)

    def _standing(self) -> MissionStanding:
        if not self.missions:
            return MissionStanding.NONE
        told = self.robot.ask("path_planning", "state")
        if told.get("mission") != f"frontier {self.missions}" or told.get("state") not in ENDED:
            return MissionStanding.ACTIVE
        return MissionStanding.DONE if told["state"] == "done" else MissionStanding.FAILED


def _starts(world: WorldSpec) -> Iterator[Pose2D]:
    """Yield the first start of a world, and places beside it that look the same way."""
    first = world.starts[0]
    yield first
    space = FreeSpace(world, STANDING)
    for turn in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
        place = first.compose(Pose2D(0.0, 0.0, float(turn))).transform(APART, 0.0)
        if space.is_free(place):
            yield Pose2D(*place, first.heading)


def _seen(world: WorldSpec, start: Pose2D, maps: Sequence[tuple[OccupancyGrid, Pose2D]]) -> float:
    """Share of the floor that can be reached from a start which any map knows; each with its frame in the world."""
    x, y, size = world.middle
    count = int(np.ceil(size / RASTER)) + 1
    steps = (np.arange(count) - count / 2) * RASTER
    columns, rows = np.meshgrid(x + steps, y + steps)
    places = np.stack((columns.reshape(-1), rows.reshape(-1)), axis=1)
    free = FreeSpace(world, REACHING).are_free(places).reshape(count, count)
    begin = int(np.argmin(np.abs(y + steps - start.y))), int(np.argmin(np.abs(x + steps - start.x)))
    reached = places[np.isfinite(ways_from(free, begin, RASTER)).reshape(-1)].tolist()
    known = np.zeros(len(reached), np.bool_)
    for grid, frame in maps:
        known |= grid.values_at(np.array([frame.locate(*place) for place in reached])) >= 0
    return float(known.mean())

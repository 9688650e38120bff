"""Exploration in lockstep: the indoor navigation drives a robot to frontiers until it has seen every room."""

from dataclasses import dataclass

import numpy as np

from acromovi.missions.course import ROBOT, Course
from acromovi.missions.navigated_robot import ENDED
from agents.components.mapping.mapping_tools import MapWork, sensors_of
from agents.components.mapping.settings import MappingAgentSettings
from bus import Sample, keys
from geometry import Pose2D
from maps.building.exploring import Explorer, MissionStanding, RobotSight
from maps.building.frontiers import ways_from
from maps.building_map import BuildingMap
from maps.occupancy import OccupancyGrid
from p2os_emu.world import WorldSpec
from p2os_emu.world.free_space import FreeSpace

LOOK = 1.0  # s between two decisions, as of `acromovi map build --explore`
LIMIT = 900.0  # s after which it is given up
ROOM = 0.05  # m beside the robot
RASTER = 0.1  # m, of the floor that is to be seen
REACHING = 0.3  # m, of a disc that can reach it


@dataclass(frozen=True, slots=True)
class Explored:
    """One exploration. ended: whether it did by itself. seen: share of the floor that a robot can reach."""

    world: str
    seed: int
    ended: bool
    seconds: float
    driven: float
    missions: int
    seen: float
    touched: tuple[str, ...]
    made: BuildingMap
    way: tuple[Pose2D, ...]


def explore(name: str, world: WorldSpec, seed: int, *, model: str = "p3dx-sh", fit: str = "laser") -> Explored:
    """Let one robot explore a world, and see what it has seen."""
    with Course(world, model, fit=fit, seed=seed) as course:
        bus = course.lockstep.bus()
        samples: list[Sample] = []
        for topic in (keys.ODOM, keys.SCAN):
            bus.subscribe(topic.key(ROBOT), samples.append)
        description = bus.query(keys.DESCRIPTION.key(ROBOT))[0].value
        work = MapWork(sensors_of(description), MappingAgentSettings.load())
        explorer = Explorer(float(description["geometry"]["width"]) / 2.0 + ROOM)
        began, missions, way, touched = course.time, 0, [], set()
        while not explorer.is_finished and course.time - began < LIMIT:
            course.run(LOOK)
            work.take(samples)
            samples.clear()
            way.append(course.pose)
            touched |= {touch.what for touch in course.lockstep.world.touches(ROBOT).last}
            if work.is_empty:
                continue
            progress = work.progress()
            sight = RobotSight(work.grid(), Pose2D(*progress["pose"]), _standing(course, missions))
            for order in explorer.decide(course.time, {ROBOT: sight}).values():
                missions += order.goal is not None
                goal = None
                if order.goal is not None:
                    goal = course.robot.start.transform(*Pose2D(*progress["odom"]).locate(*order.goal))
                course.tell(goal, mission=f"frontier {missions}")
        seconds = course.time - began
        frame = course.pose.compose(Pose2D().relative_to(Pose2D(*work.progress()["pose"])))
        work.refine()
        seen = _seen(world, course.robot.start, work.grid(), frame)
        ended = explorer.is_finished
        driven = work.progress()["driven"]
        return Explored(name, seed, ended, seconds, driven, missions, seen, tuple(touched), work.map(), tuple(way))


def _standing(course: Course, missions: int) -> MissionStanding:
    if not missions:
        return MissionStanding.NONE
    told = course.ask("path_planning", "state")
    if told.get("mission") != f"frontier {missions}" or told.get("state") not in ENDED:
        return MissionStanding.ACTIVE
    return MissionStanding.DONE if told["state"] == "done" else MissionStanding.FAILED


def _seen(world: WorldSpec, start: Pose2D, grid: OccupancyGrid, frame: Pose2D) -> float:
    """Share of the floor that can be reached from a start which a map knows; frame: of the map in the world."""
    x, y, size = world.middle
    count = int(np.ceil(size / RASTER)) + 1
    steps = (np.arange(count) - count / 2) * RASTER
    columns, rows = np.meshgrid(x + steps, y + steps)
    places = np.stack((columns.reshape(-1), rows.reshape(-1)), axis=1)
    free = FreeSpace(world, REACHING).are_free(places).reshape(count, count)
    begin = int(np.argmin(np.abs(y + steps - start.y))), int(np.argmin(np.abs(x + steps - start.x)))
    reached = np.isfinite(ways_from(free, begin, RASTER)).reshape(-1)
    own = np.array([frame.locate(*place) for place in places[reached].tolist()])
    return float(np.mean(grid.values_at(own) >= 0))

"""Drives through emulated buildings, recorded in lockstep: what a robot's sensors say, and where it truly was."""

import heapq
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from random import Random

import numpy as np
from numpy.typing import NDArray

import configs
from acromovi.lockstep import Lockstep
from agents.components.localization.localization_tools import scan_ends, sonar_ends
from bus import Bus, Sample, keys
from bus.messages import NS_PER_S, decode, heading, stamp_ns, twist
from geometry import Point, Pose2D
from geometry.segments import polygon_edges
from maps.building_map import BuildingMap
from maps.distance import distance_transform
from maps.localization.settings import LocalizationSettings
from maps.occupancy import FREE
from maps.rasterization import grid_of
from p2os import RobotModel
from p2os_emu.world import WorldSpec

ROBOT, MODEL = "happy", "p3dx-sh"
CONNECTING = 2.0  # s in which the driver connects and sensors are heard
PERIOD = 0.1  # s between two commands
SPEED, TURN = 0.45, 0.9  # m/s and rad/s, greatest
LOOKAHEAD = 0.45  # m on the path that the robot steers to
NARROWEST = 0.36  # m from a wall that the path keeps
AIRY = 0.7  # m from walls, up to which nearness costs
CELL = 0.1  # m of the planning
SENSOR_HEIGHTS = (0.2, 0.5)  # m: what is within is in the map that a laser or sonar would make

LASER = Pose2D(0.021, 0.0, 0.0)  # on the robot
_LONGEST = 15.0  # m of ranges that are recorded
_CLOSED = 1000.0  # cost of a cell that is too near to a wall, from which a path may begin
_NEIGHBOURS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))

Floats = NDArray[np.float64]


def map_of_world(world: WorldSpec) -> BuildingMap:
    """The true map of a world: outlines of what stands at the height of the sensors, without people and doors."""
    low, high = SENSOR_HEIGHTS
    blocks = [
        each for each in (*world.walls, *world.furniture) if each.bottom < low and each.top > high and not each.glass
    ]
    return BuildingMap(tuple(edge for block in blocks for edge in polygon_edges(block.footprint)))


@dataclass(slots=True)
class Drive:
    """A recorded drive; times in s.

    odometry: rows of time, x, y, heading as the robot says, and x, y, heading as they are.
    scans: time and ends of the ranges of each scan in `base_link`, m, shape (n, 2).
    sonar: time and arcs of the echoes of each packet, as `sonar_ends` gives them.
    """

    odometry: list[tuple[float, ...]] = field(default_factory=list)
    scans: list[tuple[float, Floats]] = field(default_factory=list)
    sonar: list[tuple[float, Floats]] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """How long it is."""
        return self.odometry[-1][0] - self.odometry[0][0]


def record(
    world: WorldSpec, seconds: float, seed: int, *, fit: str = "laser", faults: Mapping[float, str] | None = None
) -> Drive:
    """Drive from place to place of a world, in an order of the seed, and record what comes on the bus.

    Args:
        world: Where.
        seconds: To drive.
        seed: Of the order and of every error.
        fit: Accessories.
        faults: By the s at which they begin, in the notation of `p2os-emu --fault`.
    """
    rng = Random(f"localization {seed}")
    drive = Drive()
    due = sorted((faults or {}).items(), reverse=True)
    with Lockstep(world, {ROBOT: MODEL}, fits={ROBOT: fit}, seed=seed) as lockstep:
        bus = lockstep.bus()
        _listen(bus, lockstep, drive)
        lockstep.run(CONNECTING)
        planner, path = _Planner(world), list[Point]()
        while lockstep.time < seconds + CONNECTING:
            while due and due[-1][0] <= lockstep.time - CONNECTING:
                lockstep.fault(due.pop()[1])
            pose = lockstep.truth(ROBOT)
            while path and math.dist(path[0], (pose.x, pose.y)) < (LOOKAHEAD if len(path) > 1 else 0.2):
                path.pop(0)
            if not path:
                path = planner.plan((pose.x, pose.y), rng.choice(planner.goals))
                continue
            bearing = pose.bearing_to(*path[0])
            speed = SPEED * max(0.0, 1.0 - abs(bearing) / 0.8)
            bus.put(keys.CMD_VEL.key(ROBOT), twist(speed, max(-TURN, min(TURN, 1.8 * bearing))))
            lockstep.run(PERIOD)
        bus.close()
    return drive


def _listen(bus: Bus, lockstep: Lockstep, drive: Drive) -> None:
    """Record what comes on the bus."""
    discs, settings = _discs(), LocalizationSettings.load()

    def odometry(sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        at, true = message.pose.pose, lockstep.truth(ROBOT)
        row = (at.position.x, at.position.y, heading(at.orientation), true.x, true.y, true.heading)
        drive.odometry.append((stamp_ns(message.header) / NS_PER_S, *row))

    def scan(sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        drive.scans.append((stamp_ns(message.header) / NS_PER_S, scan_ends(message, LASER, _LONGEST)))

    def sonar(sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        drive.sonar.append((stamp_ns(message.header) / NS_PER_S, sonar_ends(message, discs, settings)))

    for topic, hear in ((keys.ODOM, odometry), (keys.SCAN, scan), (keys.SONAR, sonar)):
        bus.subscribe(topic.key(ROBOT), hear)


@cache
def _discs() -> Mapping[int, Pose2D]:
    model = configs.load(RobotModel, "robots", MODEL)
    return {number: Pose2D(disc.x, disc.y, disc.heading) for number, disc in enumerate(model.sonar)}


class _Planner:
    """Paths on a grid of the world, with clearance."""

    def __init__(self, world: WorldSpec) -> None:
        blocks = [*world.walls, *world.furniture]
        edges = [edge for block in blocks for edge in polygon_edges(block.footprint)]
        grid = grid_of(BuildingMap(tuple(edges)), CELL)
        self._x, self._y = grid.origin.x, grid.origin.y
        occupied = grid.is_occupied()
        centres = grid.centres(np.ones_like(occupied))
        inside = np.zeros(len(centres), np.bool_)
        for block in blocks:
            c, s = math.cos(block.heading), math.sin(block.heading)
            dx, dy = centres[:, 0] - block.x, centres[:, 1] - block.y
            inside |= (abs(c * dx + s * dy) <= block.length / 2) & (abs(c * dy - s * dx) <= block.width / 2)
        distance = distance_transform(occupied | inside.reshape(occupied.shape), CELL, AIRY)
        is_open = (distance > NARROWEST) & (grid.cells >= FREE)
        self._cost = np.where(is_open, 1.0 + 8.0 * (AIRY - distance), _CLOSED)
        wanted = [*world.places.values(), *((start.x, start.y) for start in world.starts)]
        self.goals = [place for place in wanted if is_open[self._cell(place)]]

    def _cell(self, point: Point) -> tuple[int, int]:
        return int((point[1] - self._y) / CELL), int((point[0] - self._x) / CELL)

    def plan(self, start: Point, goal: Point) -> list[Point]:
        """The cheapest path between two points, m; Dijkstra on eight neighbours."""
        begin, end = self._cell(start), self._cell(goal)
        best, came = {begin: 0.0}, {begin: begin}
        queue = [(0.0, begin)]
        while queue:
            cost, cell = heapq.heappop(queue)
            if cell == end:
                break
            if cost > best[cell]:
                continue
            for dr, dc in _NEIGHBOURS:
                to = cell[0] + dr, cell[1] + dc
                if 0 <= to[0] < self._cost.shape[0] and 0 <= to[1] < self._cost.shape[1]:
                    total = cost + float(self._cost[to]) * math.hypot(dr, dc)
                    if total < best.get(to, math.inf):
                        best[to], came[to] = total, cell
                        heapq.heappush(queue, (total, to))
        cells = [end]
        while cells[-1] != begin:
            cells.append(came[cells[-1]])
        return [(self._x + (c + 0.5) * CELL, self._y + (r + 0.5) * CELL) for r, c in reversed(cells)]

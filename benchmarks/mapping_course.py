"""A robot that a person drives through a building in lockstep, and what it heard on the way: what maps are made of."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acromovi.lockstep import Lockstep
from bus import Sample, keys
from bus.messages import decode, twist
from geometry import Point, Polygon, Pose2D, polygon_edges
from p2os_emu.world import WorldSpec
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.shortest_path import path_in

ROBOT = "happy"
CONNECTING = 2.0  # s until the drivers are connected
LOOK = 0.1  # s between two commands
FAST, TURNING = 0.5, 0.9  # m/s and rad/s at most
BESIDE = 0.15  # m left beside the robot on its way
ARRIVED = 0.08  # m from a corner of the way, from where the next one is headed for
_DIRECTIONS, _ENCLOSED, _SIGHT = 16, 12, 15.0  # rays from a place, how many of them meet walls inside, and within m
PATIENCE = 90.0  # s for one place


@dataclass(slots=True)
class Heard:
    """What came on the bus, in its order, and where the robot truly was meanwhile.

    messages: of odometry, laser and sonar. truth: s, m, m, rad, ten times a second, in the world's frame.
    standing: outlines of what else than walls and furniture stood about in the end, such as leaves of doors.
    description: of the robot.
    """

    start: Pose2D
    messages: list[object] = field(default_factory=list)
    truth: list[tuple[float, float, float, float]] = field(default_factory=list)
    missed: list[Point] = field(default_factory=list)
    standing: list[Polygon] = field(default_factory=list)
    description: dict[str, Any] = field(default_factory=dict)


def survey(
    world: WorldSpec,
    places: Sequence[Point],
    *,
    model: str = "p3dx-sh",
    fit: str = "laser",
    start: Pose2D | None = None,
    seed: int = 0,
) -> Heard:
    """Drive a robot to places, the nearest first, and back to where it began.

    It is steered as by a person who sees it, on the shortest ways; its odometry errs as ever.
    """
    poses = {ROBOT: start} if start is not None else None
    with Lockstep(world, {ROBOT: model}, fits={ROBOT: fit}, poses=poses, seed=seed) as lockstep:
        heard = Heard(lockstep.truth(ROBOT))
        bus = lockstep.bus()

        def hear(sample: Sample) -> None:
            heard.messages.append(decode(sample.type_name, sample.payload))

        for topic in (keys.ODOM, keys.SCAN, keys.SONAR):
            bus.subscribe(topic.key(ROBOT), hear)
        lockstep.run(CONNECTING)
        heard.description = dict(bus.query(keys.DESCRIPTION.key(ROBOT))[0].value)
        space = FreeSpace(world, RADII.get(model, 0.25) + BESIDE)
        left = [place for place in places if space.is_free(place)]
        while True:
            here = lockstep.truth(ROBOT)
            goal = min(
                left, key=lambda place: math.dist(place, (here.x, here.y)), default=(heard.start.x, heard.start.y)
            )
            way = path_in(space, (here.x, here.y), goal)
            if way is None:
                way = path_in(FreeSpace(world, RADII.get(model, 0.25) + 0.02), (here.x, here.y), goal)
            if way is None:
                heard.missed.append(goal)
            else:
                _follow(lockstep, heard, way.points[1:])
            if not left:
                moving = lockstep.world.moving
                heard.standing = [each.footprint for each in moving if each.name != ROBOT]
                return heard
            left.remove(goal)


RADII = {"p3dx-sh": 0.26, "powerbot-sh": 0.45}
"""m; of a disc about the axle that holds the robot while it drives on."""


def _follow(lockstep: Lockstep, heard: Heard, corners: Sequence[Point]) -> None:
    bus = lockstep.bus()
    began = lockstep.time
    for x, y in corners:
        while lockstep.time - began < PATIENCE:
            pose = lockstep.truth(ROBOT)
            heard.truth.append((lockstep.time, pose.x, pose.y, pose.heading))
            away, bearing = math.dist((pose.x, pose.y), (x, y)), pose.bearing_to(x, y)
            if away < ARRIVED:
                break
            speed = min(FAST, 0.15 + 0.8 * away) * max(0.0, 1.0 - abs(bearing) / 0.6)
            bus.put(keys.CMD_VEL.key(ROBOT), twist(speed, max(-TURNING, min(TURNING, 1.8 * bearing))))
            lockstep.run(LOOK)
    bus.put(keys.CMD_VEL.key(ROBOT), twist(0.0, 0.0))
    lockstep.run(LOOK)


def spread_places(world: WorldSpec, start: Point, apart: float, radius: float = 0.42) -> list[Point]:
    """Return places of a grid inside the building that a robot can reach, for a world that names none.

    Maps of real buildings have gaps in their outer walls, through which a robot would drive on where nothing is seen.
    """
    space = FreeSpace(world, radius)
    x, y, size = world.middle
    steps = np.arange(-size / 2, size / 2, apart)
    grid = [(x + dx, y + dy) for dx in steps for dy in steps]
    free = [place for place, is_free in zip(grid, space.are_free(np.array(grid)), strict=True) if is_free]
    edges = np.array([edge for wall in world.walls for edge in polygon_edges(wall.footprint)]).reshape(-1, 4)
    inside = [place for place in free if _is_enclosed(place, edges)]
    return [place for place in inside if path_in(space, start, place) is not None]


def _is_enclosed(place: Point, edges: NDArray[np.float64]) -> bool:
    """Return whether walls are around a place: in nearly all directions, one within sight.

    edges: x1, y1, x2, y2 of each, m, shape (n, 4).
    """
    angles = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)[:, None]
    x1, y1, x2, y2 = (edges - np.tile(place, 2)).T
    c, s = np.cos(angles), np.sin(angles)
    left, other = c * y1 - s * x1, c * y2 - s * x2  # of the ray, on which side each end is
    with np.errstate(divide="ignore", invalid="ignore"):  # edges along the ray, which `meets` leaves out
        part = left / (left - other)
        ahead = c * (x1 + part * (x2 - x1)) + s * (y1 + part * (y2 - y1))
    meets = (left * other < 0.0) & (ahead > 0.0) & (ahead < _SIGHT)
    return int(meets.any(axis=1).sum()) >= _ENCLOSED

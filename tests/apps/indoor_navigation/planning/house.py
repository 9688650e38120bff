"""A house of walls and doors, and a robot that goes straight where it is told, for closed loops in no time.

The robot stops short of what it would touch, and goes along it where it can; this much of the reactive part will do.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import cos, hypot, inf, pi, sin
from typing import Self

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.mission import Navigator
from apps.indoor_navigation.algorithms.planning.orders import Order
from apps.indoor_navigation.algorithms.planning.search import find_way, length
from apps.indoor_navigation.algorithms.planning.terrain import terrain
from apps.indoor_navigation.data import DLEData, Door, Floats, GoalPoint, ObstRead, Place
from apps.indoor_navigation.parameters import shipped_parameters
from geometry import wrap_angle

Line = tuple[float, float, float, float]
HALF_WIDTH = 0.22  # m, of the robot
STEER_AHEAD = 0.3  # m
REACH = 8.0  # m, of its laser
STEP = 0.1  # s
BEAMS = np.linspace(-pi / 2, pi / 2, 181)
TURNING = 1.0  # rad/s
BODY_RADIUS = 0.35  # m
KNOWN_RANGE = 5.0  # m within which people are known for people


@dataclass
class House:
    """walls: lines. doors: gaps between them; a door that is shut is a wall. people: where they are, by time."""

    walls: list[Line]
    doors: list[Line] = field(default_factory=list)
    shut: set[int] = field(default_factory=set)
    people: list[Callable[[float], Place]] = field(default_factory=list)

    def with_door(self, start: Place, end: Place, *centres: float, width: float = 0.9) -> Self:
        """Add a wall with doors at so many m from its start."""
        whole = hypot(end[0] - start[0], end[1] - start[1])
        along = (end[0] - start[0]) / whole, (end[1] - start[1]) / whole
        edges = [0.0, *(at + side * width / 2 for at in centres for side in (-1, 1)), whole]
        for number, (a, b) in enumerate(pairwise(edges)):
            line = (start[0] + a * along[0], start[1] + a * along[1], start[0] + b * along[0], start[1] + b * along[1])
            (self.doors if number % 2 else self.walls).append(line)
        return self

    def box(self, x: float, y: float, width: float, height: float) -> Self:
        """Add a rectangle; x, y is its lower left corner."""
        right, top = x + width, y + height
        self.walls += [(x, y, right, y), (right, y, right, top), (right, top, x, top), (x, top, x, y)]
        return self

    def lines(self, time: float) -> Floats:
        """All that stands now."""
        lines = [*self.walls, *(self.doors[number] for number in sorted(self.shut))]
        for person in self.people:
            x, y = person(time)
            corners = [(x + 0.2 * cos(a), y + 0.2 * sin(a)) for a in np.linspace(0.0, 2 * pi, 7)]
            lines += [(*a, *b) for a, b in pairwise(corners)]
        return np.array(lines)


def house() -> House:
    """Three rooms above a corridor and two below, 12 m by 9.4 m. Doors 0 to 2 lead up, 3 and 4 down, 5 joins the rooms
    up left."""
    plan = House([]).box(0.0, 0.0, 12.0, 9.4)
    plan.with_door((0.0, 5.4), (12.0, 5.4), 2.0, 6.0, 10.0)
    plan.with_door((0.0, 4.0), (12.0, 4.0), 4.5, 9.0)
    plan.with_door((4.0, 5.4), (4.0, 9.4), 3.0)
    plan.walls += [(8.0, 5.4, 8.0, 9.4), (6.0, 0.0, 6.0, 4.0)]
    return plan


def distances(x: float, y: float, angles: Floats, lines: Floats, reach: float) -> Floats:
    """From a place to the nearest line in each direction; `reach` where there is none nearer."""
    ux, uy = np.cos(angles)[:, None], np.sin(angles)[:, None]
    ax, ay = lines[:, 0] - x, lines[:, 1] - y
    dx, dy = lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1]
    turn = ux * dy - uy * dx
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along a wall, sorted out below
        far = (ax * dy - ay * dx) / turn
        part = (ax * uy - ay * ux) / turn
    hit = (turn != 0.0) & (part >= 0.0) & (part <= 1.0) & (far >= 0.0)
    return np.asarray(np.where(hit, far, inf).min(axis=1, initial=reach))


def clearance(x: float, y: float, lines: Floats) -> float:
    """From a place to the nearest line."""
    ax, ay = x - lines[:, 0], y - lines[:, 1]
    dx, dy = lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1]
    part = np.clip((ax * dx + ay * dy) / (dx**2 + dy**2), 0.0, 1.0)
    return float(np.hypot(ax - part * dx, ay - part * dy).min())


class Walker:
    """A robot in a house, and its navigator.

    trail: where it was. offset: of its odometry. is_blind: it sees nothing. is_held: it does not move. nearest: m to
    what it came nearest to. meanwhile: called before each step, to change the house or the robot.
    """

    def __init__(self, plan: House, navigator: Navigator, pose: tuple[float, float, float], seed: int = 0) -> None:
        self.plan, self.navigator = plan, navigator
        self.x, self.y, self.heading = pose
        self.time = 0.0
        self.trail: list[Place] = [pose[:2]]
        self.offset: Place = (0.0, 0.0)
        self.is_blind = False
        self.is_held = False
        self.order = Order("rest")
        self.meanwhile: Callable[[Walker], None] = lambda walker: None
        self.nearest = inf
        self.states: list[str] = []
        self._steps = 0
        self._random = np.random.default_rng(seed)

    def go(
        self, x: float, y: float, heading: float | None = None, mission: str = "m1", tolerance: float = 0.25
    ) -> None:
        """A mission begins."""
        self.navigator.begin(GoalPoint(mission, x, y, heading, tolerance), self.time)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.step()

    def run_to_end(self, limit: float = 180.0) -> str:
        """Let time pass until the mission has ended; returns how."""
        while self.navigator.is_active and self.time < limit:
            self.step()
        return str(self.navigator.state)

    def step(self) -> None:
        """A tenth of a second."""
        self.meanwhile(self)
        lines = self.plan.lines(self.time)
        if not self.is_blind and self._steps % 5 == 0:
            self.navigator.memory.doors.see(self._doors(lines))
        if self._steps % 2 == 0:
            if not self.is_blind:
                self.navigator.see(self.reading(lines), self.time)
            self.order = self.navigator.step(self.time)
            if not self.states or self.states[-1] != self.navigator.state:
                self.states.append(str(self.navigator.state))
        if not self.is_held:
            self._move(lines)
        self.nearest = min(self.nearest, clearance(self.x, self.y, lines))
        self.trail.append((self.x, self.y))
        self.time += STEP
        self._steps += 1

    @property
    def length(self) -> float:
        """Of its trail, m."""
        return length(self.trail)

    @property
    def pose(self) -> tuple[float, float, float]:
        """As its odometry has it."""
        return self.x + self.offset[0], self.y + self.offset[1], self.heading

    def reading(self, lines: Floats) -> ObstRead:
        """What it sees."""
        angles = BEAMS + self.heading
        ranges = distances(self.x, self.y, angles, lines, REACH)
        hits = ranges < REACH
        ranges = np.where(hits, ranges + self._random.normal(0.0, 0.01, len(ranges)), ranges)
        x, y, _ = self.pose
        here = np.ones(len(ranges))
        ends = x + ranges * np.cos(angles), y + ranges * np.sin(angles)
        rays = x * here, y * here, *ends, hits.astype(np.float64)
        return ObstRead(self.time, self.pose, None, 0.0, *rays, False, *self._bodies(angles, ranges))

    def _bodies(self, angles: Floats, ranges: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """The people in view, as what may be people: x, y, radius and whether they have moved."""
        seen = []
        for person in self.plan.people:
            x, y = person(self.time)
            away, bearing = hypot(x - self.x, y - self.y), np.arctan2(y - self.y, x - self.x)
            beam = int(np.abs(np.cos(angles - bearing) - 1.0).argmin())
            if away < KNOWN_RANGE and abs(wrap_angle(angles[beam] - bearing)) < 0.02 and ranges[beam] > away - 0.4:
                seen.append((x + self.offset[0], y + self.offset[1], BODY_RADIUS, 0.0))
        columns = np.array(seen).reshape(-1, 4).T
        return columns[0], columns[1], columns[2], columns[3]

    def _doors(self, lines: Floats) -> DLEData:
        """The open doors in view, each a little off."""
        seen = []
        for number, (ax, ay, bx, by) in enumerate(self.plan.doors):
            x, y, width = (ax + bx) / 2, (ay + by) / 2, hypot(bx - ax, by - ay)
            off, bearing = hypot(x - self.x, y - self.y), np.arctan2(y - self.y, x - self.x)
            view = distances(self.x, self.y, np.array([bearing]), lines, REACH)[0]
            if number in self.plan.shut or off > 5.0 or abs(wrap_angle(bearing - self.heading)) > 1.4 or view < off:
                continue
            normal = np.arctan2(bx - ax, -(by - ay))
            if abs(wrap_angle(normal - bearing)) > pi / 2:
                normal = wrap_angle(normal + pi)
            if abs(wrap_angle(normal - bearing)) < 1.2:
                slip = self._random.normal(0.0, 0.02, 3)
                place = x + self.offset[0] + slip[0], y + self.offset[1] + slip[1]
                seen.append(Door(float(place[0]), float(place[1]), width + float(slip[2]), float(normal), 0.9))
        return DLEData(self.time, self.pose, tuple(seen))

    def _ahead(self, order: Order) -> Place:
        """The point on its path to which it steers."""
        x, y, _ = self.pose
        path = np.array(order.path).reshape(-1, 2)
        if not len(path):
            return order.x, order.y
        off = np.hypot(path[:, 0] - x, path[:, 1] - y)
        later = np.flatnonzero(off[off.argmin() :] > STEER_AHEAD)
        at = off.argmin() + later[0] if len(later) else len(path) - 1
        return float(path[at, 0]), float(path[at, 1])

    def _move(self, lines: Floats) -> None:
        order = self.order
        if order.aim == "rest":
            return
        x, y, _ = self.pose
        ahead = self._ahead(order)
        wanted = order.heading if order.aim == "turn" else np.arctan2(ahead[1] - y, ahead[0] - x)
        sense = -1.0 if order.aim == "back" else 1.0
        off = wrap_angle(float(wanted) - self.heading + (pi if order.aim == "back" else 0.0))
        self.heading = wrap_angle(self.heading + max(-TURNING * STEP, min(TURNING * STEP, off)))
        if order.aim == "turn":
            return
        left = hypot(order.x - x, order.y - y)
        speed = min(order.speed, left) if order.is_last else order.speed
        step = min(speed * max(0.0, cos(off)) * STEP, left)
        for aside in (0.0, 0.5, -0.5, 1.0, -1.0, 1.4, -1.4):
            there = self.heading + aside
            to = self.x + sense * step * cos(there), self.y + sense * step * sin(there)
            if clearance(*to, lines) > HALF_WIDTH:
                self.x, self.y = to
                return


def shortest(plan: House, start: Place, goal: Place, time: float = 0.0) -> float:
    """m of the shortest way for the robot, by one who knows the house."""
    lines = plan.lines(time)
    x0, y0 = lines[:, (0, 2)].min() - 0.5, lines[:, (1, 3)].min() - 0.5
    width, height = lines[:, (0, 2)].max() + 0.5 - x0, lines[:, (1, 3)].max() + 0.5 - y0
    evidence = np.full((round(height / 0.05), round(width / 0.05)), -4, np.int8)
    for ax, ay, bx, by in lines:
        parts = np.linspace(0.0, 1.0, max(2, round(hypot(bx - ax, by - ay) / 0.02)))
        rows = np.floor((ay + parts * (by - ay) - y0) / 0.05).astype(int)
        evidence[rows, np.floor((ax + parts * (bx - ax) - x0) / 0.05).astype(int)] = 8
    area = Area.of(x0, y0, 0.05, evidence)
    flat = replace(
        shipped_parameters("path_planning").mission.guide.memory.cost,
        tight=0.0,
        squeeze=0.0,
        comfort=0.1,
        unknown=1.0,
    )
    way = find_way(terrain(area, HALF_WIDTH, flat), start, goal, 0.1)
    assert way is not None
    return length(way)


def still(place: Place) -> Callable[[float], Place]:
    """Somebody who stands."""
    return lambda time: place

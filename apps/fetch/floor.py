"""Ways over the floor: what sonar has heard, the cheapest way to a place, and the next velocity on it.

The grid, its costs, the search and the outline of a robot are those of the indoor navigation.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, dist, hypot, inf, pi, sin, sqrt

import numpy as np

from apps.fetch.settings import FetchSettings
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.grid import Grid, GridParameters
from apps.indoor_navigation.algorithms.planning.search import NO_WAY, costs_to, find_way
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, CostParameters, Terrain, terrain
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Floats, ObstRead, SonarRead
from geometry import Point, Pose2D, Twist2D

_MARGIN = 3.0  # m of floor about robot and goal, which the way may use
_LARGEST = 60.0  # m, edge of the floor that is kept
_ECHO_FOR = 1.0  # s for which an echo is avoided besides the grid
_HEARD_FOR = 10.0  # s for which what was heard bounds the velocity; a phantom is heard once, and the robot would stand
_SAME_ECHO = 0.35  # m between two echoes of one obstacle, while the robot turns
_CONE = 0.35  # rad from the axis of a disc to the edge of its cone, and some more
_CLOSE = 0.1  # m between an echo and the surface of an object
_NEAR = 1.2  # m about the robot, where obstacles bound its velocity
_AHEAD = 0.45  # m along the way, to which it steers
_TURN_FROM = 0.7  # rad off the way, above which it turns on the spot
_TURN_UNTIL = 0.2
_SIDES = 16  # from which a place is approached
_FREE = 2.5  # cost of a metre of floor that is not near obstacles
_FAR = 2.5  # times the step to the next place to look from, the most that the way there may cost
# Velocities that are tried in place of the one along the way: its share, and rad/s added; the nearest first.
_CHOICES = sorted(
    ((share, turn) for share in (1.0, 0.6, 0.3) for turn in (0.0, 0.15, -0.15, 0.3, -0.3, 0.5, -0.5)),
    key=lambda choice: 1.0 - choice[0] + abs(choice[1]),
)
_MOMENTS = 9  # of the motion that is foreseen
_KEPT = 0.8  # of the cost of the end that the way has so far
_BARS, _BAR = 4, 0.15  # places that are barred at most, and the radius of one, m
_SEEN = 8  # evidence for an obstacle that is seen


@dataclass(frozen=True, slots=True)
class _Echo:
    """The last echo of a sonar disc: when, s, where in odom, and whether the one before came from near."""

    time: float
    place: Point
    is_confirmed: bool


@dataclass(frozen=True, slots=True)
class Disc:
    """An obstacle that sonar does not hear: its middle in odom and its radius, m."""

    x: float
    y: float
    radius: float


class FetchFloor:
    """The floor about one robot."""

    def __init__(self, settings: FetchSettings) -> None:
        floor = settings.floor
        self._settings = settings
        self._grid = Grid(GridParameters(floor.resolution_m, floor.echo_m, floor.echo_m, _LARGEST, 3.0, 1.5, 0.0))
        self._costs = CostParameters(floor.comfort_m, 4.0, 0.05, 20.0, 1.3, 2.0, 15.0, 10.0, 3.0, 10.0)
        # Ways are planned for the width of the hull, so the hull and not a circle about it is kept free on them.
        self._hull = Outline(settings.robot.radius_m, settings.robot.radius_m, 2.0 * settings.robot.half_width_m)
        self._echoes: dict[Pose2D, _Echo] = {}  # by disc
        self._is_turning = False
        self._barred: deque[Disc] = deque(maxlen=_BARS)

    def hear(
        self,
        now: float,
        robot: Pose2D,
        discs: Sequence[Pose2D],
        ranges: Sequence[float],
        ignored: Sequence[Disc] = (),
    ) -> None:
        """Take the ranges of sonar discs.

        Args:
            now: s, when they were measured.
            robot: Then, in odom.
            discs: Their poses on the robot.
            ranges: m; infinite without an echo.
            ignored: Where echoes are those of an object that is gripped or held.
        """
        lengths = {disc: each for disc, each in zip(discs, ranges, strict=True) if each < self._settings.floor.echo_m}
        echoes = {disc: robot.compose(disc).transform(each, 0.0) for disc, each in lengths.items()}
        echoes = {
            disc: place
            for disc, place in echoes.items()
            if not any(_is_echo_of(each, robot.compose(disc), lengths[disc]) for each in ignored)
        }
        heard = {disc: _Echo(now, place, self._confirms(now, disc, place)) for disc, place in echoes.items()}
        self._echoes.update(heard)
        places = [disc for disc, echo in heard.items() if echo.is_confirmed]
        if not places:
            return
        rays = Rays.of_sonar(
            SonarRead(
                now,
                (robot.x, robot.y, robot.heading),
                np.array([each.x for each in places]),
                np.array([each.y for each in places]),
                np.array([each.heading for each in places]),
                np.array([lengths[each] for each in places]),
            )
        )
        hits = rays.hits.astype(np.float64)
        self._grid.see(
            ObstRead(
                now,
                (robot.x, robot.y, robot.heading),
                None,
                0.0,
                rays.origin_x,
                rays.origin_y,
                rays.end_x,
                rays.end_y,
                hits,
                is_dead_end=False,
            )
        )

    def _confirms(self, now: float, disc: Pose2D, place: Point) -> bool:
        """Return whether the disc's echo before came from near; a single echo may be that of another disc's sound."""
        before = self._echoes.get(disc)
        return before is not None and now - before.time < _ECHO_FOR and dist(before.place, place) < _SAME_ECHO

    def clear(self, x: float, y: float, radius: float) -> None:
        """Take what was heard within a radius, m, for the object that is to be gripped, and forget it."""
        if self._grid.area.evidence.size:
            self._grid.doubt(x, y, radius)
        self._echoes = {disc: echo for disc, echo in self._echoes.items() if dist(echo.place, (x, y)) > radius}

    def bar(self, robot: Pose2D, way: Sequence[Point]) -> None:
        """Plan no way any more through the place where a robot is stuck; until no other way is found.

        A way has room for the width of the hull, which the hull may need more than, where the way bends.
        """
        x, y = _ahead(robot, way)
        share = _AHEAD / max(_AHEAD / 2.0, hypot(x - robot.x, y - robot.y))
        self._barred.append(Disc(robot.x + share * (x - robot.x), robot.y + share * (y - robot.y), _BAR))

    def ground(self, robot: Pose2D, goal: Point, discs: Iterable[Disc] = ()) -> Terrain:
        """Return the costs of the floor about robot and goal."""
        for place in ((robot.x, robot.y), goal):
            self._grid.include(place, _MARGIN)
        area = self._grid.area.around((robot.x, robot.y), goal, margin=_MARGIN)
        seen = Area.of(area.x, area.y, area.resolution, _with_discs(area, (*discs, *self._barred)))
        return terrain(seen, self._settings.floor.half_width_m, self._costs, robot=(robot.x, robot.y))

    def standoff(
        self,
        robot: Pose2D,
        goal: Point,
        away: float,
        until: float,
        discs: Sequence[Disc],
        before: Sequence[Point] | None = None,
    ) -> tuple[Point, ...] | None:
        """Return the cheapest way to a place from which a goal can be approached straight; None where there is none.

        Args:
            robot: In odom.
            goal: In odom.
            away: Of the place from the goal, m.
            until: m from the goal, to which the straight approach must be free.
            discs: Obstacles besides those that sonar has heard.
            before: The way so far; its end is kept unless another one is clearly better.
        """
        ground = self.ground(robot, goal, discs)
        costs = costs_to(ground, (robot.x, robot.y), 0.0)
        best: tuple[float, Point] | None = None
        direct = atan2(robot.y - goal[1], robot.x - goal[0])
        sides = [(1.0, direct + number * 2.0 * pi / _SIDES) for number in range(_SIDES)]
        if before:
            sides.append((_KEPT, atan2(before[-1][1] - goal[1], before[-1][0] - goal[0])))
        for share, side in sides:
            c, s = cos(side), sin(side)
            place = goal[0] + away * c, goal[1] + away * s
            lane = ground.cost_of(place, (goal[0] + until * c, goal[1] + until * s))
            cost = costs[ground.area.cell(*place)] * ground.area.resolution + lane
            if cost < min(BARRED, NO_WAY * ground.area.resolution) and (best is None or share * cost < best[0]):
                best = share * cost, place
        if best is None:
            self._barred.clear()
            return None
        place = best[1]
        if hypot(place[0] - robot.x, place[1] - robot.y) < self._settings.floor.resolution_m:
            return (robot.x, robot.y), place
        way = find_way(ground, (robot.x, robot.y), place, 0.0)
        return None if way is None else (*way[:-1], place)

    def next_view(self, robot: Pose2D, looked_from: Sequence[Point], discs: Sequence[Disc]) -> tuple[Point, ...] | None:
        """Return the way to the next place to look from: the nearest one far from all where the robot has looked about.

        Args:
            robot: In odom.
            looked_from: Those places, m in odom.
            discs: Obstacles besides those that sonar has heard.
        """
        step = self._settings.search.step_m
        ground = self.ground(robot, (robot.x, robot.y), discs)
        area, (rows, columns) = ground.area, ground.cost.shape
        x = area.x + (np.arange(columns)[None, :] + 0.5) * area.resolution
        y = area.y + (np.arange(rows)[:, None] + 0.5) * area.resolution
        costs = costs_to(ground, (robot.x, robot.y), 0.0) * area.resolution
        new = np.min([np.hypot(x - a, y - b) for a, b in looked_from], axis=0)
        able = (ground.cost < _FREE) & (costs < _FAR * step) & (np.hypot(x - robot.x, y - robot.y) > step / 2.0)
        if not able.any():
            self._barred.clear()
            return None
        are_new = able & (new >= step)
        best = np.where(are_new, costs, np.inf).argmin() if are_new.any() else np.where(able, new, 0.0).argmax()
        row, column = np.unravel_index(int(best), costs.shape)
        return find_way(ground, (robot.x, robot.y), area.place(int(row), int(column)), 0.0)

    def follow(self, now: float, robot: Pose2D, way: Sequence[Point], discs: Sequence[Disc]) -> Twist2D:
        """Return the velocity to a place along a way.

        Args:
            now: s.
            robot: In odom.
            way: Corners in odom; the last is the place.
            discs: Obstacles besides those that sonar has heard.
        """
        wanted = self._wanted(robot, way)
        places = np.array(self._obstacles(now, robot, discs, now - _HEARD_FOR), np.float64).reshape(-1, 2)
        x, y = self._hull.outside((places[:, 0], places[:, 1]))
        apart = self._hull.distance(x, y)
        for share, turn in _CHOICES if wanted.linear else _CHOICES[:1]:
            twist = Twist2D(share * wanted.linear, wanted.angular + turn)
            poses = _poses(twist, self._settings.floor.horizon_s)
            if not self._hull.runs_into(poses, x, y, self._settings.floor.gap_m, apart).any():
                return twist
        return Twist2D()

    def is_free_behind(self, now: float, robot: Pose2D, room: float) -> bool:
        """Return whether the robot may back off by a distance, m."""
        half = self._settings.robot.half_width_m + 0.03
        rear = self._settings.robot.radius_m + room
        return not any(
            -rear < x < 0.0 and abs(y) < half for x, y in self._obstacles(now, robot, ()) if hypot(x, y) > 0.1
        )

    def echo_ahead(self, now: float, robot: Pose2D) -> float:
        """Return how far before the hull the nearest confirmed echo in the lane is, m; infinite without one."""
        half, front = self._settings.robot.half_width_m, self._settings.robot.front_m
        recent = (robot.locate(*echo.place) for echo in self._recent(now) if echo.is_confirmed)
        return min((x - front for x, y in recent if x > 0.0 and abs(y) < half), default=np.inf)

    def _recent(self, now: float) -> Iterator[_Echo]:
        return (echo for echo in self._echoes.values() if now - echo.time < _ECHO_FOR)

    def _wanted(self, robot: Pose2D, way: Sequence[Point]) -> Twist2D:
        drive, goal = self._settings.drive, way[-1]
        left = hypot(goal[0] - robot.x, goal[1] - robot.y)
        off = robot.bearing_to(*_ahead(robot, way))
        self._is_turning = abs(off) > (_TURN_UNTIL if self._is_turning else _TURN_FROM)
        turn = max(-drive.turn_rad_s, min(drive.turn_rad_s, drive.gain * off))
        if self._is_turning:
            return Twist2D(0.0, turn)
        speed = min(drive.speed_m_s, sqrt(2.0 * drive.braking_m_s2 * left) + 0.02)
        return Twist2D(speed * max(0.0, cos(off)), turn)

    def _obstacles(
        self, now: float, robot: Pose2D, discs: Sequence[Disc], since: float = -inf
    ) -> list[tuple[float, float]]:
        """Return obstacles near the robot in base_link, m, of those of sonar what was heard since then, s."""
        places = [echo.place for echo in self._recent(now)]
        if self._grid.area.evidence.size:
            near = self._grid.area.around((robot.x, robot.y), margin=_NEAR)
            places += [
                near.place(int(row), int(column)) for row, column in np.argwhere(near.occupied & (near.hit_at > since))
            ]
        for disc in discs:
            places += [
                (disc.x + disc.radius * cos(turn), disc.y + disc.radius * sin(turn))
                for turn in np.linspace(-pi, pi, 8, endpoint=False)
            ]
        local = (robot.locate(*place) for place in places)
        return [(x, y) for x, y in local if hypot(x, y) < _NEAR]


def _ahead(robot: Pose2D, way: Sequence[Point]) -> Point:
    """Return the corner of a way to which a robot steers."""
    return next((each for each in way[1:] if hypot(each[0] - robot.x, each[1] - robot.y) > _AHEAD), way[-1])


def _poses(twist: Twist2D, horizon: float) -> tuple[Floats, Floats, Floats]:
    """Return the poses of a robot that keeps a velocity for so many s, in its present frame: x, y and heading."""
    times = np.linspace(0.0, horizon, _MOMENTS)[1:]
    turned = twist.angular * times
    chord = twist.linear * times * np.sinc(turned / (2.0 * pi))
    return chord * np.cos(turned / 2.0), chord * np.sin(turned / 2.0), turned


def _with_discs(area: Area, discs: Iterable[Disc]) -> "np.ndarray":
    """Return the evidence of an area with discs in it."""
    evidence = area.evidence.copy()
    rows, columns = evidence.shape
    y = area.y + (np.arange(rows)[:, None] + 0.5) * area.resolution
    x = area.x + (np.arange(columns)[None, :] + 0.5) * area.resolution
    for disc in discs:
        evidence[np.hypot(x - disc.x, y - disc.y) <= disc.radius + area.resolution / 2.0] = _SEEN
    return evidence


def _is_echo_of(thing: Disc, disc: Pose2D, length: float) -> bool:
    """Return whether an echo may be that of an object: it is in the cone of the disc, at the length of the echo."""
    away = hypot(thing.x - disc.x, thing.y - disc.y)
    nearest = away < thing.radius + _CLOSE
    return abs(away - length) < thing.radius + _CLOSE and (nearest or abs(disc.bearing_to(thing.x, thing.y)) < _CONE)

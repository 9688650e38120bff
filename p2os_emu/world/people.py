"""People as data: their routes and speeds."""

import math
from dataclasses import dataclass
from itertools import accumulate, pairwise

from geometry import Point, Pose2D, wrap_angle
from p2os_emu.world.colours import check_colour

BODY_RADIUS = 0.25
"""m; what sonar hears and what a robot touches is a cylinder of this size, and the legs step within it."""
LEG_RADIUS = 0.07
HIP = 0.08
"""m; how far each leg stands beside the middle."""
STEP_LENGTH = 0.32
"""m; short, so that a foot never leaves the cylinder that stands for the body."""
LEG_HEIGHT = 0.8
HEIGHT = 1.75
LEAST_SPEED, MOST_SPEED = 0.1, 2.0


@dataclass(frozen=True, slots=True)
class Person:
    """A person who walks a route repeatedly.

    route: waypoints, m. loops: from the last waypoint on to the first; otherwise back the same way.
    begin: how far along the route they are when the world begins, m.
    pause: the shortest and the longest rest at an end of the route, s; one that loops ends where it begins.
    gives_way: they stop short of what stands in their way; others stop when they have bumped into it.
    patience: the shortest and the longest wait before they turn back, s.
    """

    name: str
    route: tuple[Point, ...]
    loops: bool = False
    begin: float = 0.0
    speed: float = 0.8
    pause: tuple[float, float] = (0.0, 0.0)
    gives_way: bool = True
    patience: tuple[float, float] = (4.0, 8.0)
    colour: str = "blue"


class PersonRoute:
    """A line of waypoints, by the way along it.

    length: of the whole way, m; a route that loops begins again there.
    """

    def __init__(self, points: tuple[Point, ...], *, loops: bool) -> None:
        self._points = (*points, points[0]) if loops else points
        self._marks = list(accumulate((math.dist(a, b) for a, b in pairwise(self._points)), initial=0.0))
        self.length = self._marks[-1]
        self.loops = loops

    def at(self, along: float, sense: int = 1) -> Pose2D:
        """The place so far along, m, facing the way that somebody does who goes on up (1) or down (-1) the route."""
        legs = range(len(self._points) - 1)
        if sense > 0:
            leg = next((i for i in legs if along < self._marks[i + 1]), legs[-1])
        else:
            leg = next((i for i in reversed(legs) if self._marks[i] < along), 0)
        (x1, y1), (x2, y2) = self._points[leg : leg + 2]
        heading = math.atan2(y2 - y1, x2 - x1)
        x, y = Pose2D(x1, y1, heading).transform(along - self._marks[leg], 0.0)
        return Pose2D(x, y, heading if sense > 0 else wrap_angle(heading + math.pi))

    def end(self, sense: int) -> float:
        """How far along somebody comes who walks up (1) or down (-1) the route, m."""
        return self.length if sense > 0 else 0.0

    def leads_on(self, along: float, sense: int) -> bool:
        """Return whether the route leads on up (1) or down (-1) from so far along."""
        return self.loops or along != self.end(sense)

    def next_mark(self, along: float, sense: int) -> float:
        """How far along the next waypoint lies for somebody who walks up (1) or down (-1) the route, m."""
        if sense > 0:
            return next((mark for mark in self._marks if mark > along), self.length)
        return next((mark for mark in reversed(self._marks) if mark < along), 0.0)


@dataclass(frozen=True, slots=True)
class PersonEntry:
    """A person in a world file."""

    name: str
    route_m: tuple[tuple[float, float], ...]
    loop: bool = False
    begin_m: float = 0.0
    speed_m_s: float = 0.8
    pause_s: tuple[float, float] = (0.0, 0.0)
    gives_way: bool = True
    patience_s: tuple[float, float] = (4.0, 8.0)
    colour: str = "blue"

    def person(self) -> Person:
        """The person in SI.

        Raises:
            ValueError: A value makes no sense.
        """
        if len(self.route_m) < 2 or any(a == b for a, b in pairwise(self.route_m)):
            raise ValueError("route_m needs two waypoints or more, and no two neighbours alike")
        if not LEAST_SPEED <= self.speed_m_s <= MOST_SPEED:
            raise ValueError(f"speed_m_s must be from {LEAST_SPEED} to {MOST_SPEED}, not {self.speed_m_s}")
        check_span("pause_s", self.pause_s)
        check_span("patience_s", self.patience_s)
        length = PersonRoute(self.route_m, loops=self.loop).length
        if not 0.0 <= self.begin_m <= length:
            raise ValueError(f"begin_m must be from 0 to {length:.2f}, the length of the route, not {self.begin_m}")
        check_colour(self.colour)
        return Person(
            self.name,
            self.route_m,
            self.loop,
            self.begin_m,
            self.speed_m_s,
            self.pause_s,
            self.gives_way,
            self.patience_s,
            self.colour,
        )


def check_span(key: str, span: tuple[float, float]) -> None:
    """See that two times are a shortest and a longest.

    Raises:
        ValueError: They are not.
    """
    if not 0.0 <= span[0] <= span[1]:
        raise ValueError(f"{key} must be a shortest and a longest time, not {list(span)}")

"""The way to one goal, looked for in what the robot knows, and where the robot is on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, copysign, cos, hypot, inf

from apps.indoor_navigation.algorithms.planning.doors_map import thinned
from apps.indoor_navigation.algorithms.planning.memory import Memory, MemoryParameters, Pose
from apps.indoor_navigation.algorithms.planning.route import Passage, Route, SubTarget
from apps.indoor_navigation.algorithms.planning.search import Way, find_way, length, way_aside
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Terrain
from apps.indoor_navigation.data import GoalPoint, Place
from geometry import wrap_angle

CAME = 40  # points of the trail, on which somebody may want to go
SURE_FROM = 2.0  # m from the goal, within which it is believed that it is barred
WELL_WITHIN = 0.6  # of the tolerance, where ways end, since no robot stands exactly where it is sent
TO_LINE_UP = 0.2  # m beside the circle that the robot turns in, when it turns towards a door
IN_DOOR = 1.5  # times half the width of the robot, from the line of a door, where it cannot turn about
AT_DOOR = 3.0  # times the distance of the sub-targets from a door, to the one behind it


@dataclass(frozen=True, slots=True)
class GuideParameters:
    """How a way is told, in m.

    near: to a sub-target, where the next one counts. before_door: before and behind a door, where sub-targets are, or
    farther off for a robot that needs more room to turn.
    stop_before: what bars the way and may go. better: part of the present way's cost that another must not exceed.
    """

    near: float
    before_door: float
    stop_before: float
    better: float
    memory: MemoryParameters


@dataclass(frozen=True, slots=True)
class _Barrier:
    """Something on the way. ahead: m. cost: of the way if it were gone; BARRED where it is a wall."""

    ahead: float
    cost: float

    @property
    def may_go(self) -> bool:
        """Whether it was not always there."""
        return self.cost < BARRED


class Guide:
    """For one mission. There is a route from the first look that finds a way until the robot's pose is set anew."""

    def __init__(self, parameters: GuideParameters, memory: Memory, goal: GoalPoint) -> None:
        self._parameters = parameters
        self._memory = memory
        self._goal = goal
        self._route: Route | None = None
        self._near: Terrain | None = None

    @property
    def route(self) -> Route:
        """What is left of the way."""
        assert self._route is not None  # the robot is under way
        return self._route

    @property
    def goal(self) -> Place:
        """In odom."""
        assert self._goal.x is not None
        assert self._goal.y is not None
        return self._goal.x, self._goal.y

    @property
    def pose(self) -> Pose:
        """Of the robot."""
        assert self._memory.pose is not None
        return self._memory.pose

    @property
    def points(self) -> Way:
        """From the robot to the end of the way; none where there is no way."""
        return self._route.points(self._memory.place) if self._route is not None and self._memory.pose else ()

    @property
    def beyond(self) -> Way:
        """What follows where the way ends short of something."""
        return self._route.ends_short[1:] if self._route is not None else ()

    @property
    def target(self) -> SubTarget:
        """The next one."""
        return self.route.targets[0]

    @property
    def following(self) -> Place | None:
        """The one after that, if the robot may round the corner between them."""
        targets = self.route.targets
        return targets[1].place if len(targets) > 1 and not targets[0].lines_up else None

    # Looking for ways.

    def is_too_far(self, now: float) -> bool:
        """Whether no way can be planned so far."""
        return self._memory.survey(self.goal, now) is None

    def look(self, now: float, budget: float = inf) -> float | None:
        """Look for a way, and take it where it costs no more than the budget. Its length, m, or None."""
        ground = self._survey(now)
        way = self._find(ground)
        if way is None or ground.cost_of(*way) > budget:
            return None
        self._take(way, ground)
        return length(way)

    def look_for_better(self, now: float) -> None:
        """Take a way that is clearly cheaper than the present one, or that leads there where this one ends short."""
        present = self._survey(now).cost_of(*self.points)
        is_whole = present < BARRED and not self.route.ends_short
        self.look(now, present * self._parameters.better if is_whole else inf)

    def look_hoping(self, now: float) -> float | None:
        """Look for a way through what may go, and take it up to there. How far away that is, m, or None."""
        ground, hoping = self._survey(now), self._survey(now, self._parameters.memory.cost.hope)
        way = self._find(hoping)
        barred = ground.first_barred(way) if way is not None else None
        if way is None or barred is None:
            return None
        self._take(way, hoping)
        barred = ground.first_barred(self.points) or barred
        self._route = self.route.shortened(barred - self._parameters.stop_before, self._memory.place)
        return barred

    def barrier(self, now: float) -> _Barrier | None:
        """What is on the way near the robot, as it was when it was advanced last."""
        assert self._near is not None  # it has been advanced
        ahead = self._near.first_barred(self.points)
        return _Barrier(ahead, self._survey(now, 0.0).cost_of(*self.points)) if ahead is not None else None

    def make_way(self, barred: Place | None) -> bool:
        """Take a way to a place aside, away from where the way is barred. Whether there is one near."""
        memory, ahead = self._memory, (*self.points, *self.beyond)
        came = thinned(memory.trail[-CAME:])
        way = way_aside(memory.survey_near(), memory.place, (came, ahead), barred, memory.half_width)
        if way is None:
            return False
        corners = tuple(SubTarget(*place) for place in way[1:-1])
        self._route = Route((*corners, SubTarget(*way[-1], is_last=True)), (*reversed(way), *ahead[1:]))
        return True

    def is_hopeless(self, now: float) -> bool:
        """Whether walls are on the way."""
        return self._survey(now, 0.0).cost_of(*self.points, *self.beyond) >= BARRED

    def doubt_goal(self, now: float) -> bool:
        """Forget what is at the goal, if that bars it and was seen from afar only. Whether that was so."""
        if not self._survey(now).is_barred(*self.goal) or self.distance(self.goal) < SURE_FROM:
            return False
        self._memory.grid.doubt(*self.goal, SURE_FROM / 2.0)
        return True

    def why_no_way(self, now: float) -> str:
        """In words."""
        ground, goal = self._survey(now), spoken(self.goal)
        if ground.area.occupied[ground.area.cell(*self.goal)]:
            return f"the goal {goal} is in a wall, or in something that stands there; choose another"
        if ground.is_barred(*self.goal):
            return f"the goal {goal} is too near to a wall for this robot; choose another"
        tried = len(self._memory.doors.believed)
        return f"no way leads to {goal}: all that can be reached was seen, and {tried} doors were tried"

    # On the way.

    def advance(self) -> None:
        """Look around, and leave behind what the robot need not go to any more."""
        self._near = self._memory.survey_near()
        self._route = self.route.advanced(self._near, self._memory.place, self._parameters.near)

    def is_at_goal(self) -> bool:
        """Whether it is as near as was wanted."""
        return self.distance(self.goal) <= self._goal.tolerance

    def is_at_end(self) -> bool:
        """Whether it is at the end of a way that ends short of something that may go."""
        targets = self.route.targets
        return (
            bool(self.route.ends_short)
            and len(targets) == 1
            and self.distance(targets[0].place) <= self._parameters.near
        )

    def door(self) -> int | None:
        """The number of a door that the robot is about to go through, or is in."""
        for target in self.route.targets[:2]:
            if target.door is not None and self.distance(target.place) < AT_DOOR * self._parameters.before_door:
                return target.door
        return None

    def heading(self) -> float:
        """Towards the next sub-target, rad in odom."""
        return self.direction(self.target.place)

    def direction(self, place: Place) -> float:
        """From the robot to a place, rad in odom."""
        x, y = self._memory.place
        return atan2(place[1] - y, place[0] - x)

    def off(self, heading: float) -> float:
        """How far the robot looks away from a heading, rad."""
        return abs(wrap_angle(heading - self.pose[2]))

    def is_off_way(self, most: float) -> bool:
        """Whether it looks farther away than that from a sub-target that is not near."""
        return self.distance(self.target.place) > self._parameters.near and self.off(self.heading()) > most

    def is_before_narrow_door(self) -> bool:
        """Whether it goes through a narrow door next, and is not in it yet, where it could not turn."""
        return self.target.is_narrow and self._door_around() is None

    def distance(self, place: Place) -> float:
        """From the robot, m."""
        x, y = self._memory.place
        return hypot(place[0] - x, place[1] - y)

    def ahead(self, distance: float) -> Place:
        """A place so many m ahead on the way, beyond its end if it ends short of something."""
        return _along((*self.points, *self.beyond), distance)

    def barred_place(self) -> Place:
        """Where the way is barred that ends short."""
        return self.ahead(self._parameters.stop_before + self._memory.half_width)

    def _survey(self, now: float, hopes: float | None = None) -> Terrain:
        ground = self._memory.survey(self.goal, now, hopes=hopes)
        assert ground is not None  # it is not too far
        return ground

    def _find(self, ground: Terrain) -> Way | None:
        robot, out = self._memory.place, self._out_of_door(ground)
        start = robot if out is None else out.place
        way = find_way(ground, start, self.goal, WELL_WITHIN * self._goal.tolerance)
        return way if out is None or way is None else (robot, *way)

    def _take(self, way: Way, ground: Terrain) -> None:
        out = self._out_of_door(ground)
        route = Route.along(way if out is None else way[1:], self._memory.doors, ground, self._passage)
        if out is not None:
            route = Route((out, *route.targets))
        self._route = route.advanced(ground, self._memory.place, self._parameters.near)

    def _out_of_door(self, ground: Terrain) -> SubTarget | None:
        """Where a robot in a door goes first, whatever the way, since it cannot turn about there; None elsewhere."""
        number = self._door_around()
        if number is None:
            return None
        door, place = self._memory.doors.doors[number], self._memory.place
        sense = copysign(1.0, cos(self.pose[2] - door.normal))
        # With its middle behind the door it goes straight on; to go back to the middle line its tail has no room.
        aside = door.aside(place) if sense * door.ahead(place) > 0.0 else 0.0
        out = self._passage.out_of(number, door, sense, aside)
        return out if ground.cost_of(place, out.place) < BARRED else None

    def _door_around(self) -> int | None:
        """The door that the robot is in."""
        return self._memory.doors.around(self._memory.place, IN_DOOR * self._memory.half_width)

    @property
    def _passage(self) -> Passage:
        memory = self._memory
        return Passage(max(self._parameters.before_door, memory.outline.sweep + TO_LINE_UP), memory.half_width)


def spoken(place: Place) -> str:
    """A place as people are told it."""
    return f"({place[0]:.2f}, {place[1]:.2f})"


def _along(points: Sequence[Place], distance: float) -> Place:
    """A place so far along a line, or its end."""
    for start, end in pairwise(points):
        piece = length((start, end))
        if distance < piece:
            part = distance / piece
            return start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
        distance -= piece
    return points[-1]

"""The way to one goal: planning it in the robot's knowledge, and the robot's progress on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, copysign, cos, hypot, inf

from apps.indoor_navigation.algorithms.planning.doors_map import thinned
from apps.indoor_navigation.algorithms.planning.memory import Memory, MemoryParameters
from apps.indoor_navigation.algorithms.planning.route import Passage, Route, SubTarget
from apps.indoor_navigation.algorithms.planning.search import Way, find_way, length, way_aside
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Terrain
from apps.indoor_navigation.data import GoalPoint, Place, Pose
from geometry import wrap_angle

TRAIL_POINTS = 40  # newest points of the trail that must stay free when the robot makes way: 4 m
SURE_RANGE = 2.0  # m from the goal within which an obstacle there is certain
TOLERANCE_PART = 0.6  # of the tolerance within which ways end, because a robot does not stop exactly
TURN_ROOM = 0.2  # m beside the turning circle of a robot that lines up with a door
DOOR_REACH = 1.5  # times the half width of the robot from the line of a door, where it cannot turn round
DOOR_RANGE = 3.0  # times `before_door` to the sub-target behind a door, from which on the robot passes the door


@dataclass(frozen=True, slots=True)
class GuideParameters:
    """Distances on a way in m.

    near: to a sub-target that counts as reached. before_door: of sub-targets before and behind a door; a robot that
    needs more room to turn has them farther away. stop_before: to an obstacle that may go away. better: part of the
    present way's cost below which another way replaces it.
    """

    near: float
    before_door: float
    stop_before: float
    better: float
    memory: MemoryParameters


@dataclass(frozen=True, slots=True)
class _Barrier:
    """An obstacle on the way. ahead: distance, m. cost: of the way without it; BARRED where it is a wall."""

    ahead: float
    cost: float

    @property
    def may_go(self) -> bool:
        """Whether the obstacle may go away."""
        return self.cost < BARRED


class Guide:
    """The way of one mission. There is a route after the first successful `look`, until odom is set anew."""

    def __init__(self, parameters: GuideParameters, memory: Memory, goal: GoalPoint) -> None:
        self._parameters = parameters
        self._memory = memory
        self._goal = goal
        self._route: Route | None = None
        self._near: Terrain | None = None

    @property
    def route(self) -> Route:
        """The rest of the way."""
        assert self._route is not None  # the robot is under way
        return self._route

    @property
    def goal(self) -> Place:
        """The goal in odom."""
        assert self._goal.x is not None
        assert self._goal.y is not None
        return self._goal.x, self._goal.y

    @property
    def pose(self) -> Pose:
        """The pose of the robot."""
        assert self._memory.pose is not None
        return self._memory.pose

    @property
    def points(self) -> Way:
        """Points from the robot to the end of the way; none where there is no way."""
        return self._route.points(self._memory.place) if self._route is not None and self._memory.pose else ()

    @property
    def beyond(self) -> Way:
        """Points beyond an obstacle before which the way ends."""
        return self._route.ends_short[1:] if self._route is not None else ()

    @property
    def target(self) -> SubTarget:
        """The next sub-target."""
        return self.route.targets[0]

    @property
    def following(self) -> Place | None:
        """The sub-target after the next, if the robot may cut the corner."""
        targets = self.route.targets
        return targets[1].place if len(targets) > 1 and not targets[0].lines_up else None

    # Planning.

    def is_too_far(self, now: float) -> bool:
        """Return whether the goal is too far away to plan."""
        return self._memory.survey(self.goal, now) is None

    def look(self, now: float, budget: float = inf) -> float | None:
        """Plan a way, and take it if it costs no more than the budget; return its length, m, or None."""
        ground = self._survey(now)
        way = self._find(ground)
        if way is None or ground.cost_of(*way) > budget:
            return None
        self._take(way, ground)
        return length(way)

    def look_for_better(self, now: float) -> None:
        """Take a way that is clearly cheaper than the present one, or any way if the present one ends short."""
        present = self._survey(now).cost_of(*self.points)
        is_whole = present < BARRED and not self.route.ends_short
        self.look(now, present * self._parameters.better if is_whole else inf)

    def look_hoping(self, now: float) -> float | None:
        """Plan a way through obstacles that may go away, up to the first one; return its distance, m, or None."""
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
        """Return the obstacle on the way near the robot, as of the last `advance`; None where there is none."""
        assert self._near is not None  # it has been advanced
        ahead = self._near.first_barred(self.points)
        return _Barrier(ahead, self._survey(now, 0.0).cost_of(*self.points)) if ahead is not None else None

    def make_way(self, barred: Place | None) -> bool:
        """Take a way to a place aside; return whether there is one near."""
        memory, ahead = self._memory, (*self.points, *self.beyond)
        came = thinned(memory.trail[-TRAIL_POINTS:])
        way = way_aside(memory.survey_near(), memory.place, (came, ahead), barred, memory.half_width)
        if way is None:
            return False
        corners = tuple(SubTarget(*place) for place in way[1:-1])
        self._route = Route((*corners, SubTarget(*way[-1], is_last=True)), (*reversed(way), *ahead[1:]))
        return True

    def is_hopeless(self, now: float) -> bool:
        """Return whether a wall is on the way."""
        return self._survey(now, 0.0).cost_of(*self.points, *self.beyond) >= BARRED

    def doubt_goal(self, now: float) -> bool:
        """Forget an obstacle at the goal if it was seen from afar only; return whether that was so."""
        if not self._survey(now).is_barred(*self.goal) or self.distance(self.goal) < SURE_RANGE:
            return False
        self._memory.grid.doubt(*self.goal, SURE_RANGE / 2.0)
        return True

    def why_no_way(self, now: float) -> str:
        """Return the reason in words."""
        ground, goal = self._survey(now), place_text(self.goal)
        if ground.area.occupied[ground.area.cell(*self.goal)]:
            return f"the goal {goal} is in a wall, or in something that stands there; choose another"
        if ground.is_barred(*self.goal):
            return f"the goal {goal} is too near to a wall for this robot; choose another"
        tried = len(self._memory.doors.believed)
        return f"no way leads to {goal}: all that can be reached was seen, and {tried} doors were tried"

    # Progress on the way.

    def advance(self) -> None:
        """Update the costs near the robot, and remove sub-targets that are not needed any more."""
        self._near = self._memory.survey_near()
        self._route = self.route.advanced(self._near, self._memory.place, self._parameters.near)

    def is_at_goal(self) -> bool:
        """Return whether the robot is within the tolerance of the goal."""
        return self.distance(self.goal) <= self._goal.tolerance

    def is_at_end(self) -> bool:
        """Return whether the robot is at the end of a way that ends before an obstacle."""
        targets = self.route.targets
        return (
            bool(self.route.ends_short)
            and len(targets) == 1
            and self.distance(targets[0].place) <= self._parameters.near
        )

    def door(self) -> int | None:
        """Return the number of a door that the robot is about to pass, or is in."""
        for target in self.route.targets[:2]:
            if target.door is not None and self.distance(target.place) < DOOR_RANGE * self._parameters.before_door:
                return target.door
        return None

    def heading(self) -> float:
        """Return the direction to the next sub-target, rad in odom."""
        return self.direction(self.target.place)

    def direction(self, place: Place) -> float:
        """Return the direction from the robot to a place, rad in odom."""
        x, y = self._memory.place
        return atan2(place[1] - y, place[0] - x)

    def off(self, heading: float) -> float:
        """Return the difference of the robot's heading to another, rad, not negative."""
        return abs(wrap_angle(heading - self.pose[2]))

    def is_off_way(self, most: float) -> bool:
        """Return whether the robot's heading differs by more from the direction to a sub-target that is not near."""
        return self.distance(self.target.place) > self._parameters.near and self.off(self.heading()) > most

    def is_before_narrow_door(self) -> bool:
        """Return whether the robot passes a narrow door next and is not in it yet."""
        return self.target.is_narrow and self._door_around() is None

    def distance(self, place: Place) -> float:
        """Return the distance from the robot, m."""
        x, y = self._memory.place
        return hypot(place[0] - x, place[1] - y)

    def ahead(self, distance: float) -> Place:
        """Return the place so many m ahead on the way, beyond its end if it ends before an obstacle."""
        return _along((*self.points, *self.beyond), distance)

    def barred_place(self) -> Place:
        """Return where a way that ends short is barred."""
        return self.ahead(self._parameters.stop_before + self._memory.half_width)

    def _survey(self, now: float, hopes: float | None = None) -> Terrain:
        ground = self._memory.survey(self.goal, now, hopes=hopes)
        assert ground is not None  # `is_too_far` was asked before
        return ground

    def _find(self, ground: Terrain) -> Way | None:
        robot, out = self._memory.place, self._out_of_door(ground)
        start = robot if out is None else out.place
        way = find_way(ground, start, self.goal, TOLERANCE_PART * self._goal.tolerance)
        return way if out is None or way is None else (robot, *way)

    def _take(self, way: Way, ground: Terrain) -> None:
        out = self._out_of_door(ground)
        route = Route.along(way if out is None else way[1:], self._memory.doors, ground, self._passage)
        if out is not None:
            route = Route((out, *route.targets))
        self._route = route.advanced(ground, self._memory.place, self._parameters.near)

    def _out_of_door(self, ground: Terrain) -> SubTarget | None:
        """Return the first sub-target of a robot in a door, because it cannot turn round there; None elsewhere."""
        number = self._door_around()
        if number is None:
            return None
        door, place = self._memory.doors.doors[number], self._memory.place
        sense = copysign(1.0, cos(self.pose[2] - door.normal))
        # With its middle behind the door it drives straight on; the tail has no room to return to the middle line.
        aside = door.aside(place) if sense * door.ahead(place) > 0.0 else 0.0
        out = self._passage.out_of(number, door, sense, aside)
        return out if ground.cost_of(place, out.place) < BARRED else None

    def _door_around(self) -> int | None:
        """Return the number of the door that the robot is in; None where it is in none."""
        return self._memory.doors.around(self._memory.place, DOOR_REACH * self._memory.half_width)

    @property
    def _passage(self) -> Passage:
        memory = self._memory
        return Passage(max(self._parameters.before_door, memory.outline.sweep + TURN_ROOM), memory.half_width)


def place_text(place: Place) -> str:
    """Return a place as text for people."""
    return f"({place[0]:.2f}, {place[1]:.2f})"


def _along(points: Sequence[Place], distance: float) -> Place:
    """Return the place at a distance along a polyline, or its end."""
    for start, end in pairwise(points):
        piece = length((start, end))
        if distance < piece:
            part = distance / piece
            return start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
        distance -= piece
    return points[-1]

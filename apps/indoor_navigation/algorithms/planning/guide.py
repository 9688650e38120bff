"""The way to one goal: planning it in the robot's knowledge, and the robot's progress on it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, inf, sin

from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.doors_map import thinned
from apps.indoor_navigation.algorithms.planning.ground import Ground
from apps.indoor_navigation.algorithms.planning.lattice import PlanSearch, missing_width, turn_piece
from apps.indoor_navigation.algorithms.planning.memory import Memory, MemoryParameters
from apps.indoor_navigation.algorithms.planning.plan import Motion, Plan, PlanPiece
from apps.indoor_navigation.algorithms.planning.search import Way, length, way_aside
from apps.indoor_navigation.algorithms.planning.terrain import BARRED
from apps.indoor_navigation.data import Bools, GoalPoint, Place, Pose
from geometry import wrap_angle

TRAIL_POINTS = 40  # newest points of the trail that must stay free when the robot makes way: 4 m
OUT_OF_VIEW = 10.0  # s after which an obstacle may have gone away unseen
SURE_RANGE = 2.0  # m from the goal within which an obstacle there is certain
TOLERANCE_PART = 0.6  # of the tolerance within which ways end, because a robot does not stop exactly
DOOR_AHEAD = 2.0  # m along the way within which a door is announced
PATH_POSES = 20  # of a piece that are sent as the path: 3 m
TURN_POSES = 13  # of a turn that are ordered at once: below pi, so the side is clear
NEXT_POSES = 12  # of a piece among which the robot's progress is looked for
REACHED = 0.1  # m before the end of a piece where it counts as driven
FACING = 0.12  # rad off the end of a turn where it counts as turned
OFF_PLAN = 0.5  # m off the plan from which on it is no use
ASIDE_TOLERANCE = 0.2  # m from a place aside
SEARCH_AGAIN = 2.0  # s after a search without a result; it takes far longer than one that finds a way
CHEAPER = 0.5  # m that the estimated cost must have decreased by, for a search before that time


@dataclass(frozen=True, slots=True)
class GuideParameters:
    """Distances on a way in m.

    near: to the end of a way that counts as reached. stop_before: to an obstacle that may go away. better: part of the
    present way's cost below which another way replaces it.
    """

    near: float
    stop_before: float
    better: float
    memory: MemoryParameters

    @property
    def follow_from(self) -> float:
        """Free way, m, to what may go away from which on the robot follows it; within it the robot may wait."""
        return 2.0 * self.stop_before


@dataclass(frozen=True, slots=True)
class _Barrier:
    """An obstacle on the way. ahead: distance, m. cost: of the way without what came; BARRED if that is not enough."""

    ahead: float
    cost: float

    @property
    def may_go(self) -> bool:
        """Whether the obstacle may go away."""
        return self.cost < BARRED


class Guide:
    """The way of one mission. There is a plan after the first successful `look`, until odom is set anew."""

    def __init__(self, parameters: GuideParameters, memory: Memory, goal: GoalPoint) -> None:
        self._parameters = parameters
        self._memory = memory
        self._goal = goal
        self._plan: Plan | None = None
        self._near: Ground | None = None
        self._doubted: list[Place] = []  # gaps
        self._failed: tuple[float, float] | None = None  # estimate and s of the last search, if it found no way

    @property
    def plan(self) -> Plan:
        """The rest of the way."""
        assert self._plan is not None  # the robot is under way
        return self._plan

    @property
    def piece(self) -> PlanPiece:
        """The present piece of the way."""
        return self.plan.pieces[0]

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
        if self._plan is None or self._memory.pose is None:
            return ()
        return (self._memory.place, *((x, y) for x, y, _ in self._plan.poses.tolist()))

    @property
    def ends(self) -> Way:
        """The ends of the pieces of the way."""
        return tuple(piece.end[:2] for piece in self._plan.pieces) if self._plan is not None else ()

    @property
    def sub_target(self) -> Place | None:
        """The end of the path that the robot follows at present; None where there is no way."""
        return self.path[-1] if self._plan is not None else None

    @property
    def path(self) -> Way:
        """Points of the present piece, up to some m ahead."""
        return tuple((x, y) for x, y, _ in self.piece.poses[:PATH_POSES].tolist())

    @property
    def heading(self) -> float:
        """The heading to turn to now in a turn, so that the robot turns to the side of the plan."""
        return float(self.piece.poses[:TURN_POSES][-1, 2])

    @property
    def ends_here(self) -> bool:
        """Whether the path leads to the end of the present piece."""
        return len(self.piece.poses) <= PATH_POSES

    # Planning.

    def is_too_far(self, now: float) -> bool:
        """Return whether the goal is too far away to plan."""
        return self._memory.survey(self.goal, now) is None

    def look(
        self, now: float, budget: float = inf, barred: Place | None = None, *, afresh: bool = False
    ) -> float | None:
        """Plan a way, and take it if it costs no more than the budget; return its length, m, or None.

        Args:
            now: s.
            budget: Of its cost.
            barred: A place where somebody was in the way, and may still be.
            afresh: Search even if there was no way a moment ago and little seems to have changed.
        """
        ground = self._survey(now, barred=barred)
        search = self._search(ground)
        if self._failed is not None and not afresh:
            estimate, at = self._failed
            if now < at + SEARCH_AGAIN and search.estimate > estimate - CHEAPER:
                return None
        plan = search.find()
        if plan is None and ground.held:
            plan = self._search(ground._replace(held=())).find()
        self._failed = (search.estimate, now) if plan is None else None
        return self._take(plan, ground, budget)

    def look_for_better(self, now: float) -> None:
        """Take a way that is clearly cheaper than the present one, or any way if the present one is of no use."""
        ground, plan = self._survey(now), self.plan
        present = plan.cost(ground.for_present_plan())
        nearest = plan.poses[: 2 * NEXT_POSES, :2] - self._memory.place
        is_off = float(abs(nearest).max(axis=1).min()) > OFF_PLAN
        is_use = present < BARRED and not plan.beyond and not is_off
        self._take(self._search(ground).find(), ground, present * self._parameters.better if is_use else inf)

    def look_hoping(self, now: float) -> float | None:
        """Plan a way through obstacles that may go away, up to the first one; return its distance, m, or None."""
        ground, hoping = self._survey(now), self._survey(now, _staying, self._parameters.memory.cost.hope)
        plan = self._search(hoping._replace(held=())).find()
        barred = plan.first_barred(ground) if plan is not None else None
        if plan is None or barred is None:
            return None
        self._plan = plan.shortened(max(barred - self._parameters.stop_before, 0.0))
        return barred

    def barrier(self, now: float) -> _Barrier | None:
        """Return the obstacle on the way near the robot, as of the last `advance`; None where there is none."""
        assert self._near is not None  # it has been advanced
        ahead = self.plan.shortened(self._parameters.memory.near).first_barred(self._near.for_present_plan())
        if ahead is None:
            return None
        return _Barrier(ahead, self.plan.cost(self._survey(now, _staying).for_present_plan()))

    def goes_on(self, now: float, free: float) -> bool:
        """Return whether what barred the way has left more than so many m of it free."""
        self.advance()
        barrier = self.barrier(now)
        return barrier is None or (barrier.may_go and barrier.ahead > free)

    def make_way(self, barred: Place | None) -> bool:
        """Take a way to a place aside; return whether there is one near."""
        memory, ahead = self._memory, (*self.points, *self._beyond)
        came = thinned(memory.trail[-TRAIL_POINTS:])
        way = way_aside(memory.survey_flat(), memory.place, (came, ahead), barred, memory.half_width)
        plan = PlanSearch(memory.survey_near(), way[-1], ASIDE_TOLERANCE).find() if way is not None else None
        if way is None or plan is None:
            return False
        self._plan = Plan(plan.pieces, (*reversed(way), *ahead[1:]))
        return True

    def is_hopeless(self, now: float) -> bool:
        """Return whether a wall is on the way."""
        walls, beyond = self._survey(now, _walls).for_present_plan(), self._beyond
        if self.plan.cost(walls) >= BARRED:
            return True
        return bool(beyond) and any(walls.is_barred(place) for place in beyond)

    def doubt_goal(self, now: float) -> bool:
        """Forget an obstacle at the goal that was seen from afar only, and what may have gone and is out of view.

        Return whether there was anything.
        """
        is_news = self._memory.forget_transient(OUT_OF_VIEW, with_panes=True) or self._memory.doubt_map()
        if not self._survey(now).is_barred(self.goal) or self.distance(self.goal) < SURE_RANGE:
            return is_news
        self._memory.grid.doubt(*self.goal, SURE_RANGE / 2.0)
        return True

    def doubt_narrowest(self, now: float) -> bool:
        """Forget the sides of the gap that is too narrow, as far as they are out of view; once for each gap.

        The robot looks at it again from nearer before it gives up: what stood there, or beside it, may have gone, and
        from afar a gap is known to some cm only. Return whether there was anything.
        """
        missing = missing_width(self._survey(now), self.goal, self._goal.tolerance)
        if missing is None:
            return False
        (x, y), width = missing[1], self._memory.outline.width
        if any(hypot(x - other_x, y - other_y) < width for other_x, other_y in self._doubted):
            return False
        self._doubted.append((x, y))
        return self._memory.doubt((x, y), width)

    def why_forbidden(self) -> str | None:
        """Return why the map forbids this mission, in words; None where it does not."""
        if self._memory.is_forbidden(self.goal):
            goal = place_text(self.goal)
            return f"the goal {goal} is in a forbidden area of the map, or on a forbidden line; choose another"
        if self._memory.is_forbidden(self._memory.place):
            return "the robot is in a forbidden area of the map; drive it out by hand"
        return None

    def why_no_way(self, now: float) -> str:
        """Return the reason in words."""
        ground, goal = self._survey(now), place_text(self.goal)
        if ground.is_occupied(self.goal):
            return f"the goal {goal} is in a wall, or in something that stands there; choose another"
        if ground.is_barred(self.goal):
            return f"the goal {goal} is too near to a wall or a forbidden line for this robot; choose another"
        missing = missing_width(ground, self.goal, self._goal.tolerance)
        if missing is not None:
            lack, place = missing
            return f"no way to {goal} is as wide as this robot: {lack:.2f} m are missing at {place_text(place)}"
        tried = len(self._memory.doors.believed)
        return f"no way leads to {goal}: all that can be reached was seen, and {tried} doors were tried"

    # Progress on the way.

    def advance(self) -> None:
        """Update the costs near the robot, and remove what has been driven of the plan."""
        self._near = self._memory.survey_near()
        plan = self.plan
        while len(plan.pieces) > 1 and self._is_driven(plan.pieces[0]):
            plan = plan.without_first()
        first = plan.pieces[0]
        is_turn = first.motion is Motion.TURN
        at = first.nearest_turn(self.pose[2]) if is_turn else first.nearest(self._memory.place, NEXT_POSES)
        self._plan = plan.advanced(at)

    def turn_to(self, heading: float) -> None:
        """Turn on the spot to a heading from now on, to the side where there is room."""
        self._plan = Plan((turn_piece(self._memory.survey_near(), heading),))

    def is_at_goal(self) -> bool:
        """Return whether the robot is within the tolerance of the goal."""
        return self.distance(self.goal) <= self._goal.tolerance

    def is_at_end(self) -> bool:
        """Return whether the robot is at the end of a way that ends before an obstacle."""
        plan = self.plan
        return bool(plan.beyond) and len(plan.pieces) == 1 and self.distance(plan.beyond[0]) <= self._parameters.near

    def door(self) -> int | None:
        """Return the number of a door that the robot is about to pass, or is in."""
        points, ahead = self.points, 0.0
        for start, end in pairwise(points[:PATH_POSES]):
            crossing = self._memory.doors.crossed(start, end)
            if crossing is not None:
                return crossing[0]
            ahead += length((start, end))
            if ahead > DOOR_AHEAD:
                break
        return self._memory.doors.around(self._memory.place, self._memory.half_width)

    def direction(self, place: Place) -> float:
        """Return the direction from the robot to a place, rad in odom."""
        x, y = self._memory.place
        return atan2(place[1] - y, place[0] - x)

    def off(self, heading: float) -> float:
        """Return the difference of the robot's heading to another, rad, not negative."""
        return abs(wrap_angle(heading - self.pose[2]))

    def distance(self, place: Place) -> float:
        """Return the distance from the robot, m."""
        x, y = self._memory.place
        return hypot(place[0] - x, place[1] - y)

    def ahead(self, distance: float) -> Place:
        """Return the place so many m ahead on the way, beyond its end if it ends before an obstacle."""
        return _along((*self.points, *self._beyond), distance)

    def barred_place(self) -> Place:
        """Return where a way that ends short is barred."""
        return self.ahead(length(self.points) + self._parameters.stop_before + self._memory.half_width)

    @property
    def _beyond(self) -> Way:
        return self._plan.beyond if self._plan is not None else ()

    def _is_driven(self, piece: PlanPiece) -> bool:
        """Return whether the robot is at the end of a piece, or beside it."""
        x, y, heading = piece.end
        if piece.motion is Motion.TURN:
            return self.off(heading) < FACING
        left_x, left_y = x - self._memory.place[0], y - self._memory.place[1]
        left = left_x * cos(heading) + left_y * sin(heading)
        is_near = hypot(left_x, left_y) < OFF_PLAN
        return is_near and (left if piece.motion is Motion.GO else -left) < REACHED

    def _survey(
        self,
        now: float,
        standing: Callable[[Area], Bools] | None = None,
        hope: float = 0.0,
        barred: Place | None = None,
    ) -> Ground:
        ground = self._memory.survey(self.goal, now, standing=standing, hope=hope, barred=barred)
        assert ground is not None  # `is_too_far` was asked before
        return ground

    def _search(self, ground: Ground) -> PlanSearch:
        return PlanSearch(ground, self.goal, TOLERANCE_PART * self._goal.tolerance)

    def _take(self, plan: Plan | None, ground: Ground, budget: float) -> float | None:
        """Take a plan if it costs no more than the budget; return its length, m, or None."""
        if plan is None or plan.cost(ground) > budget:
            return None
        self._plan = plan
        return float(plan.lengths[-1])


def _walls(area: Area) -> Bools:
    return area.walls


def _staying(area: Area) -> Bools:
    return area.staying


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

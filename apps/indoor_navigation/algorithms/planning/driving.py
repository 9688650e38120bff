"""Orders while the robot moves: it drives along the way, turns to it, and backs out where it cannot turn.

It drives round an obstacle on the way, or waits for it to go away as long as a detour would take.
"""

from math import copysign, inf, pi

from apps.indoor_navigation.algorithms.planning.guide import place_text
from apps.indoor_navigation.algorithms.planning.orders import Order
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import Waiting
from apps.indoor_navigation.data import Place
from geometry import wrap_angle

MAX_BACK_ANGLE = 1.0  # rad between the way back and straight back
TURN_PART = 2.0  # rad of a turn the longer way round that are ordered at once; below pi, so the side is clear
RETRY_RANGE = 0.5  # m from where backing out or turning to the target was of no use, within which it is not repeated


class Driving:
    """Each of `turn`, `go` and `back` returns an order, or None where another state has followed."""

    def __init__(self, situation: Situation) -> None:
        self._situation = situation
        self._parameters = situation.parameters
        self._memory = situation.memory
        self._machine = situation.machine
        self._progress = situation.progress
        self._back_to = 0  # the breadcrumb
        self._backed_from: Place | None = None
        self._held_at: Place | None = None  # where backing out was of no use
        self._faced_at: Place | None = None  # where it turned to face the target
        self._barred_side = 0.0  # side of the present turn that is barred: 1 left, -1 right

    def turn(self, now: float) -> Order | None:
        """Turn on the spot, to the way, or at the end to the goal's heading."""
        situation, guide, parameters = self._situation, self._situation.guide, self._parameters
        wanted = situation.goal.heading if situation.is_there else None
        heading = wanted if wanted is not None else guide.heading()
        if not self._barred_side and self._progress.is_held(guide.pose, now):
            self._bar_side(heading)
        if self._comes_no_farther(now):
            return None
        situation.end_making_way(now)
        is_exact = guide.is_before_narrow_door() or self._has_faced()
        until = parameters.door_until if is_exact else parameters.turn_until
        if guide.off(heading) > (parameters.heading if wanted is not None else until):
            return Order("turn", heading=self._round(heading))
        if wanted is not None:
            situation.arrive(now)
        else:
            self._machine.happens(MissionEvent.HAS_TURNED, now, "the way lies ahead")
        return None

    def go(self, now: float) -> Order | None:
        """Drive along the way, and through doors."""
        situation, guide, parameters = self._situation, self._situation.guide, self._parameters
        self._barred_side = 0.0
        guide.advance()
        if self._has_arrived(now) or self._faces(now) or self._comes_no_farther(now) or self._is_barred(now):
            return None
        situation.end_making_way(now)
        is_free = situation.state is not MissionState.PASSING and situation.making_way.waiting is None
        if is_free and now >= situation.looked_at + parameters.look:
            situation.looked_at = now
            guide.look_for_better(now)
        self._mind_door(now)
        if self._has_to_turn(now):
            return None
        target = guide.target
        speed = parameters.door_speed if situation.state is MissionState.PASSING else parameters.speed
        is_stop = target.is_last or target.lines_up
        return Order("go", target.x, target.y, guide.heading(), speed, is_stop, guide.following)

    def back(self, now: float) -> Order | None:
        """Drive back along the path to where there is room to turn."""
        crumbs, guide = self._memory.crumbs, self._situation.guide
        if len(crumbs) - 1 <= self._back_to:
            self._machine.happens(MissionEvent.HAS_BACKED, now, "there is room to turn")
            return None
        x, y = crumbs.towards(self._back_to)
        if guide.off(guide.direction((x, y)) + pi) > MAX_BACK_ANGLE:
            self._held_at = self._backed_from
            self._machine.happens(MissionEvent.HAS_BACKED, now, "the way back does not lead straight back")
            return None
        if self._progress.is_stuck(guide.pose, now):
            self._held_at = self._backed_from
            if not self._situation.has_tried_enough(now):
                self._machine.happens(MissionEvent.CAME_NO_FARTHER, now, "the robot cannot go back")
            return None
        return Order("back", x, y, speed=self._parameters.back_speed)

    def _faces(self, now: float) -> bool:
        """Turn to the target on the spot, once at one place, where goto finds no path.

        Each path of goto bends from the present heading; facing the target, a straight path may be free.
        """
        guide, place = self._situation.guide, self._memory.place
        if self._has_faced() or not self._progress.is_held(guide.pose, now):
            return False
        if not guide.is_off_way(self._parameters.door_until) or not self._memory.may_turn_to(place, guide.target.place):
            return False
        self._faced_at = place
        self._machine.happens(MissionEvent.HAS_TO_TURN, now, "to look where it is to go")
        return True

    def _has_faced(self) -> bool:
        return self._faced_at is not None and self._situation.guide.distance(self._faced_at) < RETRY_RANGE

    def _bar_side(self, heading: float) -> None:
        """Turn the other way round from now on, because the shorter turn is barred."""
        self._barred_side = copysign(1.0, wrap_angle(heading - self._situation.guide.pose[2]))
        self._progress.go_on()
        self._situation.note("info", "turning the other way round")

    def _round(self, heading: float) -> float:
        """Return the heading to order now, so that the shorter turn is to the free side."""
        present = self._situation.guide.pose[2]
        is_barred = wrap_angle(heading - present) * self._barred_side > 0.0
        return wrap_angle(present - self._barred_side * TURN_PART) if is_barred else heading

    def _has_arrived(self, now: float) -> bool:
        """Handle the goal, or the end of a way that ends short; return whether the robot is there."""
        situation, guide = self._situation, self._situation.guide
        if guide.is_at_goal():
            situation.is_there = True
            heading = situation.goal.heading
            if heading is not None and guide.off(heading) > self._parameters.heading:
                self._machine.happens(MissionEvent.HAS_TO_TURN, now, "there, and turning to the heading that is wanted")
            else:
                situation.arrive(now)
            return True
        if guide.is_at_end():
            self._wait_at_end(now)
            return True
        return False

    def _is_barred(self, now: float) -> bool:
        """Handle an obstacle on the way: plan round it, wait, or drive on while it is far; return whether to stop."""
        situation, guide, parameters = self._situation, self._situation.guide, self._parameters
        barrier = guide.barrier(now)
        if barrier is None:
            return False
        if situation.making_way.waiting is not None:
            self._wait_at_end(now)
            return True
        if situation.look(now, barrier.cost + parameters.detour if barrier.may_go else inf) is not None:
            return False
        situation.barred = guide.ahead(barrier.ahead + self._memory.half_width)
        if not barrier.may_go:
            self._machine.happens(
                MissionEvent.CAME_NO_FARTHER, now, f"a wall is in the way, {barrier.ahead:.1f} m ahead"
            )
            return True
        if barrier.ahead > 2.0 * parameters.guide.stop_before:
            return False
        why = f"something is in the way, {barrier.ahead:.1f} m ahead"
        waiting = Waiting(why, now, now + parameters.patience, barrier.cost, situation.barred)
        situation.wait_for(now, MissionEvent.WAY_BARRED, waiting)
        return True

    def _wait_at_end(self, now: float) -> None:
        """Wait at the end of a way that ends short, or aside."""
        situation, parameters = self._situation, self._parameters
        if (waiting := situation.making_way.waiting) is not None:
            situation.wait_for(now, MissionEvent.WAY_BARRED, waiting.aside(now + parameters.aside))
            return
        place = situation.barred = situation.guide.barred_place()
        why = f"the only way is barred near {place_text(place)}"
        waiting = Waiting(why, now, now + parameters.hope, place=place, is_last_hope=True)
        situation.wait_for(now, MissionEvent.WAY_BARRED, waiting)

    def _comes_no_farther(self, now: float) -> bool:
        if not self._progress.is_stuck(self._situation.guide.pose, now):
            return False
        if not self._situation.has_tried_enough(now):
            radius = self._parameters.progress.avoid
            self._memory.avoid(self._situation.guide.ahead(radius), radius, now + self._parameters.progress.avoid_for)
            why = f"the robot comes no farther at {place_text(self._memory.place)}"
            if not self._backs(now, self._memory.way_back(self._situation.guide.target.place), why):
                self._machine.happens(MissionEvent.CAME_NO_FARTHER, now, why)
        return True

    def _has_to_turn(self, now: float) -> bool:
        """Begin a turn if the way leads elsewhere, or back out where there is no room to turn."""
        guide, parameters = self._situation.guide, self._parameters
        if not guide.is_off_way(parameters.door_from if guide.is_before_narrow_door() else parameters.turn_from):
            return False
        place, target = self._memory.place, guide.target.place
        has_no_room = guide.is_off_way(parameters.turn_from) and not self._memory.may_turn_to(place, target)
        way_back = self._memory.way_back(target) if has_no_room else None
        if not self._backs(now, way_back, "there is no room to turn to where the way leads"):
            self._progress.turn(place)
            self._machine.happens(MissionEvent.HAS_TO_TURN, now, "the way leads elsewhere")
        return True

    def _backs(self, now: float, way_back: int | None, why: str) -> bool:
        """Begin to back out, unless that was of no use here; return whether it did."""
        is_held = self._held_at is not None and self._situation.guide.distance(self._held_at) < RETRY_RANGE
        if way_back is None or is_held:
            return False
        self._back_to, self._backed_from = way_back, self._memory.place
        self._machine.happens(MissionEvent.HAS_TO_BACK, now, why)
        return True

    def _mind_door(self, now: float) -> None:
        door, state = self._situation.guide.door(), self._situation.state
        if door is not None and state is MissionState.GOING:
            self._machine.happens(MissionEvent.DOOR_AHEAD, now, f"through door {door}")
        elif door is None and state is MissionState.PASSING:
            self._machine.happens(MissionEvent.DOOR_PASSED, now, "behind the door")

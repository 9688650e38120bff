"""Orders while the robot moves: it drives the plan piece by piece, round obstacles, or waits for them to go away."""

from math import inf

from apps.indoor_navigation.algorithms.planning.guide import place_text
from apps.indoor_navigation.algorithms.planning.orders import Order
from apps.indoor_navigation.algorithms.planning.plan import Motion
from apps.indoor_navigation.algorithms.planning.right_of_way import PATIENCE
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import Waiting
from apps.indoor_navigation.data import DIGITS

HALTED = 1.0  # s without a motion after which the robot counts as stopped by what is ahead


class Driving:
    """Returns an order at each step, or None where another state has followed."""

    def __init__(self, situation: Situation) -> None:
        self._situation = situation
        self._parameters = situation.parameters
        self._memory = situation.memory
        self._machine = situation.machine
        self._progress = situation.progress

    def follow(self, now: float) -> Order | None:
        """Drive along the plan, and at the end turn to the goal's heading."""
        situation, guide, parameters = self._situation, self._situation.guide, self._parameters
        guide.advance()
        if self._has_arrived(now) or self._comes_no_farther(now):
            return None
        if situation.is_there:
            return self._order()
        if self._is_barred(now) or self._has_to_give_way(now):
            return None
        situation.end_making_way(now)
        if situation.making_way.waiting is None and now >= situation.looked_at + parameters.look:
            situation.looked_at = now
            guide.look_for_better(now)
        self._mind_motion(now)
        return self._order()

    def _order(self) -> Order:
        """Return the order for the present piece."""
        guide, parameters = self._situation.guide, self._parameters
        if guide.piece.motion is Motion.TURN:
            return Order("turn", heading=guide.heading)
        path = tuple(round(value, DIGITS) for point in guide.path for value in point)
        speed = parameters.speed if guide.piece.motion is Motion.GO else parameters.back_speed
        x, y = path[-2:]
        return Order(str(guide.piece.motion), x, y, speed=speed, is_last=guide.ends_here, path=path)

    def _mind_motion(self, now: float) -> None:
        """Take the state of the present piece."""
        motion, state = self._situation.guide.piece.motion, self._situation.state
        if motion is Motion.TURN:
            if state is not MissionState.TURNING:
                self._machine.happens(MissionEvent.HAS_TO_TURN, now, "the way leads elsewhere")
            return
        if motion is Motion.BACK:
            if state is not MissionState.BACKING:
                self._machine.happens(MissionEvent.HAS_TO_BACK, now, "there is more room behind")
            return
        if state in (MissionState.TURNING, MissionState.BACKING):
            self._machine.happens(MissionEvent.LEADS_ON, now, "the way leads ahead")
        door = self._situation.guide.door()
        if door is not None and self._situation.state is MissionState.GOING:
            self._machine.happens(MissionEvent.DOOR_AHEAD, now, f"through door {door}")
        elif door is None and self._situation.state is MissionState.PASSING:
            self._machine.happens(MissionEvent.DOOR_PASSED, now, "behind the door")

    def _has_arrived(self, now: float) -> bool:
        """Handle the goal, or the end of a way that ends short; return whether another state has followed."""
        situation, guide = self._situation, self._situation.guide
        if situation.is_there or guide.is_at_goal():
            heading = situation.goal.heading
            if heading is None or guide.off(heading) <= self._parameters.heading:
                situation.arrive(now)
                return True
            if not situation.is_there:
                situation.is_there = True
                guide.turn_to(heading)
                self._machine.happens(MissionEvent.HAS_TO_TURN, now, "there, and turning to the heading that is wanted")
            return False
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
        if not situation.is_time_to_look(now):
            return False  # goto stops before the obstacle meanwhile
        if situation.look(now, barrier.cost + parameters.detour if barrier.may_go else inf) is not None:
            return False
        situation.barred = guide.ahead(barrier.ahead + self._memory.half_width)
        comes_nearer = self._progress.stands_for(now) < HALTED and barrier.ahead > parameters.guide.stop_before
        if comes_nearer or barrier.ahead > parameters.guide.follow_from:
            return False  # it sees more from there
        if not barrier.may_go:
            self._machine.happens(
                MissionEvent.CAME_NO_FARTHER, now, f"a wall is in the way, {barrier.ahead:.1f} m ahead"
            )
            return True
        why = f"something is in the way, {barrier.ahead:.1f} m ahead"
        waiting = Waiting(why, now, now + parameters.patience, barrier.cost, situation.barred)
        situation.wait_for(now, MissionEvent.WAY_BARRED, waiting)
        return True

    def _has_to_give_way(self, now: float) -> bool:
        """Wait before a passage that another robot has; return whether that is so."""
        situation, rights = self._situation, self._situation.rights
        passage = rights.barred
        if passage is None or situation.making_way.waiting is not None:
            return False
        holder = next((rights.holders[name] for name in rights.ahead if name in rights.holders), None)
        passes = f"{holder} passes" if holder is not None else "the right of way has not come yet for"
        why = f"{passes} a narrow place, {passage.enters:.1f} m ahead"
        place = situation.guide.ahead(passage.enters)
        waiting = Waiting(why, now, now + PATIENCE, place=place, passages=rights.ahead)
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
            place, parameters = self._memory.place, self._parameters.progress
            self._memory.hold_up(place, now + parameters.avoid_for)
            if self._progress.strikes > 1:  # more room was no help
                self._memory.avoid(
                    self._situation.guide.ahead(parameters.avoid), parameters.avoid, now + parameters.avoid_for
                )
            why = f"the robot comes no farther at {place_text(place)}"
            self._machine.happens(MissionEvent.CAME_NO_FARTHER, now, why)
        return True

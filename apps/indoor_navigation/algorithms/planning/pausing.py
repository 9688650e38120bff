"""Orders while the robot stands: it plans a way, waits, goes aside, and gives up in the end.

An obstacle that was not always there may go away. Where the only way leads through such an obstacle, the robot drives
up to it and waits; if it stays, it counts as a wall. So each mission ends.
"""

from math import inf

from apps.indoor_navigation.algorithms.planning.guide import place_text
from apps.indoor_navigation.algorithms.planning.orders import REST, Order
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import MissionEvent
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT, Waiting

YIELDED = 0.3  # m of the way that somebody who was asked leaves free, and the robot follows
GIVE_WAY = 1.0  # s of waiting for a robot in a passage after which this one goes out of its way


class Pausing:
    """Each of `replan` and `wait` returns an order, or None where another state has followed."""

    def __init__(self, situation: Situation) -> None:
        self._situation = situation
        self._parameters = situation.parameters
        self._memory = situation.memory
        self._machine = situation.machine

    def replan(self, now: float) -> Order | None:
        """Plan a way, or one through obstacles that may go away; give up if there has been none for long."""
        situation, guide, sure = self._situation, self._situation.guide, self._parameters.sure
        if guide.is_too_far(now):
            situation.give_up(now, f"{place_text(guide.goal)} is too far away to plan a way there")
        elif (why := guide.why_forbidden()) is not None:
            situation.give_up(now, why)
        elif (found := situation.look(now, afresh=True)) is not None:
            self._machine.happens(MissionEvent.WAY_FOUND, now, f"a way of {found:.1f} m")
        elif (barred := guide.look_hoping(now)) is not None:
            why = f"the only way is barred near {place_text(guide.barred_place())}, {barred:.1f} m from here"
            situation.no_way_since = inf
            self._machine.happens(MissionEvent.WAY_FOUND, now, why)
        elif now - situation.no_way_since < sure:
            situation.no_way_since = min(situation.no_way_since, now)
            until = situation.no_way_since + sure
            waiting = Waiting("there is no way at the moment", now, until, place=situation.barred)
            situation.wait_for(now, MissionEvent.WAY_BARRED, waiting)
        elif situation.doubts and guide.doubt_goal(now):
            situation.doubts -= 1  # people may have stood there; look again from nearer
        elif guide.doubt_narrowest(now):
            situation.no_way_since = inf
        else:
            situation.give_up(now, guide.why_no_way(now))
        return None

    def wait(self, now: float) -> Order | None:
        """Wait until there is a better way, or the waiting time is over."""
        situation, waiting = self._situation, self._situation.waiting
        if waiting is FOR_SIGHT:
            if situation.is_blind(now):
                return REST
            self._machine.happens(MissionEvent.SEES_AGAIN, now, "something is seen again")
            return None
        if self._sees_end_of(waiting, now) or self._makes_way(waiting, now):
            return None
        if now < waiting.until:
            self._ask(waiting, now)
            return self._watch(waiting)
        if waiting.is_last_hope and situation.has_tried_enough(now):
            return None  # as where somebody stands at the goal
        if waiting.is_last_hope and waiting.place is not None:
            radius = self._parameters.guide.stop_before + self._memory.half_width
            self._memory.grid.take_for_walls(*waiting.place, radius)
        elif waiting.passages:
            situation.rights.waive(waiting.passages)
        elif waiting.cost < inf and situation.has_tried_enough(now):
            return None
        self._machine.happens(MissionEvent.WAITED_ENOUGH, now, f"waited long enough: {waiting.why}")
        return None

    def _sees_end_of(self, waiting: Waiting, now: float) -> bool:
        """Return whether waiting ends: there is a better way, or the obstacle is a wall."""
        situation = self._situation
        if not situation.is_time_to_look(now):
            return False
        if (found := situation.look_past(waiting, now)) is not None:
            self._machine.happens(MissionEvent.WAY_FOUND, now, f"a way of {found:.1f} m")
        elif waiting.cost < inf and not waiting.is_aside and situation.guide.goes_on(now, self._free_to_follow()):
            self._machine.happens(MissionEvent.WAY_FOUND, now, "what was in the way moves on")
        elif waiting.hopes and situation.guide.is_hopeless(now):
            self._machine.happens(MissionEvent.WAITED_ENOUGH, now, f"it is a wall: {waiting.why}")
        else:
            return False
        return True

    def _free_to_follow(self) -> float:
        """Return how much of the way has to be free to follow what moves on, m.

        Whoever was asked and gives way a little sees where the robot is going when it follows.
        """
        guide = self._parameters.guide
        return guide.stop_before + YIELDED if self._situation.way_requests.have_begun else guide.follow_from

    def _makes_way(self, waiting: Waiting, now: float) -> bool:
        """Begin to go aside, if it is time and there is room; return whether it did."""
        situation = self._situation
        courtesy = GIVE_WAY if waiting.passages else self._parameters.courtesy
        is_time = now - self._machine.since >= courtesy and situation.making_way.is_worth(now, self._memory.travelled)
        if not (is_time and situation.guide.make_way(waiting.place)):
            return False
        self._machine.happens(MissionEvent.WAY_FOUND, now, "making way for a person or an obstacle")
        situation.making_way.begin(waiting, self._memory.travelled)
        return True

    def _ask(self, waiting: Waiting, now: float) -> None:
        """Ask whoever is in the way to let the robot pass, if it is time."""
        situation = self._situation
        if waiting.hopes and not waiting.is_aside and situation.way_requests.is_due(now):
            situation.asks_for_way = True
            situation.note("info", "asks to be let pass")

    def _watch(self, waiting: Waiting) -> Order:
        """Face the place where the way is barred."""
        if waiting.place is None:
            return REST
        guide = self._situation.guide
        heading = guide.direction(waiting.place)
        return Order("turn", heading=heading) if guide.off(heading) > self._parameters.face else REST

"""One mission after the other: where to go next, when to wait, when to look for another way, and when to give up.

What is in the way and was not always there may go again: the robot waits for it a while where a detour would be long.
What was never seen free is a wall. Where no way is left but through something that may go, the robot goes up to it and
waits longer; if it does not go, it counts as a wall from then on. So each mission ends.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi
from typing import Any

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.guide import Guide, spoken
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.orders import REST, MissionNumbers, Note, Order, is_sound
from apps.indoor_navigation.algorithms.planning.progress import Progress
from apps.indoor_navigation.algorithms.planning.states import ACTIVE, TRANSITIONS, Event, State
from apps.indoor_navigation.data import DLEData, GoalPoint, ObstRead, Place
from apps.indoor_navigation.state_machine import Change, StateMachine

AT_ONCE = 8  # changes of state in one step at most
SAID = 64  # messages that wait to be fetched
ASTERN = 1.0  # rad from straight back
HELD = 0.5  # m from where it could not go back, within which it is not tried again
LOOK_WAITING = 0.5  # s between two looks whether waiting has an end


@dataclass(frozen=True, slots=True)
class Waiting:
    """What ends it: the time until, s, or a way within the budget. hoped: what must go, or None."""

    until: float
    budget: float
    hoped: Place | None = None


FOR_SIGHT = Waiting(inf, -inf)


class Navigator:
    """Is shown readings, and asked for an order at each step. All times are s of one steady clock.

    notes: what there is to tell, taken out by whoever tells it.
    """

    def __init__(self, numbers: MissionNumbers, half_width: float) -> None:
        """half_width: of the robot, m."""
        self.numbers = numbers
        self.memory = Memory(numbers.guide.memory, Outline(half_width, half_width, 2.0 * half_width))
        self.notes: deque[Note] = deque(maxlen=SAID)
        self._goal = GoalPoint("", None, None)
        self._guide = Guide(numbers.guide, self.memory, self._goal)
        self._machine: StateMachine[State, Event] = StateMachine(TRANSITIONS, State.IDLE, self._changed)
        self._progress = Progress(numbers.progress)
        self._waiting = FOR_SIGHT
        self._seen_at = self._looked_at = -inf
        self._no_way_since = inf
        self._is_there = False  # and only has to turn yet
        self._doubts = True  # that the goal is barred
        self._back_to = 0  # the breadcrumb
        self._held_at: Place | None = None  # where it could not go back
        self._handlers: dict[State, Callable[[float], Order | None]] = {
            State.REPLANNING: self._replan,
            State.WAITING: self._wait,
            State.TURNING: self._turn,
            State.GOING: self._go,
            State.PASSING: self._go,
            State.BACKING: self._back,
        }

    @property
    def state(self) -> State:
        """What it is about."""
        return self._machine.state

    @property
    def is_active(self) -> bool:
        """Whether a mission is under way."""
        return self.state in ACTIVE

    @property
    def why(self) -> str:
        """Why it is in this state."""
        return self._machine.why

    # What is heard.

    def begin(self, goal: GoalPoint, now: float) -> None:
        """Take up a mission, or cancel the present one with a goal that is no place."""
        if goal.x is None or goal.y is None:
            if self.is_active:
                self._machine.happens(Event.CALLED_OFF, now, "cancelled")
            return
        if self.is_active and self._goal.mission != goal.mission:
            self._note("warning", f"given up, because {goal.mission} replaces it")
        self._goal, self._guide = goal, Guide(self.numbers.guide, self.memory, goal)
        self._is_there, self._no_way_since, self._looked_at = False, inf, -inf
        self._doubts = True
        self._progress.begin()
        self.memory.begin_trail()
        self._machine.happens(Event.TOLD, now, "told where to go")
        if not is_sound(goal):
            told = f"x {goal.x!r}, y {goal.y!r}, heading {goal.heading!r}, tolerance {goal.tolerance!r}"
            self._give_up(now, f"{told} is no goal; give numbers, and a tolerance above 0")

    def see(self, reading: ObstRead, now: float) -> None:
        """Something was seen."""
        self._seen_at = now
        if self.memory.see(reading):
            self._progress.begin()
            if self.is_active:
                self._is_there, self._no_way_since = False, inf
                self._machine.happens(
                    Event.POSE_JUMPED, now, "the robot's pose was set anew, and all that was seen is forgotten"
                )
        self._progress.see(reading, now)

    def see_doors(self, data: DLEData) -> None:
        """Doors were seen."""
        self.memory.see_doors(data)

    # What is wanted.

    def step(self, now: float) -> Order:
        """What is to be done now."""
        for _ in range(AT_ONCE):
            if not self.is_active:
                break
            if self._is_blind(now) and self._waiting_for is not FOR_SIGHT:
                self._wait_for(now, Event.BLIND, FOR_SIGHT, "nothing is seen; see whether sonar and laser work")
            order = self._handlers[self.state](now)
            if order is not None:
                return order
        return REST

    def told(self) -> dict[str, Any]:
        """Where the mission stands, as JSON. since: s of the clock of the steps."""
        points, pose = self._guide.points if self.is_active else (), self.memory.pose
        return {
            "mission": self._goal.mission,
            "state": str(self.state),
            "why": self.why,
            "since": self._machine.since,
            "goal": self._goal.to_json(),
            "sub_target": list(points[1]) if points else None,
            "travelled": self.memory.travelled,
            "pose": list(pose) if pose is not None else None,
        }

    def picture(self) -> dict[str, Any]:
        """All that there is to draw, as JSON. route: from the robot over the sub-targets."""
        points = self._guide.points if self.is_active else ()
        return {**self.told(), **self.memory.picture(), "route": [list(point) for point in points]}

    # What is done in each state; None where another state has followed.

    def _replan(self, now: float) -> Order | None:
        if self._guide.is_too_far(now):
            self._give_up(now, f"{spoken(self._guide.goal)} is too far away to plan a way there")
        elif (found := self._look(now, inf)) is not None:
            self._machine.happens(Event.WAY_FOUND, now, f"a way of {found:.1f} m")
        elif (barred := self._guide.look_hoping(now)) is not None:
            why = f"the only way is barred near {spoken(self._guide.barred_place())}, {barred:.1f} m from here"
            self._no_way_since = inf
            self._machine.happens(Event.WAY_FOUND, now, why)
        elif now - self._no_way_since >= self.numbers.sure:
            if self._doubts and self._guide.doubt_goal(now):
                self._doubts = False  # somebody may have stood there; it is looked at once more, from nearer
            else:
                self._give_up(now, self._guide.why_no_way(now))
        else:
            self._no_way_since = min(self._no_way_since, now)
            until = self._no_way_since + self.numbers.sure
            self._wait_for(now, Event.WAY_BARRED, Waiting(until, inf), "there is no way at the moment")
        return None

    def _wait(self, now: float) -> Order | None:
        waiting = self._waiting
        if waiting is FOR_SIGHT:
            if self._is_blind(now):
                return REST
            self._machine.happens(Event.SEES_AGAIN, now, "something is seen again")
            return None
        if now >= self._looked_at + LOOK_WAITING and (found := self._look(now, waiting.budget)) is not None:
            self._machine.happens(Event.WAY_FOUND, now, f"a way of {found:.1f} m")
            return None
        if now < waiting.until:
            return REST
        if waiting.hoped is not None:
            radius = self.numbers.guide.stop_before + self.memory.half_width
            self.memory.grid.take_for_walls(*waiting.hoped, radius)
        elif waiting.budget < inf and self._has_tried_enough(now):
            return None
        self._machine.happens(Event.WAITED_ENOUGH, now, f"waited long enough: {self.why}")
        return None

    def _turn(self, now: float) -> Order | None:
        if self._comes_no_farther(now):
            return None
        is_final = self._is_there and self._goal.heading is not None
        heading = self._goal.heading if is_final and self._goal.heading is not None else self._guide.heading()
        if self._guide.off(heading) > (self.numbers.heading if is_final else self.numbers.turn_until):
            return Order("turn", heading=heading)
        if is_final:
            self._arrive(now)
        else:
            self._machine.happens(Event.HAS_TURNED, now, "the way lies ahead")
        return None

    def _go(self, now: float) -> Order | None:
        """On the way, and through a door."""
        guide = self._guide
        guide.advance()
        if self._has_arrived(now) or self._comes_no_farther(now) or self._is_barred(now):
            return None
        if self.state is not State.PASSING and now >= self._looked_at + self.numbers.look:
            self._looked_at = now
            guide.look_for_better(now)
        self._mind_door(now)
        if guide.is_off_way(self.numbers.turn_from):
            if self._has_to_back(now, "there is no room to turn to where the way leads"):
                return None
            self._machine.happens(Event.HAS_TO_TURN, now, "the way leads elsewhere")
            return None
        target = guide.target
        speed = self.numbers.door_speed if self.state is State.PASSING else self.numbers.speed
        return Order("go", target.x, target.y, guide.heading(), speed, target.is_last, guide.following)

    def _back(self, now: float) -> Order | None:
        """To where there is room, as it came."""
        crumbs, guide = self.memory.crumbs, self._guide
        if len(crumbs) - 1 <= self._back_to:
            self._machine.happens(Event.HAS_BACKED, now, "there is room to turn")
            return None
        x, y = crumbs.towards(self._back_to)
        if guide.off(guide.direction((x, y)) + pi) > ASTERN:
            self._held_at = self.memory.place
            self._machine.happens(Event.HAS_BACKED, now, "the way back does not lead straight back")
            return None
        if self._progress.is_stuck(guide.pose, now):
            self._held_at = self.memory.place
            if not self._has_tried_enough(now):
                self._machine.happens(Event.CAME_NO_FARTHER, now, "the robot cannot go back")
            return None
        return Order("back", x, y, speed=self.numbers.back_speed)

    # On the way.

    def _look(self, now: float, budget: float) -> float | None:
        self._looked_at = now
        found = self._guide.look(now, budget)
        if found is not None:
            self._no_way_since = inf
        return found

    def _has_arrived(self, now: float) -> bool:
        """At the goal, or at the end of a way that ends short of it."""
        if self._guide.is_at_goal():
            self._is_there = True
            heading = self._goal.heading
            if heading is not None and self._guide.off(heading) > self.numbers.heading:
                self._machine.happens(Event.HAS_TO_TURN, now, "there, and turning to the heading that is wanted")
            else:
                self._arrive(now)
            return True
        if self._guide.is_at_end():
            hoped = self._guide.barred_place()
            waiting = Waiting(now + self.numbers.hope, inf, hoped)
            self._wait_for(now, Event.WAY_BARRED, waiting, f"the only way is barred near {spoken(hoped)}")
            return True
        return False

    def _is_barred(self, now: float) -> bool:
        """Go round what is on the way, wait for it, or go on while it is far away."""
        barrier = self._guide.barrier(now)
        if (
            barrier is None
            or self._look(now, barrier.cost + self.numbers.detour if barrier.may_go else inf) is not None
        ):
            return False
        if not barrier.may_go:
            self._machine.happens(Event.CAME_NO_FARTHER, now, f"a wall is in the way, {barrier.ahead:.1f} m ahead")
            return True
        if barrier.ahead > 2.0 * self.numbers.guide.stop_before:
            return False
        waiting = Waiting(now + self.numbers.patience, barrier.cost + self.numbers.detour)
        self._wait_for(now, Event.WAY_BARRED, waiting, f"something is in the way, {barrier.ahead:.1f} m ahead")
        return True

    def _comes_no_farther(self, now: float) -> bool:
        if not self._progress.is_stuck(self._guide.pose, now):
            return False
        if not self._has_tried_enough(now):
            radius = self.numbers.progress.avoid
            self.memory.avoid(self._guide.ahead(radius), radius, now + self.numbers.progress.avoid_for)
            why = f"the robot comes no farther at {spoken(self.memory.place)}"
            if not self._has_to_back(now, why):
                self._machine.happens(Event.CAME_NO_FARTHER, now, why)
        return True

    def _has_to_back(self, now: float, why: str) -> bool:
        """Where it cannot turn, it goes back to where it can, if it came from there."""
        is_held = self._held_at is not None and self._guide.distance(self._held_at) < HELD
        way_back = None if is_held else self.memory.way_back(self._guide.target.place)
        if way_back is None:
            return False
        self._back_to = way_back
        self._machine.happens(Event.HAS_TO_BACK, now, why)
        return True

    def _has_tried_enough(self, now: float) -> bool:
        """It has come no farther once more."""
        tried = self._progress.strike(self.memory.travelled)
        if tried <= self.numbers.progress.strikes:
            return False
        self._give_up(now, f"the robot comes no farther at {spoken(self.memory.place)}, though {tried - 1} times tried")
        return True

    def _mind_door(self, now: float) -> None:
        door = self._guide.door()
        if door is not None and self.state is State.GOING:
            self._machine.happens(Event.DOOR_AHEAD, now, f"through door {door}")
        elif door is None and self.state is State.PASSING:
            self._machine.happens(Event.DOOR_PASSED, now, "behind the door")

    def _arrive(self, now: float) -> None:
        self.memory.end_trail()
        self._machine.happens(Event.ARRIVED, now, f"there, after {self.memory.travelled:.1f} m")

    def _give_up(self, now: float, why: str) -> None:
        self._machine.happens(Event.GIVEN_UP, now, why)

    # Waiting and telling.

    @property
    def _waiting_for(self) -> Waiting | None:
        return self._waiting if self.state is State.WAITING else None

    def _is_blind(self, now: float) -> bool:
        return now - self._seen_at > self.numbers.silence

    def _wait_for(self, now: float, event: Event, waiting: Waiting, why: str) -> None:
        self._waiting = waiting
        self._machine.happens(event, now, why)

    def _changed(self, change: Change[State, Event]) -> None:
        self._progress.go_on()
        level = {State.FAILED: "error", State.WAITING: "warning"}.get(change.after, "info")
        self._note(level, f"{change.after}: {change.why}")

    def _note(self, level: str, what: str) -> None:
        self.notes.append(Note(self._goal.mission, level, what))

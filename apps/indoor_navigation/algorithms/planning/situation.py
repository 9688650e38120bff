"""The state of a mission, shared by `Driving`, `Pausing` and `Navigator`."""

from collections import deque
from dataclasses import dataclass, field
from math import inf

from apps.indoor_navigation.algorithms.planning.guide import Guide, place_text
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.orders import MissionNote, MissionParameters
from apps.indoor_navigation.algorithms.planning.progress import Progress
from apps.indoor_navigation.algorithms.planning.right_of_way import RightOfWay
from apps.indoor_navigation.algorithms.planning.states import ACTIVE, TRANSITIONS, MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT, MakingWay, Waiting, WayRequests
from apps.indoor_navigation.data import GoalPoint, Place
from apps.indoor_navigation.state_machine import Change, StateMachine

MAX_NOTES = 64  # messages that wait to be sent
DOUBTS = 3  # times that the robot looks again before it gives up, because what bars the way may have gone
WAITING_LOOK = 0.5  # s between two searches for a way while the robot waits


@dataclass(slots=True)
class Seeking:
    """A robot that has lost its place on the map looks for it.

    since: s. why: what the localization says. places: that it drove to for that.
    """

    since: float
    why: str
    places: list[Place] = field(default_factory=list)


class Situation:
    """All times are s of one steady clock.

    told, begun: the goal as it was given, and when, s. goal: the present one in the frame of planning. seeking: None
    unless the robot is lost. rights: to passages. way_requests: to people in the way. asks_for_way: one is to be sent.
    notes: messages for people. noted: number of notes of this mission. waiting: reason and end in the state WAITING.
    barred: where the way was barred last. no_way_since: s. looked_at: s of the last search for a way. seen_at: s of the
    last reading. is_there: whether only the final turn is left. doubts: that are left.
    """

    def __init__(self, parameters: MissionParameters, memory: Memory) -> None:
        self.parameters = parameters
        self.memory = memory
        self.notes: deque[MissionNote] = deque(maxlen=MAX_NOTES)
        self.machine: StateMachine[MissionState, MissionEvent] = StateMachine(
            TRANSITIONS, MissionState.IDLE, self._changed
        )
        self.progress = Progress(parameters.progress)
        self.waiting = FOR_SIGHT
        self.seen_at = -inf
        self.seeking: Seeking | None = None
        self.rights = RightOfWay()
        self.way_requests = WayRequests(parameters.ask, parameters.asks)
        self.asks_for_way = False
        self._set_out(GoalPoint("", None, None))

    def begin(self, told: GoalPoint, goal: GoalPoint, now: float) -> None:
        """Begin a mission; goal: in the frame of planning."""
        self.seeking = None
        self._set_out(goal)
        self.told, self.begun = told, now
        self.progress.begin()
        self.rights.begin()
        self.memory.begin_trail()
        self.machine.happens(MissionEvent.TOLD, now, "told where to go")

    def set_goal(self, goal: GoalPoint) -> None:
        """Plan to another place from now on, for the same mission."""
        self.goal, self.guide = goal, Guide(self.parameters.guide, self.memory, goal)
        self.making_way.waiting = None
        self.barred: Place | None = None
        self.no_way_since, self.looked_at = inf, -inf
        self.is_there, self.doubts = False, DOUBTS
        self.progress.begin()

    def lose(self, now: float, why: str) -> None:
        """Begin to look for the place of the robot on the map."""
        self.seeking = Seeking(now, why)
        here = self.memory.place if self.memory.pose is not None else (0.0, 0.0)
        self.set_goal(GoalPoint(self.goal.mission, *here))
        self.machine.happens(MissionEvent.LOST, now, f"the robot has lost its place on the map: {why}")

    @property
    def state(self) -> MissionState:
        """The state of the mission."""
        return self.machine.state

    def is_blind(self, now: float) -> bool:
        """Return whether readings have been missing for too long."""
        return now - self.seen_at > self.parameters.silence

    def look(
        self, now: float, budget: float = inf, barred: Place | None = None, *, afresh: bool = False
    ) -> float | None:
        """Plan a way, and take it if it costs no more than the budget; return its length, m, or None."""
        self.looked_at = now
        found = self.guide.look(now, budget, barred, afresh=afresh)
        if found is not None:
            self.no_way_since = inf
        return found

    def wait_for(self, now: float, event: MissionEvent, waiting: Waiting) -> None:
        """Stop and wait."""
        self.waiting = waiting
        self.way_requests.begin(now)
        self.machine.happens(event, now, waiting.why)

    def is_time_to_look(self, now: float) -> bool:
        """Return whether to search for a way again while the robot waits."""
        return now >= self.looked_at + WAITING_LOOK

    def look_past(self, waiting: Waiting, now: float) -> float | None:
        """Plan a way that is better than waiting, and take it; return its length, m, or None."""
        if not self.rights.has(waiting.passages):
            return None
        return self.look(now, waiting.budget(now, self.parameters.detour, self.parameters.speed), waiting.place)

    def look_for_passages(self) -> None:
        """Find the passages that the robot needs now."""
        is_waiting = self.state is MissionState.WAITING
        waiting = self.making_way.waiting or (self.waiting if is_waiting else None)
        way = self.guide.points if self.state in ACTIVE and not is_waiting else ()
        self.rights.look(self.memory.place, way, waiting.passages if waiting is not None else frozenset())

    def end_making_way(self, now: float) -> None:
        """Stop making way if the way is free."""
        waiting = self.making_way.waiting
        if waiting is not None and self.is_time_to_look(now) and self.look_past(waiting, now) is not None:
            self.making_way.end(now)
            self.note("info", "nobody has to be made way for any more")

    def arrive(self, now: float) -> None:
        """End a mission that has reached its goal; a robot that is lost goes on to look for its place."""
        if self.seeking is not None:
            self.machine.happens(MissionEvent.LOST, now, f"still not found: {self.seeking.why}")
            return
        self.memory.end_trail()
        self.machine.happens(MissionEvent.ARRIVED, now, f"there, after {self.memory.travelled:.1f} m")

    def give_up(self, now: float, why: str) -> None:
        """End a mission that cannot reach its goal; a robot that is lost looks for another place."""
        if self.seeking is not None:
            self.machine.happens(MissionEvent.LOST, now, f"still not found: {self.seeking.why}")
            return
        self.machine.happens(MissionEvent.GIVEN_UP, now, why)

    def has_tried_enough(self, now: float) -> bool:
        """Count that the robot is stuck; after some times give up, and return True."""
        tried = self.progress.strike(self.memory.travelled)
        if tried <= self.parameters.progress.strikes:
            return False
        self.give_up(now, f"the robot comes no farther at {place_text(self.memory.place)} after {tried - 1} attempts")
        return True

    def note(self, level: str, what: str) -> None:
        """Add a message for people."""
        self.noted += 1
        self.notes.append(MissionNote(self.goal.mission, level, what))

    def _set_out(self, goal: GoalPoint) -> None:
        self.goal, self.guide, self.noted = goal, Guide(self.parameters.guide, self.memory, goal), 0
        self.told, self.begun = goal, -inf
        self.making_way = MakingWay(self.parameters.courtesies)
        self.barred = None
        self.no_way_since, self.looked_at = inf, -inf
        self.is_there, self.doubts = False, DOUBTS

    def _changed(self, change: Change[MissionState, MissionEvent]) -> None:
        self.progress.go_on()
        if change.after in (MissionState.WAITING, MissionState.REPLANNING):
            self.making_way.end(change.at)
        if change.after is MissionState.REPLANNING:
            self.is_there = False  # the plan of the final turn is replaced, so the turn has to begin again
        level = {MissionState.FAILED: "error", MissionState.WAITING: "warning", MissionState.LOST: "warning"}.get(
            change.after, "info"
        )
        self.note(level, f"{change.after}: {change.why}")

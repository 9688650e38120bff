"""One mission under way: what is known about how it stands, and what those share who decide what is done next."""

from collections import deque
from math import inf

from apps.indoor_navigation.algorithms.planning.guide import Guide, spoken
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.orders import MissionNote, MissionParameters
from apps.indoor_navigation.algorithms.planning.progress import Progress
from apps.indoor_navigation.algorithms.planning.states import TRANSITIONS, MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT, MakingWay, Waiting
from apps.indoor_navigation.data import GoalPoint, Place
from apps.indoor_navigation.state_machine import Change, StateMachine

SAID = 64  # messages that wait to be fetched
LOOK_WAITING = 0.5  # s between two looks whether waiting has an end


class Situation:
    """All times are s of one steady clock.

    notes: what there is to tell. noted: how many notes there were of this mission. waiting: for what, in the state that
    is called so. barred: where the way was barred last. no_way_since: s. looked_at, seen_at: when a way was looked for
    last, and when anything was seen, s. is_there: it only has to turn yet. doubts: that the goal is barred.
    """

    def __init__(self, parameters: MissionParameters, memory: Memory) -> None:
        self.parameters = parameters
        self.memory = memory
        self.notes: deque[MissionNote] = deque(maxlen=SAID)
        self.machine: StateMachine[MissionState, MissionEvent] = StateMachine(
            TRANSITIONS, MissionState.IDLE, self._changed
        )
        self.progress = Progress(parameters.progress)
        self.waiting = FOR_SIGHT
        self.seen_at = -inf
        self._set_out(GoalPoint("", None, None))

    def begin(self, goal: GoalPoint, now: float) -> None:
        """Take up a mission."""
        self._set_out(goal)
        self.progress.begin()
        self.memory.begin_trail()
        self.machine.happens(MissionEvent.TOLD, now, "told where to go")

    @property
    def state(self) -> MissionState:
        """What the robot is about."""
        return self.machine.state

    def is_blind(self, now: float) -> bool:
        """Whether nothing has been seen for too long."""
        return now - self.seen_at > self.parameters.silence

    def look(self, now: float, budget: float = inf) -> float | None:
        """Look for a way, and take it where it costs no more than the budget. Its length, m, or None."""
        self.looked_at = now
        found = self.guide.look(now, budget)
        if found is not None:
            self.no_way_since = inf
        return found

    def wait_for(self, now: float, event: MissionEvent, waiting: Waiting) -> None:
        """Stand and wait."""
        self.waiting = waiting
        self.machine.happens(event, now, waiting.why)

    def is_time_to_look(self, now: float) -> bool:
        """Whether to look once more if waiting has an end."""
        return now >= self.looked_at + LOOK_WAITING

    def look_past(self, waiting: Waiting, now: float) -> float | None:
        """Look for a way that is worth it to wait no longer, and take it. Its length, m, or None."""
        return self.look(now, waiting.budget(now, self.parameters.detour, self.parameters.speed))

    def end_making_way(self, now: float) -> None:
        """If nobody is in the way any more."""
        waiting = self.making_way.waiting
        if waiting is not None and self.is_time_to_look(now) and self.look_past(waiting, now) is not None:
            self.making_way.end(now)
            self.note("info", "nobody has to be made way for any more")

    def arrive(self, now: float) -> None:
        """The mission has ended as it should."""
        self.memory.end_trail()
        self.machine.happens(MissionEvent.ARRIVED, now, f"there, after {self.memory.travelled:.1f} m")

    def give_up(self, now: float, why: str) -> None:
        """The mission has ended otherwise."""
        self.machine.happens(MissionEvent.GIVEN_UP, now, why)

    def has_tried_enough(self, now: float) -> bool:
        """It has come no farther once more; after some times it gives up."""
        tried = self.progress.strike(self.memory.travelled)
        if tried <= self.parameters.progress.strikes:
            return False
        self.give_up(now, f"the robot comes no farther at {spoken(self.memory.place)}, though {tried - 1} times tried")
        return True

    def note(self, level: str, what: str) -> None:
        """There is something to tell."""
        self.noted += 1
        self.notes.append(MissionNote(self.goal.mission, level, what))

    def _set_out(self, goal: GoalPoint) -> None:
        self.goal, self.guide, self.noted = goal, Guide(self.parameters.guide, self.memory, goal), 0
        self.making_way = MakingWay(self.parameters.courtesies)
        self.barred: Place | None = None
        self.no_way_since, self.looked_at = inf, -inf
        self.is_there, self.doubts = False, True

    def _changed(self, change: Change[MissionState, MissionEvent]) -> None:
        self.progress.go_on()
        if change.after in (MissionState.WAITING, MissionState.REPLANNING):
            self.making_way.end(change.at)
        level = {MissionState.FAILED: "error", MissionState.WAITING: "warning"}.get(change.after, "info")
        self.note(level, f"{change.after}: {change.why}")

"""One mission after the other: where to go next, when to wait, when to look for another way, and when to give up."""

from collections import deque
from collections.abc import Callable
from math import inf
from typing import Any

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.driving import Driving
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.orders import REST, MissionNote, MissionParameters, Order
from apps.indoor_navigation.algorithms.planning.pausing import Pausing
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import ACTIVE, MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT
from apps.indoor_navigation.data import DLEData, GoalPoint, ObstRead

AT_ONCE = 8  # changes of state in one step at most


class Navigator:
    """Is shown readings, and asked for an order at each step. All times are s of one steady clock."""

    def __init__(self, parameters: MissionParameters, half_width: float) -> None:
        """half_width: of the robot, m."""
        self.parameters = parameters
        self.memory = Memory(parameters.guide.memory, Outline(half_width, half_width, 2.0 * half_width))
        self._situation = Situation(parameters, self.memory)
        driving, pausing = Driving(self._situation), Pausing(self._situation)
        self._handlers: dict[MissionState, Callable[[float], Order | None]] = {
            MissionState.REPLANNING: pausing.replan,
            MissionState.WAITING: pausing.wait,
            MissionState.TURNING: driving.turn,
            MissionState.GOING: driving.go,
            MissionState.PASSING: driving.go,
            MissionState.BACKING: driving.back,
        }

    @property
    def state(self) -> MissionState:
        """What it is about."""
        return self._situation.state

    @property
    def is_active(self) -> bool:
        """Whether a mission is under way."""
        return self.state in ACTIVE

    @property
    def why(self) -> str:
        """Why it is in this state."""
        return self._situation.machine.why

    @property
    def notes(self) -> deque[MissionNote]:
        """What there is to tell, taken out by whoever tells it."""
        return self._situation.notes

    def note(self, level: str, what: str) -> None:
        """Add a message about the present mission to the notes."""
        self._situation.note(level, what)

    # What is heard.

    def begin(self, goal: GoalPoint, now: float) -> None:
        """Take up a mission, or cancel the present one with a goal that is no place."""
        situation = self._situation
        if goal.x is None or goal.y is None:
            if self.is_active:
                situation.machine.happens(MissionEvent.CALLED_OFF, now, "cancelled")
            return
        if self.is_active and situation.goal.mission != goal.mission:
            situation.note("warning", f"given up, because {goal.mission} replaces it")
        situation.begin(goal, now)
        if not goal.is_sound:
            told = f"x {goal.x!r}, y {goal.y!r}, heading {goal.heading!r}, tolerance {goal.tolerance!r}"
            situation.give_up(now, f"{told} is no goal; give numbers, and a tolerance above 0")

    def see(self, reading: ObstRead, now: float) -> None:
        """Something was seen."""
        situation = self._situation
        situation.seen_at = now
        if self.memory.see(reading):
            situation.progress.begin()
            if self.is_active:
                situation.is_there, situation.no_way_since = False, inf
                situation.machine.happens(
                    MissionEvent.POSE_JUMPED, now, "the robot's pose was set anew, and all that was seen is forgotten"
                )
        situation.progress.see(reading, now)

    def see_doors(self, data: DLEData) -> None:
        """Doors were seen."""
        self.memory.see_doors(data)

    # What is wanted.

    def step(self, now: float) -> Order:
        """What is to be done now."""
        situation = self._situation
        for _ in range(AT_ONCE):
            if not self.is_active:
                break
            waits_for_sight = self.state is MissionState.WAITING and situation.waiting is FOR_SIGHT
            if situation.is_blind(now) and not waits_for_sight:
                situation.wait_for(now, MissionEvent.BLIND, FOR_SIGHT)
            order = self._handlers[self.state](now)
            if order is not None:
                return order
        return REST

    def told(self) -> dict[str, Any]:
        """Where the mission stands, as JSON. messages: the number of its notes. since: s of the clock of the steps."""
        situation, pose = self._situation, self.memory.pose
        points = situation.guide.points if self.is_active else ()
        return {
            "mission": situation.goal.mission,
            "state": str(self.state),
            "why": self.why,
            "messages": situation.noted,
            "since": situation.machine.since,
            "goal": situation.goal.to_json(),
            "sub_target": list(points[1]) if points else None,
            "travelled": self.memory.travelled,
            "pose": list(pose) if pose is not None else None,
        }

    def picture(self) -> dict[str, Any]:
        """All that there is to draw, as JSON. route: from the robot over the sub-targets."""
        points = self._situation.guide.points if self.is_active else ()
        return {**self.told(), **self.memory.picture(), "route": [list(point) for point in points]}

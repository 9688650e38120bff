"""Missions: what to do next from readings and doors, one mission after the other."""

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
from apps.indoor_navigation.algorithms.planning.states import ACTIVE, MOVING, MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT
from apps.indoor_navigation.data import GoalPoint, ObstRead

MAX_CHANGES = 8  # of state in one step; no sequence without an order is as long


class Navigator:
    """Takes readings, and returns an order at each step. All times are s of one steady clock."""

    def __init__(self, parameters: MissionParameters, half_width: float) -> None:
        """half_width: of the robot, m."""
        self.parameters = parameters
        self.memory = Memory(parameters.guide.memory, Outline(half_width, half_width, 2.0 * half_width))
        self._situation = Situation(parameters, self.memory)
        driving, pausing = Driving(self._situation), Pausing(self._situation)
        self._handlers: dict[MissionState, Callable[[float], Order | None]] = {
            MissionState.REPLANNING: pausing.replan,
            MissionState.WAITING: pausing.wait,
            **dict.fromkeys(MOVING, driving.follow),
        }

    @property
    def state(self) -> MissionState:
        """The state of the mission."""
        return self._situation.state

    @property
    def is_active(self) -> bool:
        """Whether a mission is active."""
        return self.state in ACTIVE

    @property
    def why(self) -> str:
        """The reason for this state in words."""
        return self._situation.machine.why

    @property
    def notes(self) -> deque[MissionNote]:
        """Messages for people; the caller removes those that it sends."""
        return self._situation.notes

    def note(self, level: str, what: str) -> None:
        """Add a message about the present mission."""
        self._situation.note(level, what)

    # Inputs.

    def begin(self, goal: GoalPoint, now: float) -> None:
        """Begin a mission, or cancel the present one if the goal has no place."""
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
            situation.give_up(now, f"{told} is not a valid goal; give finite numbers, and a tolerance above 0")

    def see(self, reading: ObstRead, now: float) -> None:
        """Take a reading of obstacles."""
        situation = self._situation
        situation.seen_at = now
        if self.memory.see(reading):
            situation.progress.begin()
            if self.is_active:
                situation.is_there, situation.no_way_since = False, inf
                situation.machine.happens(
                    MissionEvent.POSE_JUMPED, now, "the robot's pose was set anew, and all that was seen is forgotten"
                )

    # Outputs.

    def step(self, now: float) -> Order:
        """Return the order for now."""
        situation = self._situation
        for _ in range(MAX_CHANGES):
            if not self.is_active:
                break
            waits_for_sight = self.state is MissionState.WAITING and situation.waiting is FOR_SIGHT
            if situation.is_blind(now) and not waits_for_sight:
                situation.wait_for(now, MissionEvent.BLIND, FOR_SIGHT)
            order = self._handlers[self.state](now)
            if order is not None:
                return order
        return REST

    def status(self) -> dict[str, Any]:
        """Return the state of the mission as JSON. messages: number of notes. since: s of the clock of the steps."""
        situation, pose = self._situation, self.memory.pose
        target = situation.guide.sub_target if self.is_active else None
        return {
            "mission": situation.goal.mission,
            "state": str(self.state),
            "why": self.why,
            "messages": situation.noted,
            "since": situation.machine.since,
            "goal": situation.goal.to_json(),
            "sub_target": list(target) if target is not None else None,
            "travelled": self.memory.travelled,
            "pose": list(pose) if pose is not None else None,
        }

    def picture(self) -> dict[str, Any]:
        """Return the data of a picture as JSON. route: points from the robot on. ends: of the pieces."""
        guide = self._situation.guide
        points, ends = (guide.points, guide.ends) if self.is_active else ((), ())
        route = {"route": [list(point) for point in points], "ends": [list(end) for end in ends]}
        return {**self.status(), **self.memory.picture(), **route}

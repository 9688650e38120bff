"""A path planning that goes nowhere, for tests of what people see."""

from typing import Any

from apps.indoor_navigation.component import Component, Role, answers_query, is_told
from apps.indoor_navigation.components.user_interface import UserInterface
from apps.indoor_navigation.data import GoalPoint, LogMessage

PICTURE: dict[str, Any] = {
    "mission": "m1",
    "state": "going",
    "why": "a way of 3.0 m",
    "since": 2.0,
    "goal": GoalPoint("m1", 3.0, 0.5, 1.57).to_json(),
    "sub_target": [1.5, 0.2],
    "travelled": 1.0,
    "pose": [1.0, 0.0, 0.0],
    "grid": {"x": -1.0, "y": -1.0, "resolution": 0.5, "rows": 4, "columns": 10, "runs": [[2, 10], [1, 25], [0, 5]]},
    "trail": [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]],
    "doors": [
        {"x": 2.0, "y": 0.3, "width": 0.9, "normal": 0.1, "confidence": 0.9, "passed": 2, "is_believed": True},
        {"x": 2.0, "y": 0.8, "width": 0.9, "normal": 1.5, "confidence": 0.3, "passed": 0, "is_believed": False},
    ],
    "ways": [{"from": 0, "to": "place", "points": [[0.0, 0.0], [2.0, 0.3]]}],
    "route": [[1.0, 0.0], [1.5, 0.2], [2.5, 0.4], [3.0, 0.5]],
    "ends": [[1.5, 0.2], [3.0, 0.5]],
}
COMMANDS: dict[str, Any] = {
    "sources": {
        "goto": {"linear": 0.5, "angular": 0.2, "weight": 1.0, "limit": None, "is_young": True},
        "orienting": {"linear": 0.0, "angular": 0.0, "weight": 0.0, "limit": None, "is_young": True},
        "obstacle_avoiding": {"linear": 0.0, "angular": -0.5, "weight": 0.5, "limit": 0.3, "is_young": True},
        "old": {"linear": 0.1, "angular": 0.0, "weight": 0.5, "limit": None, "is_young": False},
    },
    "fused": {"linear": 0.3, "angular": 0.0, "weight": 1.0, "limit": 0.3},
}


class Planning(Component):
    """Does at once what its property `ends` says with each mission: `done`, `failed`, or nothing yet."""

    role = Role.DELIBERATIVE
    tells = (LogMessage,)

    async def setup(self) -> None:
        self.goal: GoalPoint | None = None
        self.mission_state = "idle"

    @is_told(GoalPoint)
    async def take_up(self, goal: GoalPoint) -> None:
        if goal.x is None:
            self.mission_state = "cancelled"
            return
        self.goal, self.mission_state = goal, self.properties.get("ends", "going")
        what = f"{self.mission_state}: to ({goal.x:.2f}, {goal.y or 0.0:.2f})"
        self.tell(LogMessage(self.home.wall_time(), "path_planning", goal.mission, "info", what))

    @answers_query("state")
    def tell_state(self) -> dict[str, Any]:
        if self.goal is None:
            return {"mission": "", "state": "idle", "why": "", "since": 0.0}
        return {
            **{name: PICTURE[name] for name in ("since", "sub_target", "travelled", "pose")},
            "mission": self.goal.mission,
            "state": self.mission_state,
            "messages": 1,
            "why": "as the test wants it",
            "goal": self.goal.to_json(),
        }

    @answers_query("picture")
    def draw(self) -> dict[str, Any]:
        return {**PICTURE, **self.tell_state()}


def navigation(
    robot: str, ends: str, kind: type[UserInterface] = UserInterface, planning: type[Planning] = Planning
) -> tuple[Component, Component]:
    """A face and a path planning for a robot."""
    face = kind(
        f"user_interface@{robot}",
        {
            "tells": {"GoalPoint": ["path_planning"]},
            "asks": {"state": "path_planning", "picture": "path_planning"},
            "numbers": {"look": 0.05},
        },
    )
    planner = planning(f"path_planning@{robot}", {"tells": {"LogMessage": ["user_interface"]}, "ends": ends})
    return face, planner

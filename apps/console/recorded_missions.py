"""The missions of indoor navigations in a recording: goal, way and state at any time.

While a navigation runs, its agent is asked for all that. A recording has no agents, but the messages of the components:
the goal that path planning got, the targets that it gave, what it told people, and its plans with the doors. In a
recording of an older version, which has no plans, the way ends with the piece that is driven.
"""

from array import array
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, NamedTuple

from apps.console.map_layers import doors_layout, is_number
from apps.indoor_navigation.algorithms.planning.states import MissionState

_GOAL, _TARGET = "/navigation/path_planning/send/GoalPoint", "/navigation/goto/send/WorldCoord"
_MESSAGE, _PLAN = "/navigation/user_interface/send/LogMessage", "/navigation/path_planning/push/PlannedWay"
_STATES = frozenset(map(str, MissionState))
_ENDS = (MissionState.DONE, MissionState.FAILED, MissionState.CANCELLED)
_DRIVING = ("go", "back")
_MOST = 2000  # numbers of a way
_MOST_DOORS = 500


def is_of_mission(key: str) -> bool:
    """Return whether messages on a key tell of a mission."""
    return key.endswith((_GOAL, _TARGET, _MESSAGE, _PLAN))


class _RecordedPlan(NamedTuple):
    """A plan. route: x and y of places in turn. doors: in the form of `map_layers.mission_layout`."""

    mission: str
    route: "array[float]"
    doors: list[list[float]]


class RecordedMissions:
    """The missions of all robots, in the form of `map_layers.mission_layout`; m and rad in odom.

    A goal in the frame of a map has `frame` = `map` besides.
    """

    def __init__(self) -> None:
        self._told: dict[str, tuple[list[int], list[dict[str, Any]]]] = {}  # by robot: times, ns since 1970, and states
        self._plans: dict[
            str, tuple[list[int], list[_RecordedPlan]]
        ] = {}  # likewise; they are many, so they are kept small

    def take(self, key: str, message: Any, time_ns: int) -> None:
        """Take a message, in the order of the times; what is malformed is left out."""
        if not isinstance(message, Mapping):
            return
        robot = key.partition("/")[0]
        if key.endswith(_PLAN):
            self._take_plan(robot, message, time_ns)
            return
        times, states = self._told.setdefault(robot, ([], []))
        before = states[-1] if states else _NOTHING
        if key.endswith(_GOAL):
            after = _with_goal(message)
        elif key.endswith(_TARGET):
            after = {**before, **_way_of(message)}
        else:
            after = _with_words(before, message)
        if after != before:
            times.append(time_ns)
            states.append(after)

    def at(self, time_ns: int) -> dict[str, dict[str, Any]]:
        """Return the missions at a time, ns since 1970, by robot."""
        found = {robot: (bisect_right(times, time_ns), states) for robot, (times, states) in self._told.items()}
        told = {robot: states[count - 1] for robot, (count, states) in found.items() if count}
        for robot, (times, plans) in self._plans.items():
            if count := bisect_right(times, time_ns):
                told[robot] = _with_plan(told.get(robot, _NOTHING), plans[count - 1])
        return told

    def _take_plan(self, robot: str, message: Mapping[str, Any], time_ns: int) -> None:
        times, plans = self._plans.setdefault(robot, ([], []))
        plan = _RecordedPlan(str(message.get("mission", ""))[:100], *_route_and_doors(message))
        if plans and plan.doors == plans[-1].doors:
            plan = plan._replace(doors=plans[-1].doors)  # one list for as long as they stay the same
        times.append(time_ns)
        plans.append(plan)


_NOTHING: dict[str, Any] = {
    "goal": None,
    "frame": "odom",
    "target": None,
    "route": [],
    "doors": [],
    "state": "",
    "why": "",
    "mission": "",
}


def _with_plan(told: dict[str, Any], plan: _RecordedPlan) -> dict[str, Any]:
    """Return a mission with the doors of a plan, and its whole way while that is what the robot drives."""
    is_driven = plan.mission == told["mission"] and told["goal"] is not None
    route = [list(place) for place in zip(plan.route[::2], plan.route[1::2], strict=True)]
    return {**told, "doors": plan.doors, **({"route": route} if is_driven and route else {})}


def _route_and_doors(message: Mapping[str, Any]) -> tuple["array[float]", list[list[float]]]:
    """Return what a plan draws; what is malformed is left out."""
    route, doors = message.get("route"), message.get("doors")
    numbers = route[:_MOST] if isinstance(route, list) and all(map(is_number, route[:_MOST])) else []
    drawn = doors_layout(doors[:_MOST_DOORS] if isinstance(doors, list) else ())
    return array("f", numbers[: len(numbers) // 2 * 2]), drawn


def _with_goal(message: Mapping[str, Any]) -> dict[str, Any]:
    """Return the beginning of a mission; without a goal that of one that was cancelled."""
    x, y, heading = (message.get(name) for name in ("x", "y", "heading"))
    has_place = is_number(x) and is_number(y)
    return {
        **_NOTHING,
        "goal": [x, y, heading if is_number(heading) else None] if has_place else None,
        "frame": "map" if message.get("frame") == "map" else "odom",
        "state": "told" if has_place else str(MissionState.CANCELLED),
        "mission": str(message.get("mission", ""))[:100],
    }


def _way_of(message: Mapping[str, Any]) -> dict[str, Any]:
    """Return the target and the way to it; none where the robot is to rest or turn."""
    x, y, path = message.get("x"), message.get("y"), message.get("path")
    if message.get("aim") not in _DRIVING or not (is_number(x) and is_number(y)):
        return {"target": None, "route": []}
    numbers = path[:_MOST] if isinstance(path, list) and all(map(is_number, path[:_MOST])) else []
    places = [[numbers[index], numbers[index + 1]] for index in range(0, len(numbers) - 1, 2)]
    return {"target": [x, y], "route": [*places, [x, y]]}


def _with_words(before: dict[str, Any], message: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mission after a message for people, such as `going: the way leads ahead`."""
    what, mission = str(message.get("what", "")), str(message.get("mission", ""))[:100]
    state, _, why = what.partition(": ")
    if state not in _STATES or not mission:
        return before  # it tells of something else
    is_over = state in _ENDS
    return {
        **before,
        **({"goal": None, "target": None, "route": []} if is_over else {}),
        "state": state,
        "why": why[:300],
        "mission": mission,
    }

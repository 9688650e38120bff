"""Where robots are on maps of buildings: what their agents of localization and of map building report, for the map."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from apps.console.placing import FramePlaces
from apps.console.readings import LatestReading
from apps.console.robots import RobotWatch
from bus import Bus
from bus.bus import JSON, Closeable
from geometry import Pose2D

LOCALIZATION, MAPPING = "localization", "mapping"
BUILT = "built"
"""Name of a map that is being built."""
_OLD = 3.0  # s after which a robot is not shown by what was reported


class LocatingWatch(Closeable):
    """The robots that are localized or build a map. located: what is drawn of them, by name."""

    def __init__(self, bus: Bus, robots: RobotWatch, places: FramePlaces) -> None:
        """Begin; a robot is watched from the first `look` on at which it is there."""
        self.located: dict[str, dict[str, Any]] = {}
        self._bus, self._robots, self._places = bus, robots, places
        self._readings: dict[tuple[str, str], LatestReading] = {}

    def look(self) -> None:
        """Take what has been reported since the last look."""
        now = self._robots.clock()
        found: dict[str, dict[str, Any]] = {}
        for name, robot in self._robots.robots.items():
            for agent in (LOCALIZATION, MAPPING) if robot.is_there else ():
                if (name, agent) not in self._readings:
                    key = f"{name}/agents/{agent}/results"
                    self._readings[name, agent] = LatestReading(self._bus, key, JSON, self._robots.clock)
                reading = self._readings[name, agent]
                if reading.age(now) <= _OLD and isinstance(reading.message, Mapping):
                    self._take(name, agent, reading.message, found)
        for name in self.located.keys() - found.keys():
            self._places.forget(name)
        self.located = found

    def map_name(self, robot: str) -> str:
        """Return the file of the map on which a robot is localized; empty without one."""
        return str(self.located.get(robot, {}).get("map", ""))

    def is_building(self, robot: str) -> bool:
        """Return whether a robot builds a map."""
        return self.map_name(robot) == BUILT

    def close(self) -> None:
        """Stop watching."""
        for reading in self._readings.values():
            reading.close()

    def _take(self, robot: str, agent: str, told: Mapping[str, Any], found: dict[str, dict[str, Any]]) -> None:
        pose = _pose_of(told.get("pose"))
        if agent == MAPPING:
            if told.get("building") is not True or pose is None:
                return
            state, odom, name = "building a map", _pose_of(told.get("odom")), BUILT
        else:
            state, odom, name = str(told.get("state")), _pose_of(told.get("odom_in_map")), str(told.get("map"))
            if state == "stopped":
                return
        is_believed = agent == MAPPING or state == "localized"
        self._places.locate(robot, name, odom if is_believed else None)
        frame = self._places.map_of(robot)
        deviations = _pose_of(told.get("deviations"))
        found[robot] = {
            "state": state,
            "is_believed": is_believed,
            "map": name,
            "frame": _list_of(frame),
            "pose": _list_of(frame.compose(pose)) if pose is not None else None,
            "deviations": _list_of(deviations) if deviations is not None else None,
            "reason": str(told.get("reason") or told.get("trouble") or "")[:200],
        }


def named_goals(told: Any, frame: Pose2D) -> list[dict[str, Any]]:
    """Return the goals of a map for drawing: name, kind, and pose on the console's map.

    Args:
        told: What the agent of localization answers to `goals`.
        frame: Place of the frame `map`.
    """
    goals = []
    for row in told if isinstance(told, list) else ():
        match row:
            case {"name": str(name), "kind": str(kind), "pose": list(pose)} if (place := _pose_of(pose)) is not None:
                goals.append({"name": name, "kind": kind, "pose": _list_of(frame.compose(place))})
    return goals


def _pose_of(value: Any) -> Pose2D | None:
    """Read x, y and heading, m and rad; None for anything else."""
    if not isinstance(value, list) or len(value) != 3:
        return None
    if not all(isinstance(each, int | float) and not isinstance(each, bool) and isfinite(each) for each in value):
        return None
    return Pose2D(*map(float, value))


def _list_of(pose: Pose2D) -> list[float]:
    return [round(pose.x, 3), round(pose.y, 3), round(pose.heading, 4)]

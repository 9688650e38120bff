"""The record of a drive in formation, and its summary."""

import math
from collections import deque
from dataclasses import dataclass, field

from apps.records import MOST_TOLD, DrivenWay, Spread, Thinning
from geometry import Point, Pose2D


@dataclass(slots=True)
class FormationRecord:
    """What happened, one entry for each period; of a long drive, for every second, every fourth and so on.

    leader: its name. times: s. poses: m, m, rad by robot; None where a robot had not been heard of. points: virtual
    points by follower, m; None while it had none. told: the newest sentences with their times.
    """

    leader: str
    times: list[float] = field(default_factory=list)
    poses: dict[str, list[Pose2D | None]] = field(default_factory=dict)
    points: dict[str, list[Point | None]] = field(default_factory=dict)
    told: deque[str] = field(default_factory=lambda: deque(maxlen=MOST_TOLD))
    _thinning: Thinning = field(default_factory=Thinning)
    _ways: dict[str, DrivenWay] = field(default_factory=dict)
    _errors: dict[str, Spread] = field(default_factory=dict)

    def add(self, time: float, poses: dict[str, Pose2D | None], points: dict[str, Point | None]) -> None:
        """Add an entry; each has the same robots."""
        for name, pose in poses.items():
            self._ways.setdefault(name, DrivenWay()).add(pose)
        for name, point in points.items():
            self._errors.setdefault(name, Spread()).add(_error(poses[name], point))
        if not self._thinning.keeps_next():
            return
        self.times.append(time)
        for name, pose in poses.items():
            self.poses.setdefault(name, []).append(pose)
        for name, point in points.items():
            self.points.setdefault(name, []).append(point)
        self._thinning.thin(self.times, *self.poses.values(), *self.points.values())

    def errors(self, name: str) -> list[float]:
        """Return a follower's distance from its point at each time, m; NaN where it has none."""
        return [_error(pose, point) for pose, point in zip(self.poses[name], self.points[name], strict=True)]

    def summary(self) -> list[str]:
        """Return a line for each robot: how far it drove, and how far from its point it was."""
        lines = []
        for name, way in self._ways.items():
            line = f"{name}: {way.length:.1f} m"
            error = self._errors.get(name, Spread())
            if error.count:
                line += f", on the average {100 * error.mean:.0f} cm from its point, at most {100 * error.most:.0f} cm"
            lines.append(line)
        return lines


def _error(pose: Pose2D | None, point: Point | None) -> float:
    return math.dist((pose.x, pose.y), point) if pose and point else math.nan

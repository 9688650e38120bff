"""The record of a drive in formation, and its summary."""

import math
import statistics
from dataclasses import dataclass, field
from itertools import pairwise

from geometry import Point, Pose2D


@dataclass(slots=True)
class FormationRecord:
    """What happened, one entry for each period.

    leader: its name. times: s. poses: m, m, rad by robot; None where a robot had not been heard of. points: virtual
    points by follower, m; None while it had none. told: sentences with their times.
    """

    leader: str
    times: list[float] = field(default_factory=list)
    poses: dict[str, list[Pose2D | None]] = field(default_factory=dict)
    points: dict[str, list[Point | None]] = field(default_factory=dict)
    told: list[str] = field(default_factory=list)

    def add(self, time: float, poses: dict[str, Pose2D | None], points: dict[str, Point | None]) -> None:
        """Add an entry; each has the same robots."""
        self.times.append(time)
        for name, pose in poses.items():
            self.poses.setdefault(name, []).append(pose)
        for name, point in points.items():
            self.points.setdefault(name, []).append(point)

    def errors(self, name: str) -> list[float]:
        """Return a follower's distance from its point at each time, m; NaN where it has none."""
        return [
            math.dist((pose.x, pose.y), point) if pose and point else math.nan
            for pose, point in zip(self.poses[name], self.points[name], strict=True)
        ]

    def summary(self) -> list[str]:
        """Return a line for each robot: how far it drove, and how far from its point it was."""
        lines = []
        for name, poses in self.poses.items():
            seen = [pose for pose in poses if pose]
            way = sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(seen))
            line = f"{name}: {way:.1f} m"
            if name in self.points:
                known = [error for error in self.errors(name) if not math.isnan(error)]
                if known:
                    line += f", on the average {100 * statistics.fmean(known):.0f} cm from its point"
                    line += f", at most {100 * max(known):.0f} cm"
            lines.append(line)
        return lines

"""The record of one follower's drive, and its summary."""

import math
import statistics
from dataclasses import dataclass, field
from itertools import pairwise

from geometry import Pose2D


@dataclass(slots=True)
class FollowingRecord:
    """What happened, one entry for each period.

    follower: its name. times: s. own: its pose in its frame odom, None where it was not known. leader: the estimated
    pose of the leader in the same frame, None where it was not seen. gaps: m along the curve to it; NaN likewise.
    told: sentences with their times.
    """

    follower: str
    times: list[float] = field(default_factory=list)
    own: list[Pose2D | None] = field(default_factory=list)
    leader: list[Pose2D | None] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)
    told: list[str] = field(default_factory=list)

    def add(self, time: float, own: Pose2D | None, leader: Pose2D | None, gap: float | None) -> None:
        """Add an entry."""
        self.times.append(time)
        self.own.append(own)
        self.leader.append(leader)
        self.gaps.append(math.nan if gap is None else gap)

    def summary(self) -> str:
        """Return one line: the ways of both, and the gap between them."""
        gaps = [gap for gap in self.gaps if not math.isnan(gap)]
        words = f"{self.follower}: {_length(self.own):.1f} m"
        if not gaps:
            return f"{words}, never saw a leader"
        lost = self.times[-1] * (1.0 - len(gaps) / len(self.times)) if self.times else 0.0
        return (
            f"{words} behind a leader that drove {_length(self.leader):.1f} m; gap {statistics.median(gaps):.2f} m "
            f"in the median, {min(gaps):.2f} to {max(gaps):.2f} m; without leader for {lost:.0f} s"
        )


def _length(poses: list[Pose2D | None]) -> float:
    known = [pose for pose in poses if pose is not None]
    return sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(known))

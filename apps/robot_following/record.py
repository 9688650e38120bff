"""The record of one follower's drive, and its summary."""

import math
import statistics
from collections import deque
from dataclasses import dataclass, field

from apps.records import MOST_TOLD, DrivenWay, Spread, Thinning
from geometry import Pose2D


@dataclass(slots=True)
class FollowingRecord:
    """What happened, one entry for each period; of a long drive, for every second, every fourth and so on.

    follower: its name. times: s. own: its pose in its frame odom, None where it was not known. leader: the estimated
    pose of the leader in the same frame, None where it was not seen. gaps: m along the curve to it; NaN likewise.
    told: the newest sentences with their times.
    """

    follower: str
    times: list[float] = field(default_factory=list)
    own: list[Pose2D | None] = field(default_factory=list)
    leader: list[Pose2D | None] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)
    told: deque[str] = field(default_factory=lambda: deque(maxlen=MOST_TOLD))
    _thinning: Thinning = field(default_factory=Thinning)
    _own_way: DrivenWay = field(default_factory=DrivenWay)
    _leader_way: DrivenWay = field(default_factory=DrivenWay)
    _gap: Spread = field(default_factory=Spread)
    _lasted: float = 0.0

    def add(self, time: float, own: Pose2D | None, leader: Pose2D | None, gap: float | None) -> None:
        """Add an entry."""
        known_gap = math.nan if gap is None else gap
        self._lasted = time
        self._own_way.add(own)
        self._leader_way.add(leader)
        self._gap.add(known_gap)
        if self._thinning.keeps_next():
            self.times.append(time)
            self.own.append(own)
            self.leader.append(leader)
            self.gaps.append(known_gap)
            self._thinning.thin(self.times, self.own, self.leader, self.gaps)

    def summary(self) -> str:
        """Return one line: the ways of both, and the gap between them; its median is that of the entries."""
        gap, gaps = self._gap, [each for each in self.gaps if not math.isnan(each)]
        words = f"{self.follower}: {self._own_way.length:.1f} m"
        if not gaps:
            return f"{words}, never saw a leader"
        lost = self._lasted * (1.0 - gap.count / self._thinning.count)
        return (
            f"{words} behind a leader that drove {self._leader_way.length:.1f} m; gap {statistics.median(gaps):.2f} m "
            f"in the median, {gap.least:.2f} to {gap.most:.2f} m; without leader for {lost:.0f} s"
        )

"""Range readings of the last metres, kept in the frame `odom`: what is compared with the whole map at once."""

from collections import deque
from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D, wrap_angle
from maps.localization.motion import placed
from maps.localization.settings import ReadingMemorySettings

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Keyframe:
    """Ends of ranges (m in `odom`, shape (n, 2)), and where and after how many m of travel they were measured."""

    points: Points
    pose: Pose2D
    travel: float


class ReadingMemory:
    """Ends of ranges along the last metres.

    travel: m driven since the readings began.
    """

    def __init__(self, settings: ReadingMemorySettings) -> None:
        self._settings = settings
        self._frames: deque[_Keyframe] = deque(maxlen=settings.scans)
        self._last: Pose2D | None = None
        self.travel = 0.0

    def clear(self) -> None:
        """Forget everything, as after a jump of the robot."""
        self._frames.clear()
        self._last = None
        self.travel = 0.0

    def add(self, pose: Pose2D, points: Points) -> bool:
        """Take ends of ranges (m in `base_link`, shape (n, 2)) at a pose in `odom`; returns whether it moved enough."""
        settings = self._settings
        if self._last is not None:
            self.travel += hypot(pose.x - self._last.x, pose.y - self._last.y)
        self._last = pose
        while self._frames and self.travel - self._frames[0].travel > settings.longest:
            self._frames.popleft()
        if self._frames:
            before = self._frames[-1]
            is_turned = abs(wrap_angle(pose.heading - before.pose.heading)) >= settings.keyframe_turn
            if self.travel - before.travel < settings.keyframe and not is_turned:
                return False
        self._frames.append(_Keyframe(placed(pose, _thinned(points, settings.thin)), pose, self.travel))
        return True

    def readings(self, pose: Pose2D) -> tuple[Points, Points]:
        """Ends and origins of all readings in the frame of a pose in `odom`: m, both of shape (n, 2)."""
        if not self._frames:
            return np.empty((0, 2)), np.empty((0, 2))
        points = np.concatenate([frame.points for frame in self._frames])
        origins = np.concatenate(
            [np.tile((frame.pose.x, frame.pose.y), (len(frame.points), 1)) for frame in self._frames]
        )
        back = Pose2D().relative_to(pose)
        return placed(back, points), placed(back, origins)


def _thinned(points: Points, cell: float) -> Points:
    """One of the points in each cell."""
    if not len(points):
        return points
    cells = np.floor(points / cell).astype(np.int64)
    cells -= cells.min(axis=0)
    _, first = np.unique(cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1], return_index=True)
    return points[np.sort(first)]

"""What optical flow is computed with: options, and the motion of the camera by the robot's odometry."""

from bisect import bisect
from collections import deque
from dataclasses import dataclass
from math import atan2, remainder, tau

MOST = 300
GAP = 1.0
"""Seconds between two images, from which on they are not compared."""
LONGEST = 0.3
"""Seconds after the latest heading for which its turn rate holds, and that may lie between two headings."""


@dataclass(frozen=True, slots=True)
class FlowOptions:
    """What is computed.

    method: `dense` or `sparse`. vectors: whether single vectors belong to the result. ahead: of the camera before the
    axle, m.
    """

    method: str = "dense"
    columns: int = 16
    vectors: bool = False
    ahead: float = 0.0


@dataclass(frozen=True, slots=True)
class CameraMotion:
    """What is known of the camera's motion.

    yaw: rad since the image before, None if unknown. pan, tilt: rad. speed, turn: of the base, m/s and rad/s.
    """

    yaw: float | None = None
    pan: float = 0.0
    tilt: float = 0.0
    speed: float = 0.0
    turn: float = 0.0

    def way(self, dt: float, ahead: float) -> tuple[float, float]:
        """Return by how much the base carries a camera so far ahead of the axle in dt s, forward and to the left, m."""
        return self.speed * dt, self.turn * dt * ahead

    def slip(self, ahead: float) -> float:
        """Return the direction in which the base carries such a camera, rad, left positive; 0 if it goes nowhere."""
        return atan2(self.turn * ahead, self.speed) if self.speed > 0.0 else 0.0


class HeadingHistory:
    """The latest headings, with their turn rates. Times are those of the stamps, s.

    speed, rate: the latest ones, m/s and rad/s.
    """

    def __init__(self) -> None:
        self._stamps: deque[float] = deque(maxlen=MOST)
        self._headings: deque[float] = deque(maxlen=MOST)  # rad without jumps
        self.speed = self.rate = 0.0

    def add(self, stamp: float, heading: float, rate: float, speed: float = 0.0) -> None:
        """Take a heading, rad, turn rate, rad/s, and speed, m/s; one that is not newer begins the history anew."""
        if self._stamps and stamp <= self._stamps[-1]:
            self._stamps.clear()
            self._headings.clear()
        if self._headings:
            heading = self._headings[-1] + remainder(heading - self._headings[-1], tau)
        self._stamps.append(stamp)
        self._headings.append(heading)
        self.rate, self.speed = rate, speed

    def turned(self, begin: float, end: float) -> float | None:
        """Return by how much the heading grew from one time to a later one, rad; None if it is not known."""
        before, after = self._at(begin), self._at(end)
        return None if before is None or after is None else after - before

    def _at(self, stamp: float) -> float | None:
        if not self._stamps or stamp < self._stamps[0]:
            return None
        if (ahead := stamp - self._stamps[-1]) >= 0.0:
            return self._headings[-1] + self.rate * ahead if ahead <= LONGEST else None
        after = bisect(self._stamps, stamp)
        begin, end = self._stamps[after - 1], self._stamps[after]
        if end - begin > LONGEST:
            return None
        share = (stamp - begin) / (end - begin)
        return self._headings[after - 1] * (1.0 - share) + self._headings[after] * share

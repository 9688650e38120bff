"""A cubic Bézier curve from one pose to another, and how to drive along it."""

from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import numpy as np

from geometry import Pose2D
from vision.image import Floats

_SAMPLES = 24


@dataclass(frozen=True, slots=True)
class BezierCurve:
    """A curve that begins in the direction of its first pose and ends in that of its last.

    points: the start, two control points and the end; shape (4, 2), m.
    """

    points: tuple[tuple[float, float], ...]

    @classmethod
    def between(cls, start: Pose2D, end: Pose2D, reach: float) -> "BezierCurve":
        """Return the curve between two poses.

        Args:
            start, end: Of it.
            reach: Of the control points along the headings, as a share of the distance. 1/3 gives a straight line its
                even pace; more makes it bend sooner at the ends and less in the middle.
        """
        away = reach * hypot(end.x - start.x, end.y - start.y)
        first = start.x + away * cos(start.heading), start.y + away * sin(start.heading)
        second = end.x - away * cos(end.heading), end.y - away * sin(end.heading)
        return cls(((start.x, start.y), first, second, (end.x, end.y)))

    def at(self, parameters: Floats) -> Floats:
        """Return the places at parameters from 0 to 1, shape (n, 2), m."""
        t = parameters[:, None]
        a, b, c, d = (np.array(point) for point in self.points)
        places: Floats = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
        return places

    @property
    def length(self) -> float:
        """In m."""
        return float(self._lengths()[1][-1])

    def pose_after(self, distance: float) -> Pose2D:
        """Return place and direction a distance from the start along the curve, m; beyond its end, that of the end."""
        parameters, lengths = self._lengths()
        t = float(np.interp(distance, lengths, parameters))
        x, y = self.at(np.array([t]))[0].tolist()
        a, b, c, d = (np.array(point) for point in self.points)
        dx, dy = ((1 - t) ** 2 * (b - a) + 2 * (1 - t) * t * (c - b) + t**2 * (d - c)).tolist()
        return Pose2D(x, y, atan2(dy, dx))

    def _lengths(self) -> tuple[Floats, Floats]:
        """Return parameters, and the lengths of the curve up to them."""
        parameters = np.linspace(0.0, 1.0, _SAMPLES + 1)
        steps = np.diff(self.at(parameters), axis=0)
        return parameters, np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])

"""The room before a follower: how far it may drive along a curve before it comes near an obstacle."""

from collections.abc import Sequence
from math import cos, inf, sin

import numpy as np

from apps.robot_following.curve import BezierCurve
from apps.robot_following.settings import RoomSettings
from geometry import Point, Pose2D

_ALONG = np.linspace(0.0, 1.0, 13)  # places of a curve that are compared with obstacles


class RoomAhead:
    """The obstacles before a follower at one pose, without the leader."""

    def __init__(self, settings: RoomSettings, pose: Pose2D, leader: Pose2D, obstacles: Sequence[Point]) -> None:
        """Prepare.

        Args:
            settings: Of the room.
            pose: Of the follower, in odom.
            leader: Likewise.
            obstacles: Where range sensors have an echo, in the follower's frame, m.
        """
        self._settings, self._pose = settings, pose
        places = np.asarray(obstacles, np.float64).reshape(-1, 2)
        there = leader.relative_to(pose)
        is_other = np.hypot(places[:, 0] - there.x, places[:, 1] - there.y) > settings.leader_radius
        self._obstacles = places[is_other & (places[:, 0] > 0.0)]

    def along(self, curve: BezierCurve, margin: float) -> float:
        """Return the way free along a curve in odom, m; inf if no obstacle is in its strip.

        Args:
            curve: That begins at the follower.
            margin: m that stay free beside the follower and before it.
        """
        settings = self._settings
        places = self._located(curve)
        last = places[-1] - places[-2]
        beyond = places[-1] + last * (settings.front + margin) / max(1e-6, float(np.hypot(*last)))
        places = np.vstack([places, beyond])
        reach = settings.half_width + margin
        # Few obstacles are near the curve, and a step compares them with dozens of curves.
        is_near = (self._obstacles > places.min(axis=0) - reach) & (self._obstacles < places.max(axis=0) + reach)
        near = self._obstacles[is_near.all(axis=1)]
        if not len(near):
            return inf
        steps = np.diff(places, axis=0)
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
        off = near[:, None] - places[:-1]
        part = np.clip((off * steps).sum(axis=2) / np.maximum((steps**2).sum(axis=1), 1e-12), 0.0, 1.0)
        beside = np.hypot(*np.moveaxis(off - part[:, :, None] * steps, 2, 0))
        nearest = beside.argmin(axis=1)
        rows = np.arange(len(near))
        ways = lengths[nearest] + part[rows, nearest] * np.diff(lengths)[nearest]
        barring = ways[beside[rows, nearest] < reach]
        return float(barring.min()) - settings.front - margin if len(barring) else inf

    def _located(self, curve: BezierCurve) -> np.ndarray:
        """Return places of a curve in the follower's frame, m, shape (n, 2)."""
        dx, dy = (curve.at(_ALONG) - (self._pose.x, self._pose.y)).T
        c, s = cos(self._pose.heading), sin(self._pose.heading)
        return np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)

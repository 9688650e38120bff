"""What sonar hears and the laser sees through, such as glass, and boards above the laser's plane.

A laser ray that passes shows nothing of it. It stays until a disc listens from a similar direction and no longer hears
it: from another direction a smooth surface reflects the sound elsewhere. And a disc that is nearer than the one that
heard it may have it above or below its cone; its silence counts only against what was heard once, as cross-talk is.
"""

from math import cos, tan

import numpy as np

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Bools, Floats, Place

REACH = 2.0  # m from a disc within which an echo is remembered
ECHO, MAX_ECHO = 2, 6  # evidence of an echo, from which on it counts, and the most of it; a silence takes 1
CELL = 0.05  # m; echoes of one cell are one place
SIMILAR = 0.4  # rad between two directions from which a disc hears the same surfaces
NEARER = 0.1  # m by which a disc may be nearer than the one that heard a place
NARROW_CONE = 0.26  # rad beside the axis of a disc within which it hears what is there
DEPTH = 0.15  # m before the end of a sonar ray that are free for certain
BESIDE_BODY = 0.2  # m about a body within which an echo is the body's


class EchoMemory:
    """Places in odom, with the evidence of an obstacle, and from where they were heard: direction and distance."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget all places."""
        self._x, self._y, self._evidence, self._direction, self._distance = np.empty((5, 0))

    def forget_near(self, place: Place, radius: float) -> None:
        """Forget the places within a radius, m."""
        self._keep(np.hypot(self._x - place[0], self._y - place[1]) > radius)

    @property
    def places(self) -> tuple[Floats, Floats]:
        """x and y of all obstacles, in odom."""
        are_there = self._evidence >= ECHO
        return self._x[are_there], self._y[are_there]

    def hear(self, sonar: Rays, unexplained: Rays, bodies: Bodies) -> None:
        """Take a reading.

        An echo comes from somewhere in a wide cone. Where another disc hears that a place is free, it is not there.

        Args:
            sonar: The rays of all discs.
            unexplained: Those whose ends nothing explains that the laser sees.
            bodies: What may be people, whose echoes are not remembered.
        """
        ends = _Axes.of(sonar)
        self._evidence[ends.are_silent(self._x, self._y, self._direction, self._distance, self._evidence > ECHO)] -= 1
        self._keep(self._evidence > 0.0)
        heard = _Axes.of(unexplained.where(unexplained.hits))
        x, y, direction, distance = heard.ends()
        beside = np.hypot(x[:, None] - bodies.x, y[:, None] - bodies.y) - bodies.radius
        is_new = (distance <= REACH) & (beside.min(axis=1, initial=np.inf) > BESIDE_BODY)
        is_new &= ~ends.are_silent(x, y, direction, distance, np.zeros(len(x), bool))
        for place in zip(x[is_new], y[is_new], direction[is_new], distance[is_new], strict=True):
            self._add(*place)

    def _add(self, x: float, y: float, direction: float, distance: float) -> None:
        same = np.flatnonzero((np.abs(self._x - x) < CELL / 2.0) & (np.abs(self._y - y) < CELL / 2.0))
        if len(same):
            at = same[0]
            self._evidence[at] = min(self._evidence[at] + ECHO, MAX_ECHO)
            self._direction[at], self._distance[at] = direction, distance
            return
        new = np.array([x, y, ECHO, direction, distance])
        old = (self._x, self._y, self._evidence, self._direction, self._distance)
        self._x, self._y, self._evidence, self._direction, self._distance = (
            np.append(values, value) for values, value in zip(old, new, strict=True)
        )

    def _keep(self, kept: Bools) -> None:
        old = (self._x, self._y, self._evidence, self._direction, self._distance)
        self._x, self._y, self._evidence, self._direction, self._distance = (values[kept] for values in old)


class _Axes:
    """The axes of discs: where they begin, their unit vectors and lengths, m, up to `REACH`."""

    def __init__(self, x: Floats, y: Floats, cosines: Floats, sines: Floats, lengths: Floats, hits: Bools) -> None:
        self._x, self._y, self._cosines, self._sines = x, y, cosines, sines
        self._lengths, self._hits = lengths, hits

    @classmethod
    def of(cls, rays: Rays) -> "_Axes":
        """Return the axes of rays of finite length."""
        dx, dy = rays.end_x - rays.origin_x, rays.end_y - rays.origin_y
        lengths = np.hypot(dx, dy)
        sound = np.isfinite(lengths) & (lengths > 0.0)
        dx, dy, lengths = dx[sound], dy[sound], lengths[sound]
        return cls(rays.origin_x[sound], rays.origin_y[sound], dx / lengths, dy / lengths, lengths, rays.hits[sound])

    def ends(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return x and y of the ends, the direction back to the disc, rad, and the distance from it, m."""
        x, y = self._x + self._lengths * self._cosines, self._y + self._lengths * self._sines
        return x, y, np.arctan2(-self._sines, -self._cosines), self._lengths

    def are_silent(self, x: Floats, y: Floats, heard_from: Floats, heard_at: Floats, is_sure: Bools) -> Bools:
        """Return at which places a disc hears nothing that listens from where they were heard.

        Args:
            x, y: The places in odom, m.
            heard_from: Directions to the discs that heard them, rad.
            heard_at: Distances of these discs, m.
            is_sure: Places of which the silence of a nearer disc shows nothing.
        """
        if not len(x) or not len(self._lengths):
            return np.zeros(len(x), bool)
        from_x, from_y = x - self._x[:, None], y - self._y[:, None]
        c, s = self._cosines[:, None], self._sines[:, None]
        along, across = c * from_x + s * from_y, np.abs(c * from_y - s * from_x)
        away = np.hypot(from_x, from_y)
        reach = np.minimum(self._lengths - np.where(self._hits, DEPTH, 0.0), REACH)[:, None]
        is_free = (along > 0.0) & (across <= tan(NARROW_CONE) * along) & (away < reach)
        is_free &= ~is_sure | (away > heard_at - NEARER)
        is_free &= np.cos(np.arctan2(-s, -c) - heard_from) > cos(SIMILAR)
        return np.asarray(is_free.any(axis=0))

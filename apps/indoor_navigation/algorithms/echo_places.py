"""What sonar hears and the laser sees through, such as glass, and boards above the laser's plane.

A laser ray that passes shows nothing of it. It stays until a disc listens from a similar direction and no longer hears
it: from another direction a smooth surface reflects the sound elsewhere. A disc on a column hears boards and table tops
as well, until they are below its cone: when it is nearer than before, its silence counts only against what was heard
once, as cross-talk is. Discs at different heights show nothing of what the others hear.
"""

from collections.abc import Sequence
from math import cos, sin, tan

import numpy as np

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Bools, Floats, Place

REACH, HIGH_REACH = 1.0, 2.0  # m from a disc in the hull, and on a column, within which an echo is remembered
ECHO, MAX_ECHO = 2, 6  # evidence of an echo, from which on it counts, and the most of it; a silence takes 1
CELL = 0.05  # m; echoes of one cell are one place
SIMILAR = 0.4  # rad between two directions from which a disc hears the same surfaces
SAME_HEIGHT = 0.3  # m between two discs that hear the same things
NEARER = 0.1  # m by which a disc may be nearer than the one that heard a place
NARROW_CONE = 0.26  # rad beside the axis of a disc within which it hears what is there
DEPTH = 0.15  # m before the end of a sonar ray that are free for certain
BESIDE_BODY = 0.2  # m about a body within which an echo is the body's
ARC = (-0.17, -0.085, 0.085, 0.17)  # rad beside the axis of a disc on a column, where its echo may come from
EVIDENCE = 2  # the row with the evidence, after x and y, and before direction, distance and height


class EchoPlaces:
    """Places in odom, with the evidence of an obstacle, and from where they were heard: direction, distance, height."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget all places."""
        self._all = np.empty((6, 0))

    def forget_near(self, place: Place, radius: float) -> None:
        """Forget the places within a radius, m."""
        self._all = self._all[:, np.hypot(self._all[0] - place[0], self._all[1] - place[1]) > radius]

    @property
    def places(self) -> tuple[Floats, Floats]:
        """x and y of all obstacles, in odom."""
        x, y = self._all[:2, self._all[EVIDENCE] >= ECHO]
        return x, y

    @property
    def sure_places(self) -> tuple[Floats, Floats]:
        """x and y of the obstacles that were heard more than once."""
        x, y = self._all[:2, self._all[EVIDENCE] > ECHO]
        return x, y

    def hear(self, sonar: Rays, unexplained: Rays, bodies: Bodies) -> None:
        """Take a reading.

        An echo comes from somewhere in a wide cone. Where another disc hears that a place is free, it is not there.

        Args:
            sonar: The rays of all discs.
            unexplained: Those whose ends nothing explains that the laser sees.
            bodies: What may be people, whose echoes are not remembered.
        """
        axes = _Axes.of(sonar)
        x, y, *heard = self._all[[0, 1, 3, 4, 5]]
        self._all[EVIDENCE, axes.are_silent((x, y), heard, self._all[EVIDENCE] > ECHO)] -= 1.0
        self._all = self._all[:, self._all[EVIDENCE] > 0.0]
        (x, y), heard = _Axes.of(_on_arcs(unexplained.where(unexplained.hits))).ends()
        beside = np.hypot(x[:, None] - bodies.x, y[:, None] - bodies.y) - bodies.radius
        is_new = (heard[1] <= _reach(heard[2])) & (beside.min(axis=1, initial=np.inf) > BESIDE_BODY)
        is_new &= ~axes.are_silent((x, y), heard, np.zeros(len(x), bool))
        for new in np.stack((x, y, np.full(len(x), ECHO), *heard))[:, is_new].T:
            self._add(new)

    def _add(self, new: Floats) -> None:
        same = np.flatnonzero((np.abs(self._all[:2] - new[:2, None]) < CELL / 2.0).all(axis=0))
        if len(same):
            evidence = min(self._all[EVIDENCE, same[0]] + ECHO, MAX_ECHO)
            self._all[EVIDENCE:, same[0]] = evidence, *new[EVIDENCE + 1 :]
        else:
            self._all = np.concatenate((self._all, new[:, None]), axis=1)


def _reach(heights: Floats) -> Floats:
    return np.where(heights > 0.0, HIGH_REACH, REACH)


def _on_arcs(echoes: Rays) -> Rays:
    """Add rays beside those of discs on a column: what they hear is as wide as a board, and no robot fits beside it."""
    column = echoes.where(echoes.heights > 0.0)
    x, y = column.end_x - column.origin_x, column.end_y - column.origin_y
    for angle in ARC if len(x) else ():
        end_x = column.origin_x + cos(angle) * x - sin(angle) * y
        end_y = column.origin_y + sin(angle) * x + cos(angle) * y
        beside = Rays(column.origin_x, column.origin_y, end_x, end_y, column.hits, column.heights)
        echoes = echoes.followed_by(beside)
    return echoes


class _Axes:
    """The axes of discs: where they begin, their unit vectors, lengths and heights, m."""

    def __init__(self, rays: Rays) -> None:
        dx, dy = rays.end_x - rays.origin_x, rays.end_y - rays.origin_y
        self._lengths = np.hypot(dx, dy)
        self._x, self._y, self._hits, self._heights = rays.origin_x, rays.origin_y, rays.hits, rays.heights
        self._cosines, self._sines = dx / self._lengths, dy / self._lengths

    @classmethod
    def of(cls, rays: Rays) -> "_Axes":
        """Return the axes of rays of finite length."""
        lengths = np.hypot(rays.end_x - rays.origin_x, rays.end_y - rays.origin_y)
        return cls(rays.where(np.isfinite(lengths) & (lengths > 0.0)))

    def ends(self) -> tuple[tuple[Floats, Floats], list[Floats]]:
        """Return x and y of the ends, and from where they are heard: direction, rad, distance and height, m."""
        x, y = self._x + self._lengths * self._cosines, self._y + self._lengths * self._sines
        return (x, y), [np.arctan2(-self._sines, -self._cosines), self._lengths, self._heights]

    def are_silent(self, places: tuple[Floats, Floats], heard: Sequence[Floats], is_sure: Bools) -> Bools:
        """Return at which places a disc hears nothing that listens from where they were heard.

        Args:
            places: x and y in odom, m.
            heard: From where: direction, distance and height, as `ends` has them.
            is_sure: Places of which the silence of a nearer disc on a column shows nothing.
        """
        (x, y), (direction, distance, height) = places, heard
        if not len(x) or not len(self._lengths):
            return np.zeros(len(x), bool)
        from_x, from_y = x - self._x[:, None], y - self._y[:, None]
        c, s = self._cosines[:, None], self._sines[:, None]
        along, across = c * from_x + s * from_y, np.abs(c * from_y - s * from_x)
        away = np.hypot(from_x, from_y)
        free = np.minimum(self._lengths - np.where(self._hits, DEPTH, 0.0), _reach(self._heights))[:, None]
        is_silent = (along > 0.0) & (across <= tan(NARROW_CONE) * along) & (away < free)
        is_silent &= ~(is_sure & (height > 0.0)) | (away > distance - NEARER)
        is_silent &= np.abs(self._heights[:, None] - height) < SAME_HEIGHT
        is_silent &= np.cos(np.arctan2(-s, -c) - direction) > cos(SIMILAR)
        return np.asarray(is_silent.any(axis=0))

"""What is known to stand near the robot: all that is seen now, and for a while what was seen and left the view.

A scanner looks ahead. A robot that is half through a door has the frame beside it, where nothing sees it any more, and
must not turn as if it were gone.
"""

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.legs import Legs
from apps.indoor_navigation.algorithms.outline import Truths
from apps.indoor_navigation.algorithms.rays import Rays, are_in_view, in_robot, inner, unexplained
from apps.indoor_navigation.data import Floats

NEAR = 2.5  # m from the robot; what is farther away is of no concern yet
KEPT = 60.0  # s for which something is believed to be where nobody looks
BESIDE = 1.2  # m from the robot, likewise
EDGE = 2  # rays on either side, beside which something is about to leave the view, and must be remembered
APART = 0.025  # m between places that are remembered
MOST = 300  # of them


class Surroundings:
    """Places in odom where obstacles are."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """The robot's pose was set anew, and places say nothing any more."""
        self._x = self._y = self._seen_at = np.empty(0)
        self._last = Rays.none()
        self._legs = Legs()

    def see(self, stamp: float, rays: Rays) -> None:
        """Take all that sensors see at s of any clock, and let go what they prove to be gone."""
        is_sure = self._last.hits & _is_of_eye(self._last)
        x, y = self._last.end_x[is_sure], self._last.end_y[is_sure]
        x, y = np.concatenate((self._x, x)), np.concatenate((self._y, y))
        seen_at = np.concatenate((self._seen_at, np.full(len(x) - len(self._x), stamp)))
        is_kept = np.asarray((stamp - seen_at < KEPT) & (stamp >= seen_at))
        if len(rays.end_x):
            middle = rays.origin_x.mean(), rays.origin_y.mean()
            is_kept &= np.hypot(x - middle[0], y - middle[1]) < BESIDE
            x, y, seen_at = x[is_kept], y[is_kept], seen_at[is_kept]
            is_kept = ~are_in_view(inner(rays.where(_is_of_eye(rays)), EDGE), x, y)
        chosen = _apart(x, y, np.flatnonzero(is_kept))[-MOST:]
        self._x, self._y, self._seen_at = x[chosen], y[chosen], seen_at[chosen]
        self._last = self._explained(rays)
        self._legs.see(stamp, self._last.where(_is_of_eye(self._last)))

    def _explained(self, rays: Rays) -> Rays:
        """Without the echoes of what is remembered: the frame of a door is beside a disc's axis, not on it."""
        is_of_eye = _is_of_eye(rays)
        seen = rays.where(is_of_eye)
        remembered = Rays(self._x, self._y, self._x, self._y, np.ones(len(self._x), bool))
        echoes = rays.where(~is_of_eye & rays.hits)
        return seen.followed_by(unexplained(echoes, seen.followed_by(remembered)))

    def places(self, pose: tuple[float, float, float]) -> tuple[Floats, Floats]:
        """x and y in the frame of a robot that is at a pose in odom, no farther than `NEAR`."""
        hits = self._last.hits
        body_x, body_y = self._legs.bodies()
        x = np.concatenate((self._last.end_x[hits], self._x, body_x))
        y = np.concatenate((self._last.end_y[hits], self._y, body_y))
        x, y = in_robot(pose, x, y)
        is_near = x * x + y * y < NEAR * NEAR
        return x[is_near], y[is_near]


def _apart(x: Floats, y: Floats, numbers: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of some places those that say something new, the last of each few centimetres, in their order.

    A robot that stands sees the same places leave its view again and again; they must not push out the others.
    """
    cells = np.round(x[numbers[::-1]] / APART) + 1j * np.round(y[numbers[::-1]] / APART)
    last = np.unique(cells, return_index=True)[1]
    return np.sort(numbers[::-1][last])


def _is_of_eye(rays: Rays) -> Truths:
    """Which are the scanner's. A disc's echo comes from somewhere in its cone; it has no shape, nor a sure place."""
    if not len(rays.end_x):
        return rays.hits
    are = np.asarray((rays.origin_x == rays.origin_x[0]) & (rays.origin_y == rays.origin_y[0]))
    return are if are.sum() > 1 else np.zeros_like(are)

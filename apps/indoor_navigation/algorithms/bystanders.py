"""Whoever walked and stands now: there is more of a person than the legs that the laser sees, even beside a wall."""

import numpy as np

from apps.indoor_navigation.algorithms.legs import bodies
from apps.indoor_navigation.algorithms.rays import Rays, nearest
from apps.indoor_navigation.data import Floats

KEPT = 30.0  # s for which somebody is believed to stand where they were seen to move last
STILL_THERE = 0.15  # m from where something moved to what is seen now; nobody walks so near to a wall
APART = 0.1  # m between places that are remembered


class MovedPlaces:
    """Places in odom where something moved last."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """The robot's pose was set anew, and places say nothing any more."""
        self._x = self._y = self._at = np.empty(0)

    def see(self, stamp: float, x: Floats, y: Floats) -> None:
        """Something has moved to here, at s of any clock; or nothing has."""
        stays = (stamp - self._at < KEPT) & (self._at <= stamp) & (nearest(self._x, self._y, x, y) >= APART)
        self._x, self._y = np.concatenate((self._x[stays], x)), np.concatenate((self._y[stays], y))
        self._at = np.concatenate((self._at[stays], np.full(len(x), stamp)))

    def about(self, stamp: float, rays: Rays) -> tuple[Floats, Floats]:
        """x and y in odom of each who is still there, and of places about them, where the rest of a person would be."""
        hits_x, hits_y = rays.end_x[rays.hits], rays.end_y[rays.hits]
        is_there = (stamp - self._at < KEPT) & (nearest(self._x, self._y, hits_x, hits_y) < STILL_THERE)
        x, y = self._x[is_there], self._y[is_there]
        about_x, about_y = bodies(x, y)
        return np.concatenate((x, about_x)), np.concatenate((y, about_y))

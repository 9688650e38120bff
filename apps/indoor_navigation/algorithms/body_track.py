"""One object that may be a leg, or has moved: the log-odds of a person, and where the body is."""

from dataclasses import dataclass, field
from math import hypot, log

import numpy as np

from apps.indoor_navigation.algorithms.scan_view import ScanView
from apps.indoor_navigation.data import Bools, Floats, Place

BODY_RADIUS = 0.35  # m about the middle of a person, with arms
MAX_SPREAD = 0.1  # m that the radius grows where the place of the second leg is uncertain

# Log-odds, natural logarithms.
SLENDER, MOTION_ONLY = 3.0, 0.0  # before anything else is known
MOVED_TIME = 30.0  # s in which the evidence of a motion fades, and likewise for what has moved
UNCONFIRMED_TIME = 10.0  # s for which something in view that does not look like a leg is still taken for one
MOTION, MAX_MOTION = 1.5, 4.0  # for each scan with a motion; most of all
THIN, LEG = 0.06, 0.09  # m; a table's leg is no wider, a person's no thinner
WIDEST_LEG, POST = 0.18, 0.24  # m; a person's leg is no wider, and two with nothing between them seldom narrower
WIDTH_ERROR = 0.01  # m, beside half a beam
TOO_THIN = -0.9  # of a width, after one clear view of it
MAX_WIDTH_STEP, MIN_WIDTH, MAX_WIDTH = 1.0, -5.0, 0.5
SURFACE, MIN_SURFACE = 1.5, -6.0  # for each view as a part of a surface; least of all
SURFACE_RANGE = 0.12  # m between an object and the surface that it is a part of
SECOND_LEG, NO_LEG = 30.0, 0.01  # likelihood of a slender object at a place, and of a free place; of a hidden one: 1
VIEW_STEP, VIEW_TIME = 0.05, 1.0  # m of motion of the scanner, or s, from one view that counts to the next

MAX_STEP = 0.1  # m from where the evidence of the second leg was collected

# Places of the second leg, relative to the first.
_ANGLES, _STRIDES = np.meshgrid(np.linspace(-np.pi, np.pi, 16, endpoint=False), [0.16, 0.24, 0.32, 0.4])
STRIDES_X, STRIDES_Y = (_STRIDES * np.cos(_ANGLES)).ravel(), (_STRIDES * np.sin(_ANGLES)).ravel()


@dataclass(slots=True)
class BodyTrack:
    """An object that is followed, in odom.

    seen_at: s of the last scan that shows something there. slender_at: s of the last one in which it is slender.
    is_whole: whether it was seen alone, not only half behind another object. anchor: where the evidence of the second
    leg was collected. is_free: places of the second leg where it is not. second: likelihoods of these places, and
    log_second of them all. seen_width: the last width and its error, m, until it counts. width, surface, motion:
    log-odds; that of a motion at `moved_at`. view: x, y of the scanner and s at the last view that counted.
    """

    x: float
    y: float
    seen_at: float
    slender_at: float
    is_slender: bool
    anchor: Place
    is_whole: bool = False
    is_free: Bools = field(default_factory=lambda: np.zeros(len(STRIDES_X), bool))
    second: Floats = field(default_factory=lambda: np.ones(len(STRIDES_X)))
    log_second: float = 0.0
    sightings: int = 1
    seen_width: tuple[float, float] | None = None
    width: float = 0.0
    surface: float = 0.0
    motion: float = 0.0
    moved_at: float = -np.inf
    view: tuple[float, float, float] = (np.inf, np.inf, -np.inf)

    def put(self, x: float, y: float, stamp: float) -> None:
        """Update the place; a step voids what was known of the second leg."""
        self.x, self.y, self.seen_at = x, y, stamp
        if hypot(x - self.anchor[0], y - self.anchor[1]) > MAX_STEP:
            self.void()

    def void(self) -> None:
        """Forget where the second leg is not."""
        self.anchor = self.x, self.y
        self.is_free[:], self.second[:], self.log_second = False, 1.0, 0.0

    def move(self, stamp: float) -> None:
        """Add the evidence of a motion."""
        self.motion = min(MAX_MOTION, self.moved(stamp) + MOTION)
        self.moved_at = stamp
        self.void()

    def moved(self, stamp: float) -> float:
        """Return the log-odds of the motions at s."""
        return self.motion * max(0.0, 1.0 - (stamp - self.moved_at) / MOVED_TIME)

    def log_odds(self, stamp: float) -> float:
        """Return the log-odds of a person at s."""
        moved = self.moved(stamp)
        if not self.is_slender:
            return MOTION_ONLY + moved + self.surface
        return SLENDER + moved + self.surface + self.width + self.log_second

    def is_new_view(self, view: ScanView, stamp: float) -> bool:
        """Return whether a view adds evidence; the next one must be from another place, or some time later."""
        is_new = hypot(view.x - self.view[0], view.y - self.view[1]) > VIEW_STEP or stamp - self.view[2] >= VIEW_TIME
        if is_new:
            self.view = view.x, view.y, stamp
        return is_new

    def _take_width(self, width: float, error: float) -> None:
        """Add the evidence of a width, m."""
        thicker, thinner = max(0.0, width - THIN) / error, max(0.0, LEG - width) / error
        wider, slimmer = max(0.0, width - WIDEST_LEG) / error, max(0.0, POST - width) / error
        step = min(thicker * thicker - thinner * thinner, slimmer * slimmer - wider * wider) / 2.0
        step = max(-MAX_WIDTH_STEP, min(MAX_WIDTH_STEP, step))
        self.width = max(MIN_WIDTH, min(MAX_WIDTH, self.width + step))

    def take_view(self, *, is_part: bool) -> None:
        """Add the evidence of a view: the width, and whether the object is a part of an extended surface."""
        if self.seen_width is not None:
            self._take_width(*self.seen_width)
            self.seen_width = None
        self.surface = max(MIN_SURFACE, self.surface - SURFACE) if is_part else min(0.0, self.surface + SURFACE / 3.0)

    def take_second(self, free: Bools, is_leg: Bools) -> None:
        """Add the evidence of the second leg.

        Args:
            free: Places of the second leg where it is not.
            is_leg: Places where there is something slender.
        """
        self.is_free = (self.is_free | free) & ~is_leg
        self.second = np.where(is_leg, SECOND_LEG, np.where(self.is_free, NO_LEG, 1.0))
        self.log_second = log(float(self.second.sum()) / len(self.second))

    def lasts(self, stamp: float) -> bool:
        """Return whether something that does not look like a leg any more may still be one, or is known not to be."""
        moved = self.moved(stamp) > 0.0
        since = stamp - max(self.slender_at, self.moved_at)
        return since < (MOVED_TIME if moved else UNCONFIRMED_TIME) or self.log_odds(stamp) <= 0.0

    def disc(self) -> tuple[float, float, float]:
        """Return the disc of a person of whom one leg is seen: x, y and radius, m.

        The middle of the person is halfway to the second leg, which is at one of the places where it may be.
        """
        if not self.is_slender:
            return self.x, self.y, BODY_RADIUS
        weights = self.second / self.second.sum()
        x, y = float(weights @ STRIDES_X) / 2.0, float(weights @ STRIDES_Y) / 2.0
        spread = float(np.sqrt(weights @ ((STRIDES_X / 2.0 - x) ** 2 + (STRIDES_Y / 2.0 - y) ** 2)))
        return self.x + x, self.y + y, BODY_RADIUS + min(spread, MAX_SPREAD)

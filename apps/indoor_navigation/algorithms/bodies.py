"""People as bodies: what may be a leg, or has moved, is a disc until it is seen to be something else.

The laser sees legs; the body above them reaches farther. Each slender object is followed, with the log-odds of its
being the leg of a person. They begin high, and each view from another place adds what it shows:

- its width: legs of tables and chairs are thinner than legs in trousers;
- the second leg, which is within a stride: places where the laser sees through, or sees a wall, are not it. From one
  place the second leg may be hidden behind the first one; from two places it is not;
- whether it is a part of an extended surface, as a door jamb is;
- motion, which is people's.

Obstacle detecting publishes the discs, so goto, avoiding and path planning use the same ones.
"""

from dataclasses import dataclass, field
from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.legs import MAX_STRIDE, Slender, slender
from apps.indoor_navigation.algorithms.rays import nearest
from apps.indoor_navigation.algorithms.scan_view import ScanView
from apps.indoor_navigation.data import Bools, Floats, LaserRead, Place

BODY_RADIUS = 0.35  # m about the middle of a person, with arms
MAX_SPREAD = 0.1  # m that the radius grows where the place of the second leg is uncertain
OUTLINE_ANGLES = np.linspace(-np.pi, np.pi, 12, endpoint=False)  # rad; points of the outline of a body

# Following.
SAME = 0.15  # m between a slender object and its place in the scan before
MAX_SHIFT = 0.2  # m between a body and a hit that shows that it is still there
SAME_MOTION = 0.25  # m between a leg and a place that moved; the other leg may be what moved
MAX_STEP = 0.1  # m from where the evidence of the second leg was collected
CLUSTER_GAP = 0.3  # m between two places that moved and belong to one person
MIN_CLUSTER = 2  # places that moved; one beam may be an error
DEPTH_ERROR = 0.1  # m beyond a place that a beam must reach to have passed it
UNCONFIRMED_TIME = 10.0  # s for which something in view that does not look like a leg is still taken for one
MOVED_TIME = 30.0  # s in which the evidence of a motion fades, and likewise for what has moved
HIDDEN_TIME, HIDDEN_RANGE = 4.0, 1.2  # s and m from the scanner within which a body out of view is published
MEMORY_TIME = 60.0  # s for which it is remembered what an object out of view is
MAX_TRACKS = 48
EDGE = 0.09  # rad at either end of the scan, where a place does not count as in view
MIN_SIGHTINGS = 2  # scans that show an object; one may be an error at an edge

# Log-odds, natural logarithms.
SLENDER, MOTION_ONLY = 3.0, 0.0  # before anything else is known
MOTION, MAX_MOTION = 1.5, 4.0  # for each scan with a motion; most of all
THIN, LEG = 0.06, 0.09  # m; a table's leg is no wider, a person's no thinner
WIDTH_ERROR = 0.01  # m, beside half a beam
TOO_THIN = -0.9  # of a width, after one clear view of it
MAX_WIDTH_STEP, MIN_WIDTH, MAX_WIDTH = 1.0, -5.0, 0.5
SURFACE, MIN_SURFACE = 1.5, -6.0  # for each view as a part of a surface; least of all
SURFACE_RANGE = 0.12  # m between an object and the surface that it is a part of
SECOND_LEG, NO_LEG = 30.0, 0.01  # likelihood of a slender object at a place, and of a free place; of a hidden one: 1
BESIDE = 0.12  # m between a place of the second leg and the object that is seen there
VIEW_STEP, VIEW_TIME = 0.05, 1.0  # m of motion of the scanner, or s, from one view that counts to the next

# Places of the second leg, relative to the first.
_ANGLES, _STRIDES = np.meshgrid(np.linspace(-np.pi, np.pi, 16, endpoint=False), [0.16, 0.24, 0.32, 0.4])
STRIDES_X, STRIDES_Y = (_STRIDES * np.cos(_ANGLES)).ravel(), (_STRIDES * np.sin(_ANGLES)).ravel()


@dataclass(frozen=True, slots=True)
class Bodies:
    """Discs that may be people, in odom, m. have_moved: which of them moved lately."""

    x: Floats
    y: Floats
    radius: Floats
    have_moved: Bools

    @classmethod
    def none(cls) -> "Bodies":
        """Return no bodies."""
        nothing = np.empty(0)
        return cls(nothing, nothing, nothing, np.empty(0, bool))

    def outlines(self) -> tuple[Floats, Floats]:
        """Return x and y in odom of points on the outlines."""
        x = self.x[:, None] + self.radius[:, None] * np.cos(OUTLINE_ANGLES)
        y = self.y[:, None] + self.radius[:, None] * np.sin(OUTLINE_ANGLES)
        return x.ravel(), y.ravel()


@dataclass(slots=True)
class _Track:
    """An object that is followed, in odom.

    seen_at: s of the last scan that shows something there. slender_at: s of the last one in which it is slender.
    is_whole: whether it was seen alone, not only half behind another object. anchor: where the evidence of the second
    leg was collected. is_free: places of the second leg where it is not. second: likelihoods of these places. width,
    surface, motion: log-odds; that of a motion at `moved_at`. view: x, y of the scanner and s at the last view that
    counted.
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
    sightings: int = 1
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
        self.is_free[:] = False

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
        return SLENDER + moved + self.surface + self.width + float(np.log(self.second.mean()))

    def is_new_view(self, view: ScanView, stamp: float) -> bool:
        """Return whether a view adds evidence; the next one must be from another place, or some time later."""
        is_new = hypot(view.x - self.view[0], view.y - self.view[1]) > VIEW_STEP or stamp - self.view[2] >= VIEW_TIME
        if is_new:
            self.view = view.x, view.y, stamp
        return is_new

    def take_width(self, width: float, error: float) -> None:
        """Add the evidence of a width, m."""
        thicker, thinner = max(0.0, width - THIN) / error, max(0.0, LEG - width) / error
        step = (thicker * thicker - thinner * thinner) / 2.0
        step = max(-MAX_WIDTH_STEP, min(MAX_WIDTH_STEP, step))
        self.width = max(MIN_WIDTH, min(MAX_WIDTH, self.width + step))

    def take_surface(self, is_part: bool) -> None:
        """Add the evidence of an extended surface at the object."""
        self.surface = max(MIN_SURFACE, self.surface - SURFACE) if is_part else min(0.0, self.surface + SURFACE / 3.0)


class BodyTracker:
    """Follows what may be people through the scans of one scanner. bodies: after the last scan."""

    def __init__(self) -> None:
        self._tracks: list[_Track] = []
        self.bodies = Bodies.none()

    def see(self, scan: LaserRead, moved: tuple[Floats, Floats]) -> None:
        """Take a scan, and the places in odom that moved in it."""
        if not len(scan.ranges):
            return
        view = ScanView(scan)
        stamp = scan.stamp
        self._tracks = [track for track in self._tracks if 0.0 <= stamp - track.seen_at < MEMORY_TIME]
        self._follow(view, slender(view), stamp)
        self._move(*moved, stamp)
        self._drop_gone(view, stamp)
        del self._tracks[: len(self._tracks) - MAX_TRACKS]
        self._look_for_second_legs(view, stamp)
        self.bodies = self._published(view, stamp)

    def _follow(self, view: ScanView, seen: Slender, stamp: float) -> None:
        """Match slender objects with those of the scan before."""
        taken: set[int] = set()
        extended = view.extended
        apart = nearest(seen.x, seen.y, view.end_x[extended], view.end_y[extended])
        for x, y, width, is_whole, to_surface in zip(
            seen.x.tolist(), seen.y.tolist(), seen.width.tolist(), seen.is_whole.tolist(), apart.tolist(), strict=True
        ):
            near = [
                (hypot(x - track.x, y - track.y), number)
                for number, track in enumerate(self._tracks)
                if number not in taken
            ]
            distance, number = min(near, default=(np.inf, -1))
            if distance < SAME:
                track = self._tracks[number]
                track.put(x, y, stamp)
                track.sightings += 1
            else:
                number = len(self._tracks)
                track = _Track(x, y, stamp, stamp, True, (x, y))
                self._tracks.append(track)
            taken.add(number)
            track.is_slender, track.slender_at = True, stamp
            track.is_whole |= is_whole
            if track.is_new_view(view, stamp):
                error = WIDTH_ERROR + view.step * hypot(x - view.x, y - view.y) / 2.0
                if is_whole:
                    track.take_width(width, error)
                track.take_surface(to_surface < SURFACE_RANGE)

    def _move(self, x: Floats, y: Floats, stamp: float) -> None:
        """Add the evidence of motions; what moved and is not slender is followed as well."""
        if not len(x):
            return
        for track in self._tracks:
            if _least(track, x, y) < SAME_MOTION:
                track.move(stamp)
        breaks = np.flatnonzero(np.hypot(np.diff(x), np.diff(y)) > CLUSTER_GAP) + 1
        for each_x, each_y in zip(np.split(x, breaks), np.split(y, breaks), strict=True):
            middle_x, middle_y = float(each_x.mean()), float(each_y.mean())
            is_known = any(_least(track, each_x, each_y) < SAME_MOTION for track in self._tracks)
            if len(each_x) >= MIN_CLUSTER and not is_known:
                track = _Track(middle_x, middle_y, stamp, stamp, False, (middle_x, middle_y), sightings=MIN_SIGHTINGS)
                track.move(stamp)
                self._tracks.append(track)

    def _drop_gone(self, view: ScanView, stamp: float) -> None:
        """Remove what is not seen any more where it was, and collect what is seen at the others."""
        if not self._tracks:
            return
        x, y = self._places()
        depth, beams, is_towards = view.look(x, y, EDGE)
        is_in_view = is_towards & (view.depths[beams] > depth - DEPTH_ERROR)
        is_there = nearest(x, y, view.end_x[view.hits], view.end_y[view.hits]) < MAX_SHIFT
        extended = view.extended
        is_part = nearest(x, y, view.end_x[extended], view.end_y[extended]) < SURFACE_RANGE
        kept: list[_Track] = []
        for track, in_view, there, part in zip(self._tracks, is_in_view, is_there, is_part, strict=True):
            if in_view and there and track.slender_at < stamp:
                track.seen_at = stamp
                if track.is_new_view(view, stamp):
                    track.take_surface(bool(part))
            # A new object at the same place replaces an older one.
            is_doubled = track.slender_at < stamp and any(
                hypot(track.x - other.x, track.y - other.y) < MAX_STEP for other in kept
            )
            since = stamp - max(track.slender_at, track.moved_at)
            lasts = since < (MOVED_TIME if track.moved(stamp) > 0.0 else UNCONFIRMED_TIME)
            if not is_doubled and (not in_view or (there and (lasts or track.log_odds(stamp) <= 0.0))):
                kept.append(track)
        self._tracks = kept

    def _look_for_second_legs(self, view: ScanView, stamp: float) -> None:
        """Update where the second leg of each object in view may be."""
        seen = [track for track in self._tracks if track.is_slender and track.seen_at == stamp]
        if not seen:
            return
        x, y = np.array([track.x for track in seen]), np.array([track.y for track in seen])
        places_x, places_y = x[:, None] + STRIDES_X, y[:, None] + STRIDES_Y
        depth, beams, is_towards = view.look(places_x, places_y)
        ranges = view.depths[beams]
        is_surface = view.extended[beams] & (np.abs(ranges - depth) <= DEPTH_ERROR)
        is_free = is_towards & ((ranges > depth + DEPTH_ERROR) | is_surface)
        apart = np.hypot(places_x[:, :, None] - x, places_y[:, :, None] - y)
        own = np.arange(len(seen))
        apart[own, :, own] = np.inf
        # What is too thin for a leg is not the second leg of another one either.
        apart[:, :, [track.width < TOO_THIN for track in seen]] = np.inf
        is_leg = (apart < BESIDE).any(axis=2)
        for track, free, leg in zip(seen, is_free, is_leg, strict=True):
            track.is_free = (track.is_free | free) & ~leg
            track.second = np.where(leg, SECOND_LEG, np.where(track.is_free, NO_LEG, 1.0))

    def _published(self, view: ScanView, stamp: float) -> Bodies:
        """Return the discs of what may be people: one for two legs, and one for each other leg."""
        likely = [track for track in self._tracks if self._is_believed(track, view, stamp)]
        alone = [track for track in likely if track.is_whole or not track.is_slender]
        # What is half behind something else is a leg only if that is one.
        believed = [track for track in likely if any(_apart(track, other) < MAX_STRIDE for other in alone)]
        discs = []
        while believed:
            track = believed.pop()
            has_moved = track.moved(stamp) > 0.0
            other = min(believed, key=lambda each: _apart(track, each), default=None)
            if other is not None and _apart(track, other) < MAX_STRIDE:
                believed.remove(other)
                has_moved |= other.moved(stamp) > 0.0
                discs.append(((track.x + other.x) / 2.0, (track.y + other.y) / 2.0, BODY_RADIUS, has_moved))
            else:
                discs.append((*_about(track), has_moved))
        if not discs:
            return Bodies.none()
        x, y, radius, moved = zip(*discs, strict=True)
        return Bodies(np.array(x), np.array(y), np.array(radius), np.array(moved, bool))

    def _is_believed(self, track: _Track, view: ScanView, stamp: float) -> bool:
        if track.sightings < MIN_SIGHTINGS or track.log_odds(stamp) <= 0.0:
            return False
        is_beside = hypot(track.x - view.x, track.y - view.y) < HIDDEN_RANGE
        return track.seen_at == stamp or (is_beside and stamp - track.seen_at < HIDDEN_TIME)

    def _places(self) -> tuple[Floats, Floats]:
        return np.array([track.x for track in self._tracks]), np.array([track.y for track in self._tracks])


def _apart(one: _Track, other: _Track) -> float:
    return hypot(one.x - other.x, one.y - other.y)


def _least(track: _Track, x: Floats, y: Floats) -> float:
    return float(np.hypot(x - track.x, y - track.y).min())


def _about(track: _Track) -> tuple[float, float, float]:
    """Return the disc of a person of whom one leg is seen: x, y and radius.

    The middle of the person is halfway to the second leg, which is at one of the places where it may be.
    """
    if not track.is_slender:
        return track.x, track.y, BODY_RADIUS
    weights = track.second / track.second.sum()
    x, y = float(weights @ STRIDES_X) / 2.0, float(weights @ STRIDES_Y) / 2.0
    spread = float(np.sqrt(weights @ ((STRIDES_X / 2.0 - x) ** 2 + (STRIDES_Y / 2.0 - y) ** 2)))
    return track.x + x, track.y + y, BODY_RADIUS + min(spread, MAX_SPREAD)

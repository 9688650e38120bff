"""People as bodies: what may be a leg, or has moved, is a disc until it is seen to be something else.

The laser sees legs; the body above them reaches farther. Each slender object is followed, with the log-odds of its
being the leg of a person. They begin high, and each view from another place adds what it shows:

- its width: legs of tables and chairs are thinner than legs in trousers;
- the second leg, which is within a stride: places where the laser sees through, or sees a wall, are not it. From one
  place the second leg may be hidden behind the first one; from two places it is not;
- whether it is a part of an extended surface, as a door jamb is, or of a wall that was seen before;
- motion, which is people's.

Obstacle detecting publishes the discs, so goto, avoiding and path planning use the same ones.
"""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.body_track import (
    BODY_RADIUS,
    MAX_STEP,
    STRIDES_X,
    STRIDES_Y,
    SURFACE_RANGE,
    TOO_THIN,
    WIDTH_ERROR,
    BodyTrack,
)
from apps.indoor_navigation.algorithms.legs import MAX_STRIDE, Slender, slender
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.algorithms.scan_view import EXTENDED, ScanView
from apps.indoor_navigation.algorithms.segments import SurfacesSeen
from apps.indoor_navigation.data import Bools, Floats, LaserRead, Pose

LEG_RADIUS = 0.1  # m; the least disc, of what the laser has seen
OUTLINE_ANGLES = np.linspace(-np.pi, np.pi, 12, endpoint=False)  # rad; points of the outline of a body

# Following.
SAME = 0.15  # m between a slender object and its place in the scan before
MAX_SHIFT = 0.2  # m between a body and a hit that shows that it is still there
SAME_MOTION = 0.25  # m between a leg and a place that moved; the other leg may be what moved
CLUSTER_GAP = 0.3  # m between two places that moved and belong to one person
MIN_CLUSTER = 2  # places that moved; one beam may be an error
BESIDE = 0.12  # m between a place of the second leg and the object that is seen there
DEPTH_ERROR = 0.1  # m beyond a place that a beam must reach to have passed it
CERTAIN = -4.0  # log-odds below which an object is not looked at any more, unless it moves
HIDDEN_TIME, HIDDEN_RANGE = 4.0, 1.2  # s and m from the scanner within which a body out of view is published
MEMORY_TIME = 60.0  # s for which it is remembered what an object out of view is
MAX_TRACKS = 48
EDGE = 0.09  # rad at either end of the scan, where a place does not count as in view
MIN_SIGHTINGS = 2  # scans that show an object; one may be an error at an edge


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

    def beside(self, outline: Outline, pose: Pose) -> "Bodies":
        """Return smaller discs where they reach into the outline of a robot at a pose in odom, which nobody does.

        The jamb of a door in which the robot stands may look like a leg, and its disc would hold the robot there.
        """
        room = np.maximum(outline.distance(*in_robot(pose, self.x, self.y)), LEG_RADIUS)
        return replace(self, radius=np.minimum(self.radius, room))

    def outlines(self) -> tuple[Floats, Floats]:
        """Return x and y in odom of points on the outlines."""
        x = self.x[:, None] + self.radius[:, None] * np.cos(OUTLINE_ANGLES)
        y = self.y[:, None] + self.radius[:, None] * np.sin(OUTLINE_ANGLES)
        return x.ravel(), y.ravel()


class BodyTracker:
    """Follows what may be people through the scans of one scanner. bodies: after the last scan."""

    def __init__(self) -> None:
        self._tracks: list[BodyTrack] = []
        self._surfaces = SurfacesSeen(EXTENDED)
        self.bodies = Bodies.none()

    def see(self, scan: LaserRead, moved: tuple[Floats, Floats]) -> None:
        """Take a scan, and the places in odom that moved in it."""
        if not len(scan.ranges):
            return
        view = ScanView(scan)
        stamp = scan.stamp
        self._surfaces.see(scan)
        self._tracks = [track for track in self._tracks if 0.0 <= stamp - track.seen_at < MEMORY_TIME]
        self._follow(view, slender(view), stamp)
        self._move(*moved, stamp)
        self._drop_gone(view, stamp)
        del self._tracks[: max(0, len(self._tracks) - MAX_TRACKS)]
        self._look_for_second_legs(view, stamp)
        self.bodies = self._published(view, stamp)

    def _follow(self, view: ScanView, seen: Slender, stamp: float) -> None:
        """Match slender objects with those of the scan before."""
        x, y = self._places()
        apart = np.hypot(seen.x[:, None] - x, seen.y[:, None] - y)
        for number, (x_seen, y_seen, width, is_whole) in enumerate(
            zip(seen.x.tolist(), seen.y.tolist(), seen.width.tolist(), seen.is_whole.tolist(), strict=True)
        ):
            same = int(apart[number].argmin()) if apart.shape[1] else -1
            if same >= 0 and apart[number, same] < SAME:
                apart[:, same] = np.inf
                track = self._tracks[same]
                track.put(x_seen, y_seen, stamp)
                track.sightings += 1
            else:
                track = BodyTrack(x_seen, y_seen, stamp, stamp, True, (x_seen, y_seen))
                self._tracks.append(track)
            track.is_slender, track.slender_at = True, stamp
            track.is_whole |= is_whole
            if is_whole:
                error = WIDTH_ERROR + view.step * hypot(x_seen - view.x, y_seen - view.y) / 2.0
                track.seen_width = width, error

    def _move(self, x: Floats, y: Floats, stamp: float) -> None:
        """Add the evidence of motions; what moved and is not slender is followed as well."""
        if not len(x):
            return
        track_x, track_y = self._places()
        apart: Floats = np.hypot(track_x[:, None] - x, track_y[:, None] - y)
        is_same: Bools = apart < SAME_MOTION
        if len(self._tracks):  # a motion is that of the nearest object, not of what stands beside it
            nearest = apart.argmin(axis=0)
            for number in np.unique(nearest[is_same.any(axis=0)]):
                self._tracks[number].move(stamp)
        is_known: Bools = np.asarray(is_same.any(axis=0))
        breaks = np.flatnonzero(np.hypot(np.diff(x), np.diff(y)) > CLUSTER_GAP) + 1
        for cluster in np.split(np.arange(len(x)), breaks):
            if len(cluster) >= MIN_CLUSTER and not is_known[cluster].any():
                place = float(x[cluster].mean()), float(y[cluster].mean())
                track = BodyTrack(*place, stamp, stamp, False, place, sightings=MIN_SIGHTINGS)
                track.move(stamp)
                self._tracks.append(track)

    def _drop_gone(self, view: ScanView, stamp: float) -> None:
        """Remove what is not seen any more where it was, and collect what is seen at the others."""
        if not self._tracks:
            return
        x, y = self._places()
        depth, beams, is_towards = view.look(x, y, EDGE)
        is_in_view = is_towards & (view.depths[beams] > depth - DEPTH_ERROR)
        # In single precision, which is exact to a millimetre here and takes half the time.
        from_x = (x - view.x).astype(np.float32)[:, None] - (view.end_x - view.x).astype(np.float32)
        from_y = (y - view.y).astype(np.float32)[:, None] - (view.end_y - view.y).astype(np.float32)
        squared = from_x * from_x + from_y * from_y
        is_there = ((squared < MAX_SHIFT * MAX_SHIFT) & view.hits).any(axis=1)
        is_part = ((squared < SURFACE_RANGE * SURFACE_RANGE) & view.extended).any(axis=1)
        is_part |= self._surfaces.are_near(x, y, SURFACE_RANGE)
        # A new object at the same place replaces an older one.
        is_new = np.array([track.slender_at == stamp for track in self._tracks])
        is_near = (x[:, None] - x[is_new]) ** 2 + (y[:, None] - y[is_new]) ** 2 < MAX_STEP * MAX_STEP
        is_doubled = ~is_new & is_near.any(axis=1)
        kept = []
        for track, in_view, there, part, doubled in zip(
            self._tracks, is_in_view.tolist(), is_there.tolist(), is_part.tolist(), is_doubled.tolist(), strict=True
        ):
            if doubled or (in_view and not (there and track.lasts(stamp))):
                continue
            kept.append(track)
            if in_view or track.slender_at == stamp:
                track.seen_at = stamp
                if track.is_new_view(view, stamp):
                    track.take_view(is_part=part)
        self._tracks = kept

    def _look_for_second_legs(self, view: ScanView, stamp: float) -> None:
        """Update where the second leg may be, for each object in view that may be a leg."""
        seen = [track for track in self._tracks if track.is_slender and track.seen_at == stamp]
        # What is too thin for a leg is not the second leg of another one either.
        legs = [(track.x, track.y) for track in seen if track.width >= TOO_THIN]
        seen = [track for track in seen if track.log_odds(stamp) > CERTAIN]
        if not seen:
            return
        x, y = np.array([track.x for track in seen]), np.array([track.y for track in seen])
        places_x, places_y = x[:, None] + STRIDES_X, y[:, None] + STRIDES_Y
        depth, beams, is_towards = view.look(places_x, places_y)
        ranges = view.depths[beams]
        is_surface = view.extended[beams] & (np.abs(ranges - depth) <= DEPTH_ERROR)
        is_free = is_towards & ((ranges > depth + DEPTH_ERROR) | is_surface)
        for track, free, to_x, to_y in zip(seen, is_free, places_x, places_y, strict=True):
            is_leg = np.zeros(len(free), bool)
            for leg_x, leg_y in legs:
                if 0.0 < hypot(leg_x - track.x, leg_y - track.y) < MAX_STRIDE:
                    is_leg |= (to_x - leg_x) ** 2 + (to_y - leg_y) ** 2 < BESIDE * BESIDE
            track.take_second(free, is_leg)

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
                discs.append((*track.disc(), has_moved))
        if not discs:
            return Bodies.none()
        x, y, radius, moved = zip(*discs, strict=True)
        return Bodies(np.array(x), np.array(y), np.array(radius), np.array(moved, bool))

    def _is_believed(self, track: BodyTrack, view: ScanView, stamp: float) -> bool:
        if track.sightings < MIN_SIGHTINGS or track.log_odds(stamp) <= 0.0:
            return False
        is_beside = hypot(track.x - view.x, track.y - view.y) < HIDDEN_RANGE
        return track.seen_at == stamp or (is_beside and stamp - track.seen_at < HIDDEN_TIME)

    def _places(self) -> tuple[Floats, Floats]:
        return np.array([track.x for track in self._tracks]), np.array([track.y for track in self._tracks])


def _apart(one: BodyTrack, other: BodyTrack) -> float:
    return hypot(one.x - other.x, one.y - other.y)

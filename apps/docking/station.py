"""The station of a charging dock in a laser scan: from echoes to the pose of the dock. No bus, no clock."""

from collections.abc import Iterator
from math import atan2, cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from apps.docking.settings import StationSettings
from geometry import Pose2D, wrap_angle

Floats = NDArray[np.float64]

_LINES = 3
"""Lines that are looked for in one thing: face, side and wall."""


def to_frame(points: Floats, frame: Pose2D) -> Floats:
    """Return points, shape (n, 2), in the frame of a pose that is given in the frame of the points."""
    cosine, sine = cos(frame.heading), sin(frame.heading)
    turned: Floats = (points - (frame.x, frame.y)) @ np.array(((cosine, -sine), (sine, cosine)))
    return turned


def find_dock(points: Floats, expected: Pose2D, settings: StationSettings) -> Pose2D | None:
    """Find the pose of a dock by the face of its station.

    Args:
        points: Echoes, m, shape (n, 2), in the order of the beams.
        expected: Pose of the dock in the frame of the points: of a robot that stands on it, facing the station.
        settings: Of the station.
    Returns:
        Its pose in that frame; None where no face of this width is seen near the expected one.
    """
    local = to_frame(points, expected)
    best, found = settings.search_m, None
    for x, y, turned in (face for thing in _things(local, settings) for face in _faces(thing, settings)):
        pose = Pose2D(x, y, turned).compose(Pose2D(-settings.ahead_m, 0.0, 0.0))
        off = hypot(pose.x, pose.y)
        if off < best and abs(turned) <= settings.search_rad:
            best, found = off, pose
    return None if found is None else expected.compose(found)


def _things(points: Floats, settings: StationSettings) -> list[Floats]:
    """Return runs of echoes near the expected station, without gaps."""
    reach = settings.search_m + settings.width_m
    near = np.hypot(points[:, 0] - settings.ahead_m, points[:, 1]) < reach
    chosen = points[near]
    if len(chosen) < settings.echoes:
        return []
    gaps = np.hypot(*np.diff(chosen, axis=0).T) > settings.apart_m
    return [run for run in np.split(chosen, np.flatnonzero(gaps) + 1) if len(run) >= settings.echoes]


def _faces(thing: Floats, settings: StationSettings) -> Iterator[tuple[float, float, float]]:
    """Yield middle (m) and heading (rad) into each face of the right width that looks at the robot.

    A thing may show a side as well, and the wall behind it. So the line of most echoes is taken, then that of most
    others: of all pairs of echoes that are half a face apart, the one with most echoes beside its line.
    """
    for _ in range(_LINES):
        first, second = np.triu_indices(len(thing), 1)
        ways = thing[second] - thing[first]
        lengths = np.hypot(ways[:, 0], ways[:, 1])
        usable = np.flatnonzero((lengths > settings.width_m / 2) & (np.abs(ways[:, 1]) > np.abs(ways[:, 0])))
        if not len(usable):
            return
        normals = np.column_stack((-ways[usable, 1], ways[usable, 0])) / lengths[usable, np.newaxis]
        offsets = np.sum(normals * thing[first[usable]], axis=1)
        beside = np.abs(thing @ normals.T - offsets) < settings.flat_m  # (echoes, pairs)
        best = beside[:, int(np.argmax(beside.sum(axis=0)))]
        echoes, thing = thing[best], thing[~best]
        if len(echoes) < settings.echoes:
            return
        middle = echoes.mean(axis=0)
        _, _, axes = np.linalg.svd(echoes - middle, full_matrices=False)
        along = (echoes - middle) @ axes[0]
        if abs(float(np.ptp(along)) - settings.width_m) <= settings.tolerance_m:
            x, y = middle + axes[0] * (along.max() + along.min()) / 2
            heading = wrap_angle(atan2(axes[0][1], axes[0][0]) - pi / 2)
            yield float(x), float(y), heading if abs(heading) <= pi / 2 else wrap_angle(heading + pi)

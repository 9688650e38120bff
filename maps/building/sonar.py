"""Maps of sonar alone: echoes of a piece of the way make up one view, as if a scanner had seen them.

An echo comes from the nearest surface in a cone, mostly where that faces the disc. So its point is put on the axis, its
normal points to the disc, and the cone up to shortly before it is free. Views are matched with those before them and
correct the odometry.

Source for cones in grids: H. Moravec and A. Elfes, High resolution maps from wide angle sonar, ICRA 1985.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot

import numpy as np

from geometry import Pose2D, wrap_angle
from maps.building.laser_builder import MappingSettings
from maps.building.readings import BeamView, Floats, Mount, OdometryTrack, moved, turned

FIRST = 40
"""Echoes that make up the first view, from where the robot stands at the start: the origin of the map."""


@dataclass(frozen=True, slots=True)
class SonarMapping:
    """How readings become views.

    farthest: m of an echo that is used; farther ones are mostly reflected twice. free_to: m that are free where there
    is no echo. before: m before an echo that are not free yet. cone: rad, of the part of the cone that is.
    rays: in that part. view_distance, view_turn: m and rad of driving that make up a view.
    """

    farthest: float = 2.5
    free_to: float = 1.5
    before: float = 0.15
    cone: float = 0.3
    rays: int = 5
    view_distance: float = 0.8
    view_turn: float = 0.8


@dataclass(frozen=True, slots=True)
class DiscReading:
    """One range: s, number of the disc, m; infinite without an echo."""

    stamp: float
    disc: int
    range: float


class SonarViews:
    """Collects readings until they make up a view."""

    def __init__(self, discs: Mapping[int, Mount], settings: SonarMapping | None = None) -> None:
        """Begin. discs: where they are, by their numbers."""
        self._discs = discs
        self._settings = settings or SonarMapping()
        self._readings: list[tuple[Pose2D, DiscReading]] = []
        self._start: Pose2D | None = None
        self._has_begun = False

    def _echoes(self) -> int:
        return sum(reading.range < self._settings.farthest for _, reading in self._readings)

    def add(self, reading: DiscReading, track: OdometryTrack) -> BeamView | None:
        """Take a reading; return a view when the robot has driven far enough."""
        poses = track.at(np.array([reading.stamp]))
        if poses is None or reading.disc not in self._discs:
            return None
        pose = Pose2D(float(poses[0, 0]), float(poses[0, 1]), wrap_angle(float(poses[0, 2])))
        if self._start is None:
            self._start = pose
        self._readings.append((pose, reading))
        step = pose.relative_to(self._start)
        settings = self._settings
        near = hypot(step.x, step.y) < settings.view_distance and abs(step.heading) < settings.view_turn
        if near and (self._has_begun or self._echoes() < FIRST):
            return None
        view = self._view(pose if self._has_begun else self._start)
        self._has_begun = True
        self._readings, self._start = [], pose
        return view

    def _view(self, pose: Pose2D) -> BeamView | None:
        """The readings in the frame of a pose."""
        settings = self._settings
        hits: list[tuple[Floats, Floats]] = []
        free: list[tuple[Floats, Floats]] = []
        fan = np.linspace(-settings.cone / 2.0, settings.cone / 2.0, settings.rays)
        for at, reading in self._readings:
            mount = self._discs[reading.disc]
            placed = at.relative_to(pose)
            disc = placed.compose(Pose2D(*mount))
            is_echo = reading.range < settings.farthest
            length = reading.range - settings.before if is_echo else settings.free_to
            if is_echo:
                hits.append(_beams(disc, np.zeros(1), reading.range))
            if length > 0.1:
                free.append(_beams(disc, fan, length))
        if not hits or not free:
            return None
        origins, points = (np.concatenate(each) for each in zip(*hits, strict=True))
        free_origins, free_points = (np.concatenate(each) for each in zip(*free, strict=True))
        return BeamView(self._readings[-1][1].stamp, pose, origins, points, free_origins, free_points)


def _beams(disc: Pose2D, bearings: Floats, length: float) -> tuple[Floats, Floats]:
    """Beginnings and ends of beams of one length from a disc."""
    ends = turned(np.stack((np.full(len(bearings), length), np.zeros(len(bearings))), axis=1), bearings)
    return np.tile([disc.x, disc.y], (len(bearings), 1)), moved(ends, disc)


def echo_normals(points: Floats, origins: Floats) -> Floats:
    """Return the normals of surfaces that threw sound back: towards the discs."""
    way = origins - points
    result: Floats = way / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
    return result


WEIGHT = 0.005
"""Of matches of echoes: single ones err by a part of the cone, some ten times as much as points of a laser."""
MATCHING = MappingSettings(
    key_distance=0.5,
    key_turn=0.5,
    same_distance=0.0,
    same_turn=0.0,
    near=6.0,
    most_near=20,
    odometry_distance=0.01,
    odometry_turn=0.02,
    loop_after=1e9,
    match_weight=WEIGHT,
)
"""Of views of sonar. Loops are not closed: too many places sound alike."""

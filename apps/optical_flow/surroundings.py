"""Distances around the robot by what it remembers: ahead, at the sides, in each direction, and along curves."""

from dataclasses import dataclass

import numpy as np

from apps.optical_flow.columns import Floats
from apps.optical_flow.memory import FloorMemory
from apps.optical_flow.settings import FlowSettings
from geometry import Pose2D

_STEP = 0.25  # s along a curve
_TURN_STEP = np.radians(6.0)
_TURN_GAP = 0.07  # m between the hull and an obstacle while it turns on the spot
_TURN_GAP_UNKNOWN = 0.03  # m likewise, to the middle of a place of which nothing is known
_NEXT = 0.45  # m before the hull that the camera does not see beside its middle, so that it must have been seen before
_UNSEEN = 16.0  # places at the hull that make a curve as risky as one can be
_NEARER, _LEAST = 0.02, 0.05  # m by which what is within the margin may come nearer, and how near at most
_ROUNDING = 0.001  # m
_BESIDE = 0.5  # m before the axle to which obstacles count as beside the robot


@dataclass(frozen=True, slots=True, eq=False)
class FlowSurroundings:
    """What is around the robot now. Distances are in m from the hull unless said otherwise; infinite for none.

    points: obstacles, m in the frame of the robot, shape (n, 2). ahead: to an obstacle in the lane. known: along the
    middle of the lane to where nothing is known. left, right: at the sides. bearings: of the directions, rad, left
    positive. clear: m that the axle can go in each direction. fresh: m of that which were not visited lately.
    sure: share of the floor next to the hull in each direction that is known to be free.
    unknown: floor near the robot that is not known to be free, m in the frame of the robot, shape (n, 2).
    unseen: the part of it that is out of view; of the other part, images will tell.
    """

    points: Floats
    ahead: float
    known: float
    left: float
    right: float
    bearings: Floats
    clear: Floats
    fresh: Floats
    sure: Floats
    unknown: Floats
    unseen: Floats

    @classmethod
    def around(cls, pose: Pose2D, time: float, memory: FloorMemory, settings: FlowSettings) -> "FlowSurroundings":
        """Return what the memory has around a pose at a time, s."""
        robot, reach, cell = settings.robot, settings.memory.range_m, settings.memory.cell_m
        points = memory.obstacles(pose)
        half = robot.width_m / 2.0 + settings.drive.side_gap_m
        x, y = points[:, 0], points[:, 1]
        # What is beside the hull, within the margin, is not ahead.
        lane = (x > 0.0) & (np.abs(y) < np.where(x > robot.front_m, half, robot.width_m / 2.0))
        beside = (x > -robot.rear_m) & (x < _BESIDE)
        left, right = y[beside & (y > 0.0)], -y[beside & (y <= 0.0)]
        steps = np.arange(cell / 2.0, reach, cell)
        middle = steps[steps > robot.front_m]
        is_known = memory.are_known(pose, np.stack((middle, np.zeros(len(middle))), axis=1))
        hidden = middle[~is_known]
        bearings = np.linspace(-np.pi, np.pi, settings.coverage.directions, endpoint=False)
        clear = _clear(points, bearings, half, reach)
        rays = np.stack((np.outer(np.cos(bearings), steps), np.outer(np.sin(bearings), steps)), axis=2)
        newness = memory.newness(pose, rays.reshape(-1, 2), time).reshape(len(bearings), -1)
        fresh = np.where(steps[None, :] < clear[:, None], newness, 0.0).sum(axis=1) * cell
        unknown = _unknown(pose, memory, settings)
        return cls(
            points,
            float(x[lane].min(initial=np.inf)) - robot.front_m,
            float(hidden.min(initial=reach)) - robot.front_m,
            float(left.min(initial=np.inf)) - robot.width_m / 2.0,
            float(right.min(initial=np.inf)) - robot.width_m / 2.0,
            bearings,
            clear,
            fresh,
            _sure(pose, bearings, memory, settings),
            unknown,
            unknown[~_is_in_view(unknown, memory, settings)],
        )

    def toward(self, bearing: float, width: float) -> float:
        """Return the largest clear distance, m from the axle, within `width` rad about a bearing."""
        away = np.abs(np.remainder(self.bearings - bearing + np.pi, 2.0 * np.pi) - np.pi)
        return float(self.clear[away <= width / 2.0].max(initial=0.0))

    def free_curves(self, speed: float, turns: Floats, settings: FlowSettings) -> np.ndarray:
        """Return for each turn rate, rad/s, whether the curve at a speed, m/s, is free of obstacles."""
        drive = settings.drive
        return self._keep_away(self.points, (drive.side_gap_m, drive.front_gap_m), speed, turns, settings)

    def seen_curves(self, speed: float, turns: Floats, settings: FlowSettings) -> np.ndarray:
        """Return for each turn rate, rad/s, whether the hull stays on floor that was seen, at a speed, m/s.

        The inner side of a curve may never come into view before the hull is there.
        """
        return self._keep_away(self.unseen, (settings.drive.unseen_gap_m, 0.0), speed, turns, settings)

    def risks(self, turns: Floats, settings: FlowSettings) -> Floats:
        """Return for each turn rate, rad/s, how much unseen floor the hull comes near to, 0 to 1, at slow speed."""
        drive = settings.drive
        if not len(self.unseen):
            return np.zeros(len(turns))
        _, ahead, aside = _curve(self.unseen, drive.slow_m_s, turns, 3.0 * _STEP, settings)
        away = _gap(ahead, aside, settings)
        near = np.maximum(1.0 - away.min(axis=1) / drive.side_gap_m, 0.0)
        return np.asarray(np.minimum(near.sum(axis=1) / _UNSEEN, 1.0))

    def _keep_away(
        self, places: Floats, gaps: tuple[float, float], speed: float, turns: Floats, settings: FlowSettings
    ) -> np.ndarray:
        """Return for each curve whether the hull keeps gaps from places, m: beside it, and before it at the end."""
        robot, drive = settings.robot, settings.drive
        near = places[np.hypot(*places.T) < speed * drive.horizon_s + robot.front_m + 0.5]
        if not len(near):
            return np.ones(len(turns), np.bool_)
        side, before = gaps
        times, ahead, aside = _curve(near, speed, turns, _STEP, settings)
        front = np.where(times < times[-1], robot.front_m, robot.front_m + before)[None, :, None]
        struck = (ahead > -robot.rear_m) & (ahead < front) & (np.abs(aside) < robot.width_m / 2.0 + side)
        # What is within the margin already must not hold the robot: it only must not come nearer.
        now = np.flatnonzero(_beside(near, side, settings))
        gap = _gap(near[now, 0], near[now, 1], settings)
        least = np.minimum(gap, np.maximum(gap - _NEARER, _LEAST))
        struck[..., now] &= _gap(ahead[..., now], aside[..., now], settings) < least - _ROUNDING
        return np.asarray(~struck.any(axis=(1, 2)))

    def can_turn(self, angle: float, settings: FlowSettings, *, is_seen: bool = True) -> bool:
        """Return whether the hull can turn on the spot by an angle, rad, without an obstacle in its way.

        is_seen: whether floor that was never seen is in the way too; the rear goes where the camera does not look.
        """
        headings = np.sign(angle) * np.arange(_TURN_STEP, abs(angle) + _TURN_STEP, _TURN_STEP)
        is_free = not self._strikes(self.points, headings, _TURN_GAP, settings)
        return is_free and not (is_seen and self._strikes(self.unknown, headings, _TURN_GAP_UNKNOWN, settings))

    @staticmethod
    def _strikes(places: Floats, headings: Floats, gap: float, settings: FlowSettings) -> bool:
        """Return whether any place is at most a gap, m, from the hull at any heading, rad."""
        robot = settings.robot
        near = places[np.hypot(*places.T) < robot.turning_m + 2.0 * gap]
        ahead, aside = _seen_from(np.zeros_like(headings), np.zeros_like(headings), headings, near)
        inside = (ahead > -robot.rear_m - gap) & (ahead < robot.front_m + gap)
        return bool((inside & (np.abs(aside) < robot.width_m / 2.0 + gap)).any())

    def can_back(self, distance: float, settings: FlowSettings) -> bool:
        """Return whether the hull can go straight back by a distance, m."""
        robot = settings.robot
        x, y = self.points[:, 0], self.points[:, 1]
        behind = (x < 0.0) & (x > -robot.rear_m - distance - _TURN_GAP)
        return not bool((behind & (np.abs(y) < robot.width_m / 2.0)).any())


def _beside(points: Floats, gap: float, settings: FlowSettings) -> np.ndarray:
    """Return which points are beside the hull, at most so many m away."""
    robot = settings.robot
    x, y = points[:, 0], points[:, 1]
    inside = (x > -robot.rear_m) & (x < robot.front_m) & (np.abs(y) < robot.width_m / 2.0 + gap)
    return np.asarray(inside)


def _curve(
    points: Floats, speed: float, turns: Floats, step: float, settings: FlowSettings
) -> tuple[Floats, Floats, Floats]:
    """Return times on curves, s, and points as the robot sees them then: ahead and to the left, (turns, times, n)."""
    times = np.arange(_STEP, settings.drive.horizon_s + 1e-9, step)
    headings = np.outer(turns, times)
    # The chord of an arc has half of its turn; sinc(0) is 1.
    chord = speed * times[None, :] * np.sinc(headings / 2.0 / np.pi)
    x, y = chord * np.cos(headings / 2.0), chord * np.sin(headings / 2.0)
    return times, *_seen_from(x, y, headings, points)


def _gap(ahead: Floats, aside: Floats, settings: FlowSettings) -> Floats:
    """Return the distance of places from the hull, m."""
    robot = settings.robot
    beyond = np.maximum(np.maximum(ahead - robot.front_m, -robot.rear_m - ahead), 0.0)
    return np.asarray(np.hypot(beyond, np.maximum(np.abs(aside) - robot.width_m / 2.0, 0.0)))


def _clear(points: Floats, bearings: Floats, radius: float, reach: float) -> Floats:
    """Return how far a disc can go in each direction, m."""
    if not len(points):
        return np.full(len(bearings), reach)
    along = np.outer(np.cos(bearings), points[:, 0]) + np.outer(np.sin(bearings), points[:, 1])
    across = np.outer(np.cos(bearings), points[:, 1]) - np.outer(np.sin(bearings), points[:, 0])
    inside = np.maximum(radius**2 - across**2, 0.0)
    until = np.where((np.abs(across) < radius) & (along > 0.0), along - np.sqrt(inside), reach)
    return np.asarray(np.clip(until.min(axis=1), 0.0, reach))


def _unknown(pose: Pose2D, memory: FloorMemory, settings: FlowSettings) -> Floats:
    """Return places beside the hull that it can come near to, and of which nothing is known."""
    robot, cell = settings.robot, settings.memory.cell_m
    reach = settings.drive.speed_m_s * settings.drive.horizon_s + robot.front_m
    along, across = np.arange(-robot.turning_m - cell, reach, cell / 2.0), np.arange(-0.6, 0.61, cell / 2.0)
    x, y = (each.ravel() for each in np.meshgrid(along, across))
    is_hull = (x >= -robot.rear_m) & (x <= robot.front_m) & (np.abs(y) <= robot.width_m / 2.0)
    places = np.stack((x, y), axis=1)[~is_hull]
    return np.asarray(places[~memory.are_known(pose, places)])


def _is_in_view(places: Floats, memory: FloorMemory, settings: FlowSettings) -> np.ndarray:
    bearings = np.arctan2(places[:, 1], places[:, 0] - settings.robot.camera_m)
    return np.asarray(np.abs(bearings) < memory.half_view)


def _sure(pose: Pose2D, bearings: Floats, memory: FloorMemory, settings: FlowSettings) -> Floats:
    """Return the share of the floor before the hull that is known to be free, if it looked in each direction."""
    robot = settings.robot
    ahead = np.arange(robot.front_m + 0.1, robot.front_m + _NEXT, settings.memory.cell_m)
    x, y = (each.ravel() for each in np.meshgrid(ahead, np.linspace(-0.5, 0.5, 5) * robot.width_m))
    cosine, sine = np.cos(bearings)[:, None], np.sin(bearings)[:, None]
    places = np.stack((cosine * x - sine * y, sine * x + cosine * y), axis=2).reshape(-1, 2)
    return np.asarray(memory.are_known(pose, places).reshape(len(bearings), -1).mean(axis=1))


def _seen_from(x: Floats, y: Floats, headings: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Return points in the frames of poses: ahead and to the left, shape (*poses, points)."""
    away_x, away_y = points[:, 0] - x[..., None], points[:, 1] - y[..., None]
    cosine, sine = np.cos(headings)[..., None], np.sin(headings)[..., None]
    return cosine * away_x + sine * away_y, cosine * away_y - sine * away_x

"""Robots of the team that come nearer, by the poses on the map that they share.

Two scans show a robot's solid body at almost the same place, so it does not count as somebody who walks. Two robots
that take each other for walls brake too late: each counts on the whole gap between them.
"""

from collections import deque

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.data import Floats, Pose

SPEED_FROM, KEPT = 0.25, 0.6  # s between two poses that give a speed, and for which a pose is kept
FRESH = 0.5  # s after which a pose is no longer used: a robot that is lost shares none
CLOSING = 0.08  # m/s from which on a robot comes nearer; less may be the error of its localization
RANGE = 3.0  # m within which robots are looked at
UNKNOWN_REACH = 0.35  # m from the middle of a robot to its corners while nobody has told its size

Closing = tuple[Floats, Floats, Floats, Floats]
"""Robots that come nearer: x and y of their middles in the frame of this robot, m, their speeds towards it, m/s,
and how far their corners are from their middles, m."""
NOBODY: Closing = np.empty(0), np.empty(0), np.empty(0), np.empty(0)


class Teammates:
    """The latest poses of all robots that share them, this one included. All times are s of one steady clock."""

    def __init__(self, robot: str) -> None:
        """robot: the name of this one."""
        self._robot = robot
        self._poses: dict[str, deque[tuple[float, Pose]]] = {}
        self._reaches: dict[str, float] = {}

    def forget(self) -> None:
        """Forget all poses; sizes do not change."""
        self._poses.clear()

    def see(self, robot: str, pose: Pose, now: float) -> None:
        """Take the pose of a robot on the map."""
        poses = self._poses.setdefault(robot, deque())
        poses.append((now, pose))
        while poses[0][0] < now - KEPT:
            poses.popleft()

    def measure(self, robot: str, reach: float) -> None:
        """Take the distance of a robot's corners from its middle, m."""
        self._reaches[robot] = reach

    def closing(self, now: float) -> Closing:
        """Return the robots that come nearer; none while this robot is not localized."""
        here = self._latest(self._robot, now)
        if here is None:
            return NOBODY
        found = []
        for robot, poses in self._poses.items():
            place = self._latest(robot, now)
            before = next((each for each in reversed(poses) if poses[-1][0] - each[0] >= SPEED_FROM), None)
            if robot == self._robot or place is None or before is None:
                continue
            to_me = np.subtract(here[:2], place[:2])
            away = float(np.hypot(*to_me))
            velocity = np.subtract(place[:2], before[1][:2]) / (poses[-1][0] - before[0])
            speed = float(velocity @ to_me) / max(away, 1e-9)
            if away < RANGE and speed > CLOSING:
                found.append((*place[:2], speed, self._reaches.get(robot, UNKNOWN_REACH)))
        if not found:
            return NOBODY
        x, y, speeds, reaches = np.array(found).T
        return *in_robot(here, x, y), speeds, reaches

    def _latest(self, robot: str, now: float) -> Pose | None:
        """Return the pose of a robot, if it is fresh."""
        poses = self._poses.get(robot)
        return poses[-1][1] if poses and now - poses[-1][0] <= FRESH else None

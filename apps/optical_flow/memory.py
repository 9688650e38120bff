"""What the robot remembers of its surroundings: obstacles and free floor from time to contact, and where it has been.

A time to contact is a distance once the robot's own speed is known, which its odometry measures. Evidence for and
against an obstacle is added up for each cell of the floor (Elfes, Computer 22, 1989), and fades: odometry drifts.
"""

import math

import numpy as np
from numpy.typing import NDArray

from apps.optical_flow.columns import Floats
from apps.optical_flow.settings import FlowSettings
from geometry import Pose2D, wrap_angle

SIDE = 400  # cells; what is farther apart than this shares a cell, and has faded before the robot gets there
_RAYS = 3  # for each column
_SUSPECTED = 1.35  # of the evidence of an obstacle: it has faded after 12 s
_DOUBT = 0.97  # for each decision
_KNOWN = 0.2  # evidence from which on a cell is known to be free
Ints = NDArray[np.int64]


class FloorMemory:
    """A grid in the frame of the odometry that moves with the robot.

    half_view: angle from the middle of the newest image to its sides, rad.
    """

    def __init__(self, settings: FlowSettings) -> None:
        self.half_view = 0.0
        self._settings = settings
        self._cell = settings.memory.cell_m
        self._evidence = np.zeros((SIDE, SIDE))  # above 0 for an obstacle
        self._visited = np.full((SIDE, SIDE), -np.inf)  # s, when the robot was there last
        self._time, self._heading, self._turned = 0.0, 0.0, 0.0
        radius = settings.coverage.width_m / 2.0
        self._disc = _disc(radius, self._cell)
        self._hull = _disc(settings.robot.width_m / 2.0 - self._cell / 2.0, self._cell)
        self._circle = _disc(settings.robot.turning_m + 2.0 * self._cell, self._cell)
        reach = int(settings.memory.range_m / self._cell) + 2
        self._window = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2, indexing="ij"), axis=2).reshape(-1, 2)

    def begin(self, pose: Pose2D) -> None:
        """Take the circle that the robot needs to turn for free: it was put there by somebody who saw it."""
        self._heading = pose.heading
        places = self._index(np.array([[pose.x, pose.y]]))
        circle = _disc(self._settings.robot.turning_m + self._cell, self._cell)
        self._add(places + circle, -self._settings.memory.most_free)

    def pass_time(self, time: float, heading: float) -> None:
        """Let evidence fade until a time, s, at which the robot has a heading, rad."""
        self._turned += abs(wrap_angle(heading - self._heading))
        self._heading = heading
        if time - self._time >= 1.0:
            memory = self._settings.memory
            fading = (time - self._time) / memory.forget_s + self._turned / memory.forget_rad
            self._evidence *= np.exp(-fading)
            self._time, self._turned = time, 0.0

    def drive_over(self, pose: Pose2D, time: float) -> None:
        """Note that the robot is at a pose: this floor is free, and visited."""
        here = self._index(np.array([[pose.x, pose.y]]))
        self._visited[_wrapped(here + self._disc)] = time
        self._evidence[_wrapped(here + self._hull)] = -self._settings.memory.most_free

    def turn_over(self, pose: Pose2D) -> None:
        """Note that the robot has turned on the spot: the circle of its front corners is free."""
        robot = self._settings.robot
        circle = _disc(math.hypot(robot.front_m, robot.width_m / 2.0) - self._cell / 2.0, self._cell)
        self._evidence[_wrapped(self._index(np.array([[pose.x, pose.y]])) + circle)] = -self._settings.memory.most_free

    def see(self, camera: Pose2D, bearings: Floats, depths: Floats, half_width: float) -> None:
        """Take what an image shows.

        Args:
            camera: Its pose.
            bearings: Of the columns, rad, left positive.
            depths: m along the optical axis to the nearest thing in each column; infinite for none, NaN if not known.
            half_width: Of a column, rad.
        """
        memory = self._settings.memory
        self.half_view = float(np.abs(bearings).max()) + half_width
        known = ~np.isnan(depths)
        if not known.any():
            return
        spread = np.linspace(-half_width, half_width, _RAYS + 2)[1:-1]
        angles = (bearings[known][:, None] + spread).ravel()
        depth = np.repeat(depths[known], _RAYS)
        far = depth / np.cos(angles)
        # An edge lies anywhere within a column, so a column is free no farther than those beside it.
        unhidden = np.repeat(_least_beside(depths)[known], _RAYS) / np.cos(angles)
        free_to = np.minimum(unhidden * memory.free_share - self._cell, memory.range_m)
        steps = np.arange(self._cell / 2.0, memory.range_m, self._cell)
        at = np.broadcast_to(steps, (len(angles), len(steps)))
        inside = at < free_to[:, None]
        rays = np.broadcast_to(angles[:, None], at.shape)
        free = self._index(_placed(camera, at[inside], rays[inside]))
        hits = far < memory.range_m
        near = np.stack((far[hits], angles[hits]), axis=1)
        struck = self._index(_placed(camera, near[:, 0], near[:, 1]))
        weight = memory.hit * (2.0 - near[:, 0] / memory.range_m)
        change = np.zeros(SIDE * SIDE)
        flat_free, flat_struck = _flat(free), _flat(struck)
        change[np.unique(flat_free)] = -memory.miss
        order = np.argsort(weight)
        change[flat_struck[order]] = weight[order]
        touched = np.unique(np.concatenate((flat_free, flat_struck)))
        evidence = self._evidence.reshape(-1)
        evidence[touched] = np.clip(evidence[touched] + change[touched], -memory.most_free, memory.most)

    def block(self, pose: Pose2D, ahead: float, width: float) -> None:
        """Take something ahead for an obstacle that images do not show. ahead: m. width: of it, m."""
        self._set(pose, ahead, width, self._settings.memory.most)

    def suspect(self, pose: Pose2D, ahead: float, width: float) -> None:
        """Take something ahead for an obstacle for some seconds, or until images confirm or deny it."""
        self._set(pose, ahead, width, self._settings.memory.obstacle * _SUSPECTED)

    def doubt(self, pose: Pose2D) -> None:
        """Believe a little less in all obstacles that keep the hull from turning."""
        at = _wrapped(self._index(np.array([[pose.x, pose.y]])) + self._circle)
        self._evidence[at] = np.minimum(self._evidence[at], self._evidence[at] * _DOUBT)

    def obstacles(self, pose: Pose2D) -> Floats:
        """Return the middles of the obstacle cells around a pose, m in the frame of the robot, shape (n, 2)."""
        here = self._index(np.array([[pose.x, pose.y]]))
        cells = here + self._window
        cells = cells[self._evidence[_wrapped(cells)] >= self._settings.memory.obstacle]
        middles = np.asarray((cells + 0.5) * self._cell, np.float64)
        return _located(pose, middles)

    def are_known(self, pose: Pose2D, places: Floats) -> NDArray[np.bool_]:
        """Return whether places (m in the frame of the robot, shape (n, 2)) are known to be free."""
        return np.asarray(self._evidence[_wrapped(self._index(_moved(pose, places)))] <= -_KNOWN)

    def newness(self, pose: Pose2D, places: Floats, time: float) -> Floats:
        """Return from 0 to 1 how long ago the robot was at places (m in the frame of the robot); 1 for never."""
        since = time - self._visited[_wrapped(self._index(_moved(pose, places)))]
        return np.asarray(np.minimum(since / self._settings.coverage.fade_s, 1.0))

    def _set(self, pose: Pose2D, ahead: float, width: float, evidence: float) -> None:
        across = np.arange(-width / 2.0, width / 2.0 + 1e-9, self._cell / 2.0)
        at = _wrapped(self._index(np.array([pose.transform(ahead, float(y)) for y in across])))
        self._evidence[at] = np.maximum(self._evidence[at], evidence)

    def _add(self, cells: Ints, evidence: float) -> None:
        memory = self._settings.memory
        at = _wrapped(np.unique(cells % SIDE, axis=0))
        self._evidence[at] = np.clip(self._evidence[at] + evidence, -memory.most_free, memory.most)

    def _index(self, places: Floats) -> Ints:
        return np.floor(places / self._cell).astype(np.int64)


def _least_beside(depths: Floats) -> Floats:
    """Return the least depth of each column and those beside it, m; those that are not known do not count."""
    padded = np.pad(np.where(np.isnan(depths), np.inf, depths), 1, constant_values=np.inf)
    return np.asarray(np.minimum(np.minimum(padded[:-2], padded[2:]), padded[1:-1]))


def _wrapped(cells: Ints) -> tuple[Ints, Ints]:
    return cells[:, 0] % SIDE, cells[:, 1] % SIDE


def _flat(cells: Ints) -> Ints:
    rows, columns = _wrapped(cells)
    return np.asarray(rows * SIDE + columns)


def _disc(radius: float, cell: float) -> Ints:
    reach = int(radius / cell) + 1
    grid = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2, indexing="ij"), axis=2).reshape(-1, 2)
    return np.asarray(grid[np.hypot(*(grid * cell).T) <= radius + 1e-9])


def _placed(origin: Pose2D, distances: Floats, angles: Floats) -> Floats:
    directions = origin.heading + angles
    return np.stack((origin.x + distances * np.cos(directions), origin.y + distances * np.sin(directions)), axis=1)


def _moved(pose: Pose2D, places: Floats) -> Floats:
    """Return places of the robot's frame in the frame of its pose."""
    return _placed(pose, np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0]))


def _located(pose: Pose2D, places: Floats) -> Floats:
    """Return places in the frame of the robot."""
    away = places - (pose.x, pose.y)
    cosine, sine = np.cos(pose.heading), np.sin(pose.heading)
    return np.stack((cosine * away[:, 0] + sine * away[:, 1], cosine * away[:, 1] - sine * away[:, 0]), axis=1)

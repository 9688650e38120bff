"""What sonar and laser show together: the one interpretation of readings for goto, avoiding and path planning.

Obstacle avoiding must work after all other components have died, so it hears the sensors itself and has a `Perception`
of its own. Obstacle detecting has another one, with the same code and parameters, and publishes its result as ObstRead.
Goto and path planning make the same `Perceived` of that.
"""

from dataclasses import dataclass
from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.bodies import Bodies, BodyTracker
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.pose_history import is_pose_jump
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.algorithms.walkers import Moved, ScanMotion
from apps.indoor_navigation.data import LaserRead, ObstRead, Pose, SonarRead
from geometry import wrap_angle

MIN_RANGES = 3  # measured ranges of a stuck sensor; that one or two stay the same happens by chance
MAX_DISORDER = 1.0  # s that a stamp may be older than the newest one, unless the clock was set back


@dataclass(frozen=True, slots=True)
class PerceptionParameters:
    """When a sensor is used, and the resolution of the laser.

    rays: maximum number of laser rays. max_age: s behind the other sensor after which a sensor counts as silent. moved,
    turned: m and rad of motion during which the ranges of a working sensor change.
    """

    rays: int
    max_age: float
    moved: float
    turned: float


@dataclass(frozen=True, slots=True)
class Perceived:
    """What the sensors show at one moment, in odom.

    stamp: of the newest reading, s since 1970. pose: of the robot at that time. rays: those of the scanner first.
    bodies: discs that may be people.
    """

    stamp: float
    pose: Pose
    rays: Rays
    bodies: Bodies

    @classmethod
    def of(cls, reading: ObstRead) -> "Perceived":
        """Return what obstacle detecting perceived."""
        rays = Rays(reading.origin_x, reading.origin_y, reading.end_x, reading.end_y, reading.hits > 0.5)
        bodies = Bodies(reading.body_x, reading.body_y, reading.body_radius, reading.body_moved > 0.5)
        return cls(reading.stamp, reading.pose, rays, bodies)


class Perception:
    """Collects the readings of both sensors; ignores a sensor that is silent or stuck.

    moved: places in odom where the newest scan shows something that moved. had_laser: whether a scan has ever come; it
    is not forgotten.
    """

    def __init__(self, parameters: PerceptionParameters) -> None:
        self._parameters = parameters
        self.had_laser = False
        self.forget()

    def forget(self) -> None:
        """Forget all readings, because the origin of odom has changed."""
        self._laser, self._sonar = _Sensor(self._parameters, "laser"), _Sensor(self._parameters, "sonar")
        self._newest: LaserRead | SonarRead | None = None
        self._motion, self._tracker = ScanMotion(), BodyTracker()
        self._scanned = Rays.none()
        self.moved: Moved = (np.empty(0), np.empty(0))

    def take(self, reading: LaserRead | SonarRead) -> None:
        """Add a reading."""
        newest = self._newest
        if newest is not None and is_pose_jump(newest.pose, reading.pose, reading.stamp - newest.stamp):
            self.forget()
        if isinstance(reading, LaserRead):
            self._laser.take(reading)
            self.had_laser = True
            self.moved = self._motion.look(reading)
            self._tracker.see(reading, self.moved)
            self._scanned = Rays.of_laser(reading, self._parameters.rays)
        else:
            self._sonar.take(reading)
        newest = self._newest
        if newest is None or reading.stamp >= newest.stamp or newest.stamp - reading.stamp > MAX_DISORDER:
            self._newest = reading

    @property
    def stamp(self) -> float:
        """Stamp of the newest reading, s since 1970; 0 before the first."""
        return self._newest.stamp if self._newest is not None else 0.0

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with either sensor."""
        return tuple(filter(None, (sensor.fault(self.stamp) for sensor in (self._laser, self._sonar))))

    @property
    def laser(self) -> LaserRead | None:
        """The newest scan; None where the laser is silent or stuck."""
        scan = self._laser.last
        return scan if isinstance(scan, LaserRead) and not self._laser.fault(self.stamp) else None

    def perceived(self, outline: Outline) -> Perceived | None:
        """Return what both sensors of a robot with this outline show; None where no sensor works."""
        has_laser = self.laser is not None
        rays = self._rays(self._scanned if has_laser else Rays.none())
        if self._newest is None or not len(rays.end_x):
            return None
        bodies = self._tracker.bodies if has_laser else Bodies.none()
        return Perceived(self.stamp, self._newest.pose, rays, bodies.beside(outline, self._newest.pose))

    def _rays(self, seen: Rays) -> Rays:
        sonar = self._sonar.last
        if not isinstance(sonar, SonarRead) or self._sonar.fault(self.stamp):
            return seen
        return seen.followed_by(Rays.of_sonar(sonar).without_echoes_of(seen))


class _Sensor:
    """The last reading of one sensor, and the first one with the same ranges."""

    def __init__(self, parameters: PerceptionParameters, name: str) -> None:
        self._parameters = parameters
        self._name = name
        self._first: LaserRead | SonarRead | None = None  # with the ranges of the last
        self.last: LaserRead | SonarRead | None = None

    def take(self, reading: LaserRead | SonarRead) -> None:
        """Add a reading."""
        self.last = reading
        if self._first is None or not np.array_equal(self._first.ranges, reading.ranges):
            self._first = reading

    def fault(self, now: float) -> str:
        """Return what is wrong at s of the readings' clock; empty where nothing is."""
        if self._first is None or self.last is None:
            return f"the {self._name} has published nothing yet"
        if now - self.last.stamp > self._parameters.max_age:
            return f"the {self._name} is silent"
        if self._has_moved(self._first.pose, self.last.pose) and np.isfinite(self.last.ranges).sum() >= MIN_RANGES:
            return f"the {self._name} repeats the same ranges while the robot moves"
        return ""

    def _has_moved(self, before: Pose, after: Pose) -> bool:
        return (
            hypot(after[0] - before[0], after[1] - before[1]) > self._parameters.moved
            or abs(wrap_angle(after[2] - before[2])) > self._parameters.turned
        )

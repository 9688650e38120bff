"""Sonar and laser together, as far as they can be believed: what is silent or stuck is left out."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.rays import Rays, laser_rays, sonar_rays, unexplained
from apps.indoor_navigation.data import LaserRead, SonarRead
from geometry import wrap_angle

FEW = 3  # ranges; where fewer are measured, that all stay the same proves nothing


@dataclass(frozen=True, slots=True)
class SensesNumbers:
    """When a sensor is believed, and how finely.

    rays: of the laser, at most. max_age: s behind the other sensor, from which on one is silent. moved, turned: m and
    rad that the robot moves; a sensor whose ranges all stay the same meanwhile is stuck.
    """

    rays: int = 120
    max_age: float = 0.6
    moved: float = 0.15
    turned: float = 0.1


class Sensor:
    """The last reading of one sensor, and since when it has said the same."""

    def __init__(self, numbers: SensesNumbers, name: str) -> None:
        self._numbers = numbers
        self._name = name
        self._first: LaserRead | SonarRead | None = None  # with ranges as they are now
        self._last: LaserRead | SonarRead | None = None

    @property
    def last(self) -> LaserRead | SonarRead | None:
        """The newest reading."""
        return self._last

    def take(self, reading: LaserRead | SonarRead) -> None:
        """There is a new one."""
        self._last = reading
        if self._first is None or not np.array_equal(self._first.ranges, reading.ranges):
            self._first = reading

    def fault(self, now: float) -> str:
        """What is wrong with it at s of the readings' clock; empty where nothing is."""
        if self._first is None or self._last is None:
            return f"the {self._name} has said nothing yet"
        if now - self._last.stamp > self._numbers.max_age:
            return f"the {self._name} is silent"
        if np.isfinite(self._last.ranges).sum() >= FEW and self._has_moved(self._first.pose, self._last.pose):
            return f"the {self._name} says the same wherever the robot is"
        return ""

    def _has_moved(self, before: tuple[float, float, float], after: tuple[float, float, float]) -> bool:
        return (
            hypot(after[0] - before[0], after[1] - before[1]) > self._numbers.moved
            or abs(wrap_angle(after[2] - before[2])) > self._numbers.turned
        )


class Senses:
    """Both sensors. The pose is that of the newest reading."""

    def __init__(self, numbers: SensesNumbers) -> None:
        self._numbers = numbers
        self._laser, self._sonar = Sensor(numbers, "laser"), Sensor(numbers, "sonar")
        self._newest: LaserRead | SonarRead | None = None

    def take(self, reading: LaserRead | SonarRead) -> None:
        """One of them has measured."""
        (self._laser if isinstance(reading, LaserRead) else self._sonar).take(reading)
        if self._newest is None or reading.stamp >= self._newest.stamp or self._newest.stamp - reading.stamp > 1.0:
            self._newest = reading

    def forget(self) -> None:
        """The robot's pose was set anew, and places say nothing any more."""
        self._laser, self._sonar = Sensor(self._numbers, "laser"), Sensor(self._numbers, "sonar")
        self._newest = None

    @property
    def stamp(self) -> float:
        """Of the newest reading, s since 1970."""
        return self._newest.stamp if self._newest is not None else 0.0

    @property
    def pose(self) -> tuple[float, float, float]:
        """Of the robot in odom, at that time."""
        return self._newest.pose if self._newest is not None else (0.0, 0.0, 0.0)

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with either."""
        return tuple(filter(None, (sensor.fault(self.stamp) for sensor in (self._laser, self._sonar))))

    @property
    def laser(self) -> LaserRead | None:
        """The newest scan, where it is to be believed."""
        scan = self._laser.last
        return scan if isinstance(scan, LaserRead) and not self._laser.fault(self.stamp) else None

    def rays(self) -> Rays:
        """What both see, the laser's first; none where neither is to be believed."""
        scan, sonar = self.laser, self._sonar.last
        seen = laser_rays(scan, self._numbers.rays) if scan is not None else Rays.none()
        if not isinstance(sonar, SonarRead) or self._sonar.fault(self.stamp):
            return seen
        return seen.followed_by(unexplained(sonar_rays(sonar), seen))

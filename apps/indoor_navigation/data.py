"""What flows between the components of the navigation.

Lengths in m, angles in rad, counter-clockwise, speeds in m/s and rad/s, stamps in s since 1970. Unless said otherwise,
places are in the robot's `odom` frame. Its origin is where the robot stood when its gateway first connected, and its x
axis points to where the robot faced then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from math import isfinite
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from bus import MessageError

Floats = NDArray[np.float64]
Place = tuple[float, float]

MILLIMETRES = 3  # digits that ranges are sent with; no sensor here measures finer


@dataclass(frozen=True, slots=True)
class Data:
    """Anything that flows. On the bus it is a JSON object of its fields; an array is a list, its infinities null."""

    bus_name: ClassVar[str]  # in keys and wiring files
    arrays: ClassVar[frozenset[str]] = frozenset()
    parts: ClassVar[Mapping[str, type["Data"]]] = {}  # fields that are tuples of other data

    def __init_subclass__(cls) -> None:
        if "bus_name" not in vars(cls):
            cls.bus_name = cls.__name__

    def to_json(self) -> dict[str, Any]:
        """As it travels."""
        told: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name in self.arrays:
                told[each.name] = _listed(value)
            elif each.name in self.parts:
                told[each.name] = [part.to_json() for part in value]
            else:
                told[each.name] = value
        return told

    @classmethod
    def from_json(cls, told: Mapping[str, Any]) -> Self:
        """As it has come.

        Raises:
            MessageError: It is not of this kind.
        """
        arrays, parts = cls.arrays, cls.parts
        try:
            if not arrays and not parts and list not in map(type, told.values()):
                return cls(**told)  # so it is with commands, which come most often
            given = {
                name: _array(value)
                if name in arrays
                else tuple(parts[name].from_json(part) for part in value)
                if name in parts
                else tuple(value)
                if isinstance(value, list)
                else value
                for name, value in told.items()
            }
            return cls(**given)
        except (TypeError, ValueError) as err:
            raise MessageError(f"this is no {cls.bus_name}: {err}") from err


def _listed(values: Floats) -> list[Any]:
    return [value if isfinite(value) else None for value in np.round(values, MILLIMETRES).tolist()]


def _array(values: list[Any]) -> Floats:
    array = np.array(values, dtype=np.float64)
    array[np.isnan(array)] = np.inf
    return array


# Missions.


@dataclass(frozen=True, slots=True)
class GoalPoint(Data):
    """Where a person wants the robot to be.

    mission: its name. heading: at the end; None where any will do. tolerance: how near is there. A mission without a
    place is cancelled: the robot stops.
    """

    mission: str
    x: float | None
    y: float | None
    heading: float | None = None
    tolerance: float = 0.25

    @property
    def is_sound(self) -> bool:
        """Whether all values are finite numbers and the tolerance is above 0."""
        numbers = [self.x, self.y, self.tolerance, 0.0 if self.heading is None else self.heading]
        sound = (isinstance(n, int | float) and not isinstance(n, bool) and isfinite(n) for n in numbers)
        return all(sound) and self.tolerance > 0.0


@dataclass(frozen=True, slots=True)
class LogMessage(Data):
    """Something that a person may want to know. level: `info`, `warning` or `error`."""

    stamp: float
    component: str
    mission: str
    level: str
    what: str


@dataclass(frozen=True, slots=True)
class WorldCoord(Data):
    """Where the reactive components are to bring the robot.

    order: rising; whoever has a higher one knows that this is old. aim: `go` there, `back` there with the rear ahead,
    `turn` towards `heading`, or `rest`, when nobody is to move it. speed: at most. is_last: it is to stop there, not
    to pass. then: x and y of where it will be sent next, if that is known.
    """

    stamp: float
    order: int
    aim: str
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    is_last: bool = True
    then: Place | None = None


# Readings.


@dataclass(frozen=True, slots=True)
class RobotOdometry(Data):
    """Pose and speed. jumps: counts how often the pose was set anew, and what was known of places is void."""

    bus_name: ClassVar[str] = "Odometry"
    stamp: float
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    jumps: int = 0


@dataclass(frozen=True, slots=True)
class SonarRead(Data):
    """All sonar discs at once, in the robot's frame.

    pose: of the robot, x, y and heading in odom. places_x, places_y, headings: of the discs. ranges: infinite where
    there was no echo.
    """

    arrays: ClassVar[frozenset[str]] = frozenset({"places_x", "places_y", "headings", "ranges"})

    stamp: float
    pose: tuple[float, float, float]
    places_x: Floats
    places_y: Floats
    headings: Floats
    ranges: Floats


@dataclass(frozen=True, slots=True)
class LaserRead(Data):
    """One scan.

    pose: of the robot in odom when the scan was made. mount: of the scanner on the robot, x, y and heading. ranges: at
    `angle_min + i * angle_increment` about the scanner, infinite where nothing was hit within `range_max`.
    """

    arrays: ClassVar[frozenset[str]] = frozenset({"ranges"})

    stamp: float
    pose: tuple[float, float, float]
    mount: tuple[float, float, float]
    angle_min: float
    angle_increment: float
    range_max: float
    ranges: Floats

    @property
    def is_hit(self) -> NDArray[np.bool_]:
        """Which beams hit something. Some scanners give their maximum range where there was no echo."""
        return np.asarray(self.ranges < self.range_max)


# What is seen in them.


@dataclass(frozen=True, slots=True)
class Door(Data):
    """A door-like exit: a place where one can leave.

    x, y: its centre. width. normal: where one looks who goes through it, away from where it was seen. confidence: 0 to
    1.
    """

    x: float
    y: float
    width: float
    normal: float
    confidence: float


@dataclass(frozen=True, slots=True)
class DLEData(Data):
    """The door-like exits of one scan, the nearest first."""

    parts: ClassVar[Mapping[str, type[Data]]] = {"doors": Door}

    stamp: float
    pose: tuple[float, float, float]
    doors: tuple[Door, ...]


@dataclass(frozen=True, slots=True)
class ObstRead(Data):
    """What is in the way, and what is free, as far as the sensors see now.

    nearest: distance from the robot's outline, None where nothing is near. bearing: of it, in the robot's frame.
    origin_x, origin_y: of each ray, in odom; end_x, end_y: how far it is known to be free. hits: 1 where an obstacle
    is at its end, 0 where the ray only ends. is_dead_end: one cannot go on towards where it goes. people_x, people_y:
    places in odom about whoever walked and stands now, where the rest of them is whose legs are seen.
    """

    arrays: ClassVar[frozenset[str]] = frozenset(
        {"origin_x", "origin_y", "end_x", "end_y", "hits", "people_x", "people_y"}
    )

    stamp: float
    pose: tuple[float, float, float]
    nearest: float | None
    bearing: float
    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    hits: Floats
    is_dead_end: bool
    people_x: Floats = field(default_factory=lambda: np.empty(0))
    people_y: Floats = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class MotionCmd(Data):
    """How a component wants the robot to move.

    stamp: of the reading from which it follows; the fuser uses it so long as its age limit says. source: who wants it.
    weight: beside what others want; at zero it wants nothing. limit: the fastest forward that it allows, whatever
    others want. back, left, right: likewise backward, and the fastest turns to either side; all 0 and above.
    """

    stamp: float
    source: str
    linear: float
    angular: float
    weight: float
    limit: float | None = None
    back: float | None = None
    left: float | None = None
    right: float | None = None

    @property
    def is_sound(self) -> bool:
        """Whether stamp and speeds are finite numbers; limits and weights are checked by the fuser."""
        numbers = (self.stamp, self.linear, self.angular)
        return all(isinstance(number, int | float) and isfinite(number) for number in numbers)

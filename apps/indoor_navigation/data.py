"""Data that the components of the navigation exchange.

Lengths in m, angles in rad, counter-clockwise, speeds in m/s and rad/s, stamps in s since 1970. Unless said otherwise,
places are in the robot's `odom` frame. Its origin is where the robot stood when its gateway first connected, and its x
axis points to where the robot faced then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from math import isfinite
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from bus import MessageError

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.intp]
Place = tuple[float, float]
Pose = tuple[float, float, float]  # x, y, heading

DIGITS = 3  # decimal places of lengths on the bus, in m; the sensors have no finer resolution
LEAST_TOLERANCE = 0.1  # m; plans end up to 0.075 m from a goal, and robots stop about there


@dataclass(frozen=True, slots=True)
class Data:
    """Base class of the data. On the bus it is a JSON object of its fields; arrays are lists, null is infinity."""

    bus_name: ClassVar[str]  # in keys and wiring files
    arrays: ClassVar[frozenset[str]] = frozenset()
    parts: ClassVar[Mapping[str, type["Data"]]] = {}  # fields that are tuples of other data

    def __init_subclass__(cls) -> None:
        if "bus_name" not in vars(cls):
            cls.bus_name = cls.__name__

    def to_json(self) -> dict[str, Any]:
        """Return the JSON object for the bus."""
        told: dict[str, Any] = {}
        for name in _names(type(self)):  # type: ignore[arg-type]  # mypy takes the hash of instances for that of the class
            value = getattr(self, name)
            if name in self.arrays:
                told[name] = _listed(value)
            elif name in self.parts:
                told[name] = [part.to_json() for part in value]
            else:
                told[name] = value
        return told

    @classmethod
    def from_json(cls, told: Mapping[str, Any]) -> Self:
        """Build from a JSON object.

        Raises:
            MessageError: The object is not of this kind.
        """
        arrays, parts = cls.arrays, cls.parts
        try:
            if not arrays and not parts and list not in map(type, told.values()):
                return cls(**told)  # the usual case: commands, the most frequent data
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
            raise MessageError(f"this is not a valid {cls.bus_name}: {err}") from err


@cache
def _names(kind: type[Data]) -> tuple[str, ...]:
    """Return the names of the fields."""
    return tuple(each.name for each in fields(kind))


def _listed(values: Floats) -> list[Any]:
    rounded = np.round(values, DIGITS)
    listed: list[Any] = rounded.tolist()
    if np.isfinite(rounded).all():
        return listed
    return [value if isfinite(value) else None for value in listed]


def _array(values: list[Any]) -> Floats:
    array = np.array(values, dtype=np.float64)
    array[np.isnan(array)] = np.inf
    return array


# Missions.


@dataclass(frozen=True, slots=True)
class GoalPoint(Data):
    """The goal of a mission.

    mission: its name. heading: at the end; None for any. tolerance: distance that counts as reached, at least
    `LEAST_TOLERANCE`. frame: `odom`, or `map` for a place of the map on which the robot is localized. A goal without a
    place cancels the mission, and the robot stops.
    """

    mission: str
    x: float | None
    y: float | None
    heading: float | None = None
    tolerance: float = 0.25
    frame: str = "odom"

    @property
    def is_sound(self) -> bool:
        """Whether all values are finite numbers, the tolerance is not too small, and the frame is known."""
        numbers = [self.x, self.y, self.tolerance, 0.0 if self.heading is None else self.heading]
        sound = (isinstance(n, int | float) and not isinstance(n, bool) and isfinite(n) for n in numbers)
        return all(sound) and self.tolerance >= LEAST_TOLERANCE and self.frame in ("odom", "map")


@dataclass(frozen=True, slots=True)
class LogMessage(Data):
    """A message for people. level: `info`, `warning` or `error`."""

    stamp: float
    component: str
    mission: str
    level: str
    what: str


@dataclass(frozen=True, slots=True)
class WayRequest(Data):
    """The robot asks whoever is in its way to let it pass; the base makes it a sound."""

    stamp: float
    mission: str

    @property
    def is_sound(self) -> bool:
        """Whether the stamp is a finite number."""
        return isinstance(self.stamp, int | float) and isfinite(self.stamp)


GO, BACK, TURN, REST = "go", "back", "turn", "rest"  # aims of a WorldCoord


@dataclass(frozen=True, slots=True)
class WorldCoord(Data):
    """A target of the reactive components.

    order: rising number; a component ignores a target with a lower order than its last. aim: `go` to the place, go
    `back` to it with the rear ahead, `turn` to `heading`, or `rest`. speed: upper limit. is_last: the robot stops at
    the place; otherwise it passes. path: x and y of places on the way to it in turn, from one near the robot on; empty
    for a straight way. barred: x and y of places near it that the robot must not touch, although no sensor shows them.
    """

    stamp: float
    order: int
    aim: str
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    is_last: bool = True
    path: tuple[float, ...] = ()
    barred: tuple[float, ...] = ()


# Readings.


@dataclass(frozen=True, slots=True)
class RobotOdometry(Data):
    """Pose and speed. jumps: how often odom was set anew; after a jump all earlier places are invalid."""

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
    """The ranges of all sonar discs, in the robot's frame.

    pose: of the robot, x, y and heading in odom. places_x, places_y, headings: of the discs. ranges: infinite where
    there was no echo.
    """

    arrays: ClassVar[frozenset[str]] = frozenset({"places_x", "places_y", "headings", "ranges"})

    stamp: float
    pose: Pose
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
    pose: Pose
    mount: Pose
    angle_min: float
    angle_increment: float
    range_max: float
    ranges: Floats

    @property
    def is_hit(self) -> Bools:
        """Which beams hit something. Some scanners give their maximum range where there was no echo."""
        return np.asarray(self.ranges < self.range_max)


# Results of perception.


@dataclass(frozen=True, slots=True)
class Door(Data):
    """A door-like exit.

    x, y: its centre. width. normal: direction through it, away from the scanner. confidence: 0 to 1.
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
    pose: Pose
    doors: tuple[Door, ...]


@dataclass(frozen=True, slots=True)
class PlannedWay(Data):
    """The plan of a mission as people see it; no component needs it.

    route: x and y of places in turn, from the robot to the goal; empty where there is no way, or no mission is active.
    doors: all that are known, also those that are not believed yet.
    """

    parts: ClassVar[Mapping[str, type[Data]]] = {"doors": Door}

    stamp: float
    mission: str
    route: tuple[float, ...]
    doors: tuple[Door, ...]


@dataclass(frozen=True, slots=True)
class ObstRead(Data):
    """Obstacles and free space that the sensors show now.

    nearest: distance of the nearest obstacle from the robot's outline; None where none is near. bearing: of it, in the
    robot's frame. origin_x, origin_y: of each ray, in odom. end_x, end_y: the end of its free part. hits: 1 where an
    obstacle is at the end, 0 where there is none. is_dead_end: no lane leads on ahead. body_x, body_y, body_radius:
    discs in odom that may be people, until they are seen to be something else. body_moved: 1 for those that moved
    lately.
    """

    arrays: ClassVar[frozenset[str]] = frozenset(
        {"origin_x", "origin_y", "end_x", "end_y", "hits", "body_x", "body_y", "body_radius", "body_moved"}
    )

    stamp: float
    pose: Pose
    nearest: float | None
    bearing: float
    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    hits: Floats
    is_dead_end: bool
    body_x: Floats = field(default_factory=lambda: np.empty(0))
    body_y: Floats = field(default_factory=lambda: np.empty(0))
    body_radius: Floats = field(default_factory=lambda: np.empty(0))
    body_moved: Floats = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class MotionCmd(Data):
    """A motion command of one component.

    stamp: of the reading that the command results from; the fuser ignores commands above an age. source: the component.
    weight: in the mean of all commands; 0 leaves the speeds out. limit: maximum forward speed for all components.
    back, left, right: likewise backward, and for turns to either side; all 0 or above.
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

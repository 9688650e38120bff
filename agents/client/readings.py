"""Readings of elements in metres, seconds and radians; x forward, y left, angles counter-clockwise.

A distance without an echo is infinite, so `nearest < 0.5` needs no special case; any other unknown number is NaN. Every
reading has `stamp`, s since 1970 on the clock of the robot's gateway.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, Self

from agents.client.errors import RobotError
from agents.platform.errors import in_words
from geometry import Pose2D, wrap_angle

ROUNDING = 1e-6  # rad; a disc at the very edge of a sector counts


def _metres(value: Any) -> float:
    return math.inf if value is None else float(value)


def _ring(value: Any) -> dict[int, float]:
    return {int(number): _metres(distance) for number, distance in value.items()}


def _row(value: Any) -> tuple[float, ...]:
    return tuple(_metres(distance) for distance in value)


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def _numbers(value: Any) -> tuple[float, ...]:
    return tuple(map(_number, value))


def _by_number(value: Any) -> dict[int, float]:
    return {int(name): _number(number) for name, number in value.items()}


# How a field is read that is not taken as it is.
METRES, RING, ROW, TUPLE = ({"reader": each} for each in (_metres, _ring, _row, tuple))
NUMBER, NUMBERS, BY_NUMBER = ({"reader": each} for each in (_number, _numbers, _by_number))


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """The latest reading of an element. stamp: its time, s since 1970."""

    stamp: float

    @classmethod
    def of(cls, result: Mapping[str, Any], said_by: object) -> Self:
        """Read a result; other fields are left out.

        Raises:
            RobotError: It cannot be read.
        """
        given: dict[str, Any] = {}
        try:
            for each in fields(cls):
                if each.metadata.get("described"):
                    continue
                if each.name in result or each.default is MISSING:
                    reader: Callable[[Any], Any] = each.metadata.get("reader", lambda value: value)
                    given[each.name] = reader(result[each.name])
            return cls(**given)
        except (KeyError, TypeError, ValueError, AttributeError) as err:
            raise RobotError(f"what {said_by} says cannot be read: {in_words(err)}") from err


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseReading(Reading):
    """The pose by odometry in the robot's frame `odom`, and the speed."""

    x: float = field(metadata=NUMBER)
    y: float = field(metadata=NUMBER)
    heading: float = field(metadata=NUMBER)
    linear: float = field(metadata=NUMBER)
    angular: float = field(metadata=NUMBER)

    @property
    def pose(self) -> Pose2D:
        """Position and heading."""
        return Pose2D(self.x, self.y, self.heading)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangesReading(Reading):
    """Ranges of sonar discs or infrared sensors. ranges: by the sensor's number, from 0."""

    ranges: dict[int, float] = field(metadata=RING)
    nearest: float = field(metadata=METRES)


@dataclass(frozen=True, slots=True, kw_only=True)
class SonarDiscPose:
    """One sonar disc, by the robot's description.

    frame: in which the bus publishes its range, `happy/sonar_3`. x, y: m in base_link. heading: where it points, rad in
    base_link. field_of_view: of its cone, rad.
    """

    number: int
    frame: str
    x: float
    y: float
    heading: float
    field_of_view: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SonarReading(RangesReading):
    """Ranges of the sonar discs, `{3: 1.2}`.

    bearing: of the nearest, from straight ahead, rad; NaN when nothing is near. discs: the discs by number, from the
    robot's description.
    """

    bearing: float = field(metadata=NUMBER)
    discs: Mapping[int, SonarDiscPose] = field(default_factory=dict, repr=False, metadata={"described": True})

    def within(self, angle: float, width: float) -> float:
        """Return the nearest echo in a sector: `within(0.0, 0.6)` is ahead, `within(pi / 2, 0.6)` is to the left.

        Args:
            angle: Where the middle of the sector points, rad in base_link.
            width: Of the whole sector, rad, more than 0.
        Returns:
            m; infinite when no disc whose cone reaches into the sector has an echo.
        Raises:
            RobotError: The width is not positive, or no disc points there: nothing would be known of obstacles.
        """
        if not (math.isfinite(angle) and width > 0.0):
            given = f"within({angle!r}, {width!r})"
            raise RobotError(
                f"the sonar's within takes an angle and a width above 0, rad, not {given}; try within(0, 0.6)"
            )
        discs = self.discs.values()
        reach = width / 2 + ROUNDING
        there = [each for each in discs if abs(wrap_angle(each.heading - angle)) <= reach + each.field_of_view / 2]
        if not there:
            headings = ", ".join(f"{heading:.3g}" for heading in sorted({each.heading for each in discs}))
            where = f"within {width / 2:.3g} rad of {angle:.3g} rad"
            raise RobotError(f"no sonar disc points {where}; discs point to {headings or 'no known heading'} rad")
        return min(self.ranges.get(each.number, math.inf) for each in there)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaserReading(Reading):
    """One sweep of the laser. ranges: from the right to the left, `angle_increment` apart."""

    angle_min: float = field(metadata=NUMBER)
    angle_increment: float = field(metadata=NUMBER)
    ranges: tuple[float, ...] = field(metadata=ROW)
    nearest: float = field(metadata=METRES)
    bearing: float = field(metadata=NUMBER)

    def within(self, left: float, right: float) -> float:
        """The nearest thing between two bearings: `within(0.3, -0.3)` is ahead; infinite when nothing is there."""
        bearings = (self.angle_min + number * self.angle_increment for number in range(len(self.ranges)))
        seen = zip(bearings, self.ranges, strict=True)
        return min((distance for bearing, distance in seen if right <= bearing <= left), default=math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class BumpersReading(Reading):
    """The bumpers. front, rear: one value for each segment. pressed: any of them."""

    front: tuple[bool, ...] = field(metadata=TUPLE)
    rear: tuple[bool, ...] = field(metadata=TUPLE)
    stall_left: bool
    stall_right: bool
    pressed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryReading(Reading):
    """voltage: V. fraction: how full, 0 to 1; None if the robot does not report it."""

    voltage: float = field(metadata=NUMBER)
    fraction: float | None
    charging: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class IoReading(Reading):
    """The user's inputs and outputs. analog_in: V."""

    digital_in: tuple[bool, ...] = field(metadata=TUPLE)
    digital_out: tuple[bool, ...] = field(metadata=TUPLE)
    analog_in: tuple[float, ...] = field(metadata=NUMBERS)


@dataclass(frozen=True, slots=True, kw_only=True)
class GripperReading(Reading):
    """The state of the gripper and its switches.

    paddles: `open`, `closed`, `moving` or `between`. lift: `up`, `down`, `moving` or `between`.
    outer_beam, inner_beam: an object is between the paddles. left_contact, right_contact: an object presses on one.
    holds: it holds an object.
    """

    paddles: str
    lift: str
    outer_beam: bool
    inner_beam: bool
    left_contact: bool
    right_contact: bool
    holds: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class PtzReading(Reading):
    """The direction of the camera. pan: to the left. tilt: up. zoom: magnification, 1 at the widest."""

    pan: float = field(metadata=NUMBER)
    tilt: float = field(metadata=NUMBER)
    zoom: float = field(metadata=NUMBER)
    moving: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmReading(Reading):
    """The positions of the arm. joints: by number, from 1 at the base, rad; a gripper's is the last, m."""

    joints: dict[int, float] = field(metadata=BY_NUMBER)
    powered: bool
    homed: bool
    moving: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraReading(Reading):
    """The pictures of the camera. width, height: pixels; None if they are not known. rate: pictures a second."""

    width: int | None
    height: int | None
    format: str
    frames: int
    rate: float = field(metadata=NUMBER)


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickReading(Reading):
    """The joystick on the robot. axes: -1 to 1."""

    axes: tuple[float, ...] = field(metadata=NUMBERS)
    buttons: tuple[int, ...] = field(metadata=TUPLE)


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherReading(Reading):
    """The reading of an element without a class of its own: `reading["voltage"]`."""

    result: dict[str, Any]

    @classmethod
    def of(cls, result: Mapping[str, Any], said_by: object) -> Self:
        """Return a result as it is."""
        return cls(stamp=float(result.get("stamp", math.nan)), result=dict(result))

    def __getitem__(self, name: str) -> Any:
        return self.result[name]

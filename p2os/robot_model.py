"""Robot models: body, scales and sensor poses, built from a parsed `configs/robots` table."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from math import radians
from typing import Any, NamedTuple

from p2os.fields import Scales
from p2os.firmware import FIRMWARES, Family, FlashDefaults

SMALLEST, LARGEST = 1e-4, 1e6
"""Bounds of what must be above zero, and of any number, in its unit: numbers beyond them are typing errors."""
MAX_NAME = 19
"""Characters in each of the three strings of a SYNC2 answer: two well-known drivers copy them into 20 bytes."""
MAX_BUMPERS = 7
"""Segments at either end: each has a bit in the SIP."""
SONAR_ARRAYS, SONAR_ARRAY_SIZE = 4, 8
"""Sonar arrays of a controller, and the numbers in each."""
ACTIVE_LOW = 1
"""Kind of an infrared sensor whose bit is 0 while it sees something; with others it is 1."""


class SonarDisc(NamedTuple):
    """One sonar disc: number as in the SIP, position (m) and heading (rad) in `base_link`."""

    number: int
    x: float
    y: float
    heading: float

    @property
    def array(self) -> int:
        """The firing group, 1 to 4: eight numbers each."""
        return self.number // SONAR_ARRAY_SIZE + 1


class InfraredSensor(NamedTuple):
    """One infrared sensor: position in `base_link`, m; persistence: cycles that a reading stays valid."""

    number: int
    kind: int
    persistence: int
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class LaserMount:
    """Pose of a laser, m and rad in `base_link`. ignore: bearings that see the robot itself, (from, to) in rad."""

    kind: str
    x: float
    y: float
    heading: float = 0.0
    flipped: bool = False
    autoconnect: bool = False
    power_controlled: bool = True
    ignore: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class RobotModel:
    """Properties of a robot model; SI.

    name: the subtype that the robot answers. full_name: what people call it, `Pioneer 3-DX`.
    wheel_track: effective, as turning implies it (2 / DiffConvFactor).
    vel2_unit: m/s per count of a VEL2 wheel speed. ticks_per_metre: of the encoders. scales: of the wire.
    front_bumpers, rear_bumpers: segments fitted, 0 for none. sonar: discs that exist, rising numbers.
    request_io_packets: clients ask for IOpac by themselves. flash: what the controller starts from.
    power_ports: SETPBIOPORT switches power outputs. parts: accessory to the variant that goes onto this robot.
    height: of a robot that is much higher than its hull, 0 for the others.
    """

    name: str
    robot_class: str
    firmware: Family
    battery_nominal: float
    mass: float
    radius: float
    width: float
    length: float
    length_front: float
    length_rear: float
    max_velocity: float
    max_rotation: float
    wheel_track: float
    wheel_diameter: float
    ticks_per_metre: float
    vel2_unit: float
    scales: Scales
    front_bumpers: int
    rear_bumpers: int
    sonar: tuple[SonarDisc, ...]
    request_io_packets: bool
    table_sensing_ir: bool
    new_table_sensing_ir: bool
    irs: tuple[InfraredSensor, ...]
    lasers: tuple[LaserMount, ...]
    flash: FlashDefaults
    full_name: str = ""
    power_ports: bool = False
    parts: Mapping[str, str] = field(default_factory=dict, hash=False)
    height: float = 0.0

    @property
    def laser(self) -> LaserMount:
        """Mount of the laser; over the middle of the axle where the model has none."""
        return self.lasers[0] if self.lasers else LaserMount("lms2xx", 0.0, 0.0)

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "RobotModel":
        """Build a model from the table of a `configs/robots` file.

        Raises:
            ValueError: A key is missing, unknown or of the wrong type; the message names it and the nearest known key.
            ValueError: A value is one that no robot has; the message names it and its key.
        """
        row = _Table(table, "")
        firmware = row.choice("firmware", Family)
        model = cls(
            name=row.identity("name"),
            robot_class=row.identity("robot_class"),
            firmware=firmware,
            battery_nominal=row.number("battery_nominal_v", SMALLEST),
            mass=row.number("mass_kg", SMALLEST),
            radius=row.number("radius_m", SMALLEST),
            width=row.number("width_m", SMALLEST),
            length=row.number("length_m", SMALLEST),
            length_front=row.number("length_front_m", SMALLEST),
            length_rear=row.number("length_rear_m", SMALLEST),
            max_velocity=row.number("max_velocity_m_s", SMALLEST),
            max_rotation=radians(row.number("max_rotation_deg_s", SMALLEST)),
            wheel_track=row.number("wheel_track_m", SMALLEST),
            wheel_diameter=row.number("wheel_diameter_m", SMALLEST),
            ticks_per_metre=row.number("ticks_per_m", SMALLEST),
            vel2_unit=row.number("vel2_m_s_per_count", SMALLEST),
            scales=Scales(
                distance=row.number("distance_m_per_count", SMALLEST),
                velocity=row.number("velocity_m_s_per_count", SMALLEST),
                range=row.number("range_m_per_count", SMALLEST),
            ),
            front_bumpers=row.bumpers("front_bumpers"),
            rear_bumpers=row.bumpers("rear_bumpers"),
            sonar=_sonar(row),
            request_io_packets=row.flag("request_io_packets"),
            table_sensing_ir=row.flag("table_sensing_ir"),
            new_table_sensing_ir=row.flag("new_table_sensing_ir"),
            irs=tuple(
                InfraredSensor(int(n), int(kind), int(cycles), x, y) for n, kind, cycles, x, y in row.rows("ir", 5)
            ),
            lasers=tuple(_laser(each) for each in row.tables("laser")),
            flash=_flash(FIRMWARES[firmware].flash, row.table("flash")),
            full_name=row.text("full_name") if row.has("full_name") else row.text("name"),
            power_ports=row.flag("power_ports") if row.has("power_ports") else False,
            parts=row.table("parts").texts(),
            height=row.number("height_m", 0.0) if row.has("height_m") else 0.0,
        )
        row.finish()
        return model


def _sonar(row: "_Table") -> tuple[SonarDisc, ...]:
    discs: dict[float, SonarDisc] = {}
    for number, x, y, heading in row.rows("sonar", 4):
        if number not in range(SONAR_ARRAYS * SONAR_ARRAY_SIZE):
            raise ValueError(f"sonar numbers must be from 0 to {SONAR_ARRAYS * SONAR_ARRAY_SIZE - 1}, not {number:g}")
        if number in discs:
            raise ValueError(f"sonar has the number {number:g} twice; give each disc a number of its own")
        discs[number] = SonarDisc(int(number), x, y, radians(heading))
    return tuple(discs.values())


def _laser(row: "_Table") -> LaserMount:
    mount = LaserMount(
        kind=row.text("kind"),
        x=row.number("x_m"),
        y=row.number("y_m"),
        heading=radians(row.number("heading_deg")),
        flipped=row.flag("flipped"),
        autoconnect=row.flag("autoconnect"),
        power_controlled=row.flag("power_controlled"),
        ignore=tuple((radians(low), radians(high)) for low, high in row.rows("ignore_deg", 2)),
    )
    row.finish()
    return mount


FLASH_UNITS = {
    "sip_cycle": "_s",
    "sonar_cycle": "_s",
    "watchdog": "_s",
    "acceleration": "_m_s2",
    "deceleration": "_m_s2",
    "rotational_acceleration": "_deg_s2",
    "rotational_deceleration": "_deg_s2",
    "acceleration_top": "_m_s2",
    "rotational_acceleration_top": "_deg_s2",
    "joystick_velocity": "_m_s",
    "joystick_rotation": "_deg_s",
    "stall_count": "_s",
    "stall_integration": "_s",
    "stall_below": "_m_s",
    "kinematics_delay": "_s",
}
"""Unit suffix of each key of the `[flash]` table; what is not here has none."""


def _flash(defaults: FlashDefaults, row: "_Table") -> FlashDefaults:
    changes: dict[str, Any] = {}
    for each in fields(FlashDefaults):
        suffix = FLASH_UNITS.get(each.name, "")
        key = each.name + suffix
        if not row.has(key):
            continue
        default = getattr(defaults, each.name)
        if isinstance(default, bool):
            changes[each.name] = row.flag(key)
        elif isinstance(default, int):
            changes[each.name] = row.integer(key)
        else:
            changes[each.name] = radians(row.number(key)) if suffix.startswith("_deg") else row.number(key)
    row.finish()
    return replace(defaults, **changes)


class _Table:
    """A TOML table that is read key by key and reports unread keys."""

    def __init__(self, table: Mapping[str, Any], path: str) -> None:
        self._table = table
        self._path = path
        self._known: list[str] = []

    def has(self, key: str) -> bool:
        self._known.append(key)
        return key in self._table

    def text(self, key: str) -> str:
        return str(self._get(key, str, "text"))

    def texts(self) -> dict[str, str]:
        """Read every key as a text."""
        return {key: self.text(key) for key in self._table}

    def identity(self, key: str) -> str:
        """Read a text that the robot answers to SYNC2."""
        text = self.text(key)
        if not 1 <= len(text) <= MAX_NAME or "\0" in text:
            raise ValueError(f"{self._path}{key} must have 1 to {MAX_NAME} characters, none of them NUL, not {text!r}")
        return text

    def number(self, key: str, least: float = -LARGEST) -> float:
        value = self._get(key, (int, float), "a number")
        if not least <= value <= LARGEST:
            raise ValueError(f"{self._path}{key} must be a number from {least:g} to {LARGEST:g}, not {value}")
        return float(value)

    def integer(self, key: str) -> int:
        return int(self._get(key, int, "a whole number"))

    def bumpers(self, key: str) -> int:
        """Read a number of bumper segments."""
        count = self.integer(key)
        if not 0 <= count <= MAX_BUMPERS:
            raise ValueError(f"{self._path}{key} must be from 0 to {MAX_BUMPERS}, not {count}")
        return count

    def flag(self, key: str) -> bool:
        return bool(self._get(key, bool, "true or false"))

    def choice(self, key: str, kind: type[Family]) -> Family:
        text = self.text(key)
        try:
            return kind(text)
        except ValueError as err:
            raise ValueError(f"{self._path}{key} must be one of {', '.join(kind)}, not {text!r}") from err

    def rows(self, key: str, width: int) -> list[Sequence[float]]:
        rows: list[Sequence[float]] = self._get(key, list, "a list of rows")
        for row in rows:
            if not isinstance(row, list) or len(row) != width or not all(_is_number(each) for each in row):
                raise ValueError(f"{self._path}{key} must hold rows of {width} numbers, not {row!r}")
        return rows

    def table(self, key: str) -> "_Table":
        table = self._get(key, Mapping, "a table") if self.has(key) else {}
        return _Table(table, f"{self._path}{key}.")

    def tables(self, key: str) -> list["_Table"]:
        tables = self._get(key, list, "a list of tables") if self.has(key) else []
        if not all(isinstance(each, Mapping) for each in tables):
            raise ValueError(f"{self._path}{key} must be a list of tables, not {tables!r}")
        return [_Table(each, f"{self._path}{key}.") for each in tables]

    def finish(self) -> None:
        for key in self._table:
            if key not in self._known:
                nearest = difflib.get_close_matches(key, self._known, 1, 0)
                raise ValueError(f"unknown key {self._path}{key}; did you mean {self._path}{nearest[0]}?")

    def _get(self, key: str, kind: Any, expected: str) -> Any:
        self._known.append(key)
        if key not in self._table:
            written = difflib.get_close_matches(key, [each for each in self._table if each not in self._known], 1, 0.8)
            hint = f"; did you misspell it as {self._path}{written[0]}?" if written else ""
            raise ValueError(f"key {self._path}{key} is missing, it must be {expected}{hint}")
        value = self._table[key]
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise ValueError(f"{self._path}{key} must be {expected}, not {value!r}")
        return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def check_model(model: object) -> None:
    """Check the type of an argument that is a robot model.

    Raises:
        TypeError: It is of another type, such as the name of a model.
    """
    if not isinstance(model, RobotModel):
        hint = f"configs.load(RobotModel, 'robots', {model!r})" if isinstance(model, str) else "a RobotModel"
        raise TypeError(f"model must be a RobotModel, not {model!r}; give {hint}")

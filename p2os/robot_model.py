"""Robot models: body, scales and sensor poses, built from a parsed `configs/robots` table."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from math import radians
from typing import Any, NamedTuple

from p2os.fields import Scales
from p2os.firmware import FIRMWARES, Family, FlashDefaults

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
        """
        row = _Table(table, "")
        firmware = row.choice("firmware", Family)
        model = cls(
            name=row.text("name"),
            robot_class=row.text("robot_class"),
            firmware=firmware,
            battery_nominal=row.number("battery_nominal_v"),
            mass=row.number("mass_kg"),
            radius=row.number("radius_m"),
            width=row.number("width_m"),
            length=row.number("length_m"),
            length_front=row.number("length_front_m"),
            length_rear=row.number("length_rear_m"),
            max_velocity=row.number("max_velocity_m_s"),
            max_rotation=radians(row.number("max_rotation_deg_s")),
            wheel_track=row.number("wheel_track_m"),
            wheel_diameter=row.number("wheel_diameter_m"),
            ticks_per_metre=row.number("ticks_per_m"),
            vel2_unit=row.number("vel2_m_s_per_count"),
            scales=Scales(
                distance=row.number("distance_m_per_count"),
                velocity=row.number("velocity_m_s_per_count"),
                range=row.number("range_m_per_count"),
            ),
            front_bumpers=row.integer("front_bumpers"),
            rear_bumpers=row.integer("rear_bumpers"),
            sonar=tuple(SonarDisc(int(n), x, y, radians(heading)) for n, x, y, heading in row.rows("sonar", 4)),
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
            height=row.number("height_m") if row.has("height_m") else 0.0,
        )
        row.finish()
        return model


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

    def number(self, key: str) -> float:
        return float(self._get(key, (int, float), "a number"))

    def integer(self, key: str) -> int:
        return int(self._get(key, int, "a whole number"))

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
    return isinstance(value, int | float) and not isinstance(value, bool)


def check_model(model: object) -> None:
    """Check the type of an argument that is a robot model.

    Raises:
        TypeError: It is of another type, such as the name of a model.
    """
    if not isinstance(model, RobotModel):
        hint = f"configs.load(RobotModel, 'robots', {model!r})" if isinstance(model, str) else "a RobotModel"
        raise TypeError(f"model must be a RobotModel, not {model!r}; give {hint}")

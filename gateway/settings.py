"""What a person can set for one gateway, in a TOML file given with `--config`."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from enum import StrEnum
from math import pi
from numbers import Real
from pathlib import Path

from configs import ConfigError, build, read
from configs.camera_calibration import CameraCalibration
from gateway.line import CABLE, RADIO, LineKind
from p2os import BAUD_CODES


@dataclass(frozen=True, slots=True)
class Calibration:
    """Corrections of this robot's odometry, as measured on the floor.

    distance: true distance over reported distance. heading: true turn over reported turn. gyro: true turn over the
    turn that an analog gyro's data sheet makes of its readings; as client libraries have it when left out.
    """

    distance: float = 1.0
    heading: float = 1.0
    gyro: float = 1.626

    def __post_init__(self) -> None:
        _check_above_zero("calibration", self, ("distance", "heading", "gyro"))


@dataclass(frozen=True, slots=True)
class OdometryErrors:
    """How fast the odometry's uncertainty grows; standard deviations.

    distance_per_m: m along the way, after each metre. heading_rad_per_m, heading_rad_per_rad: after each metre rolled
    and each radian turned.
    """

    distance_per_m: float = 0.02
    heading_rad_per_m: float = 0.02
    heading_rad_per_rad: float = 0.05

    def __post_init__(self) -> None:
        _check_above_zero("odometry_errors", self, ("distance_per_m", "heading_rad_per_m", "heading_rad_per_rad"))


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """How fast the robot moves, and how hard it speeds up and brakes.

    linear_m_s, angular_rad_s: no command exceeds them; below those of the model and of the robot's own configuration.
    The others are told to the robot when it is connected; left out, it keeps its own.
    """

    linear_m_s: float | None = None
    angular_rad_s: float | None = None
    acceleration_m_s2: float | None = None
    deceleration_m_s2: float | None = None
    angular_acceleration_rad_s2: float | None = None
    angular_deceleration_rad_s2: float | None = None

    def __post_init__(self) -> None:
        _check_above_zero("limits", self, [each.name for each in fields(self)])


class PtzChoice(StrEnum):
    """The camera head behind AUX1: any that answers, one that need not answer, or none."""

    AUTO = "auto"
    VCC4 = "vcc4"
    EVID30 = "evid30"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class Fitted:
    """What only a person knows of the robot.

    compass: false where asking for one is not wanted. joystick: there is one in the robot's socket; left out, there is
    one as soon as a hand moves it. lcd: it has a display, which never answers. ptz: its camera head; "vcc4" or "evid30"
    serves one that hears but cannot answer as well. simulated_laser: ask a simulator for the laser that it sends on the
    robot's own line; left out, robots that are known to be simulated are asked.
    """

    compass: bool = True
    joystick: bool | None = None
    lcd: bool = False
    ptz: PtzChoice = PtzChoice.AUTO
    simulated_laser: bool | None = None


class LaserUnit(StrEnum):
    """In what the laser measures; the finest reaches least far."""

    MILLIMETRE = "mm"
    CENTIMETRE = "cm"
    DECIMETRE = "10cm"


@dataclass(frozen=True, slots=True)
class LaserSettings:
    """How a laser on a cable of its own is to scan, and where it sits.

    baud: bit/s to bring it to; left out, 38400, or what it has where the port has no rate. angle_deg, resolution_deg:
    180 by 1 or 0.5, 100 by 1, 0.5 or 0.25. reflector_bits: how finely it tells how strongly reflectors shine, 1 to 3;
    each bit halves its reach. x_m, y_m, z_m, heading_deg, flipped: where it sits in `base_link`; as the robot's model
    has it when left out.
    """

    baud: int | None = None
    angle_deg: int = 180
    resolution_deg: float = 1.0
    unit: LaserUnit = LaserUnit.MILLIMETRE
    reflector_bits: int = 1
    x_m: float | None = None
    y_m: float | None = None
    z_m: float = 0.0
    heading_deg: float | None = None
    flipped: bool | None = None


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """What a camera does not report itself.

    field_of_view_rad: horizontal; without zoom. calibration: used in place of it, as `acromovi camera calibrate`
    measures it.
    """

    field_of_view_rad: float | None = None
    calibration: CameraCalibration | None = None

    def __post_init__(self) -> None:
        angle = self.field_of_view_rad
        if angle is not None and not (_is_number(angle) and 0.0 < angle < pi):
            raise ValueError(f"camera.field_of_view_rad must be between 0 and pi, not {angle}")


@dataclass(frozen=True, slots=True)
class Settings:
    """The file.

    model: take the robot for this one, whatever it says. enable_motors: switch the motors on after connecting. sonar:
    switch the sonar on or off after connecting; None, which no file can say, leaves it. encoders: ask for encoder
    packets. inputs_outputs: ask for I/O packets; as the model has it when left out. emulated: the robot is not real;
    unknown when left out, which all treat as real. radio: the robot is behind a radio modem, as `--radio` says.
    use_gyro: take the odometry's turns from the gyro, where the robot sends its readings, while the wheels turn.
    raise_baud_to: bit/s that the robot is told to talk at once it is connected, if it talks slower; left out, its rate
    stays as it is. It is never raised behind a radio modem. unbound_motion_s: longest expected duration of a motion
    whose command names no heartbeat, and which therefore does not stop when its commander dies.
    """

    model: str | None = None
    enable_motors: bool = True
    sonar: bool | None = True
    encoders: bool = False
    inputs_outputs: bool | None = None
    emulated: bool | None = None
    radio: bool = False
    use_gyro: bool = False
    raise_baud_to: int | None = None
    unbound_motion_s: float = 5.0
    calibration: Calibration = field(default_factory=Calibration)
    odometry_errors: OdometryErrors = field(default_factory=OdometryErrors)
    limits: DriveLimits = field(default_factory=DriveLimits)
    fitted: Fitted = field(default_factory=Fitted)
    camera: CameraSettings = field(default_factory=CameraSettings)
    laser: LaserSettings = field(default_factory=LaserSettings)

    def __post_init__(self) -> None:
        if not _is_number(self.unbound_motion_s) or not self.unbound_motion_s >= 0.0:
            raise ValueError(f"unbound_motion_s must be 0 s or more, not {self.unbound_motion_s}")
        rates = sorted(BAUD_CODES.values())
        if self.raise_baud_to is not None and self.raise_baud_to not in rates:
            raise ValueError(f"raise_baud_to must be one of {', '.join(map(str, rates))}, not {self.raise_baud_to}")

    @property
    def line(self) -> LineKind:
        """The kind of line that leads to the robot."""
        return RADIO if self.radio else CABLE


def load_settings(path: Path) -> Settings:
    """Read the file.

    Raises:
        ConfigError: It cannot be read, is not TOML, or holds an unknown key, a wrong type or a value that cannot be.
    """
    table = read(path)
    try:
        return build(Settings, table, str(path))
    except ConfigError:
        raise
    except ValueError as error:  # of a value that no type rules out
        raise ConfigError(f"{path}: {error}") from error


def _check_above_zero(table: str, values: object, keys: Iterable[str]) -> None:
    for key in keys:
        value: float | None = getattr(values, key)
        if value is not None and not (_is_number(value) and value > 0.0):
            raise ValueError(f"{table}.{key} must be above 0, not {value}")


def _is_number(value: object) -> bool:
    return isinstance(value, Real)

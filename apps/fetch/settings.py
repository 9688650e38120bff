"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import configs
from configs.loader import laid_over, read
from configs.settings import ShippedSettings

_COLOUR = re.compile(r"#([0-9a-fA-F]{2})([0-9a-fA-F]{2})([0-9a-fA-F]{2})")


@dataclass(frozen=True, slots=True)
class _FetchBody:
    """The robot and its hand."""

    radius_m: float
    half_width_m: float
    front_m: float
    grip_m: float
    opening_m: float
    lift_m: float
    sonar_m: float


@dataclass(frozen=True, slots=True)
class _FetchDrive:
    """How the robot moves."""

    speed_m_s: float
    turn_rad_s: float
    gain: float
    braking_m_s2: float
    creep_m_s: float
    back_m_s: float
    stuck_s: float


@dataclass(frozen=True, slots=True)
class FetchCamera:
    """Where the camera is, and what is made of its images."""

    forward_m: float
    height_m: float
    down_rad: float
    late_s: float
    silent_s: float
    hidden_m: float
    range_m: float
    smallest_px: float
    edge_px: float


@dataclass(frozen=True, slots=True)
class _ObjectSize:
    """What can be an object to fetch."""

    narrowest_m: float
    widest_m: float
    lowest_m: float
    highest_m: float
    slack_m: float
    slack_share: float
    place_m: float


@dataclass(frozen=True, slots=True)
class _TrackSettings:
    """How sightings become objects."""

    gate_m: float
    gate_share: float
    deviation_m: float
    deviation_1_m: float
    sightings: float
    misses: float
    sure_m: float


@dataclass(frozen=True, slots=True)
class _SearchPattern:
    """How an object is looked for."""

    turn_rad_s: float
    step_m: float
    give_up_s: float


@dataclass(frozen=True, slots=True)
class _GripSettings:
    """How an object is gripped."""

    standoff_m: float
    standoff_images: float
    facing_rad: float
    straight_m: float
    last_m_s: float
    beyond_m: float
    wait_s: float
    back_m: float


@dataclass(frozen=True, slots=True)
class _ArmSettings:
    """How an arm grips."""

    pitch_rad: float
    lowest_m: float
    overlap_m: float
    check_m: float
    stop_m: float
    step_m: float
    raise_m: float
    speed_rad_s: float


@dataclass(frozen=True, slots=True)
class _PlaceSettings:
    """How an object is put down."""

    standoff_m: float


@dataclass(frozen=True, slots=True)
class _FloorSettings:
    """Ways over the floor."""

    resolution_m: float
    echo_m: float
    half_width_m: float
    comfort_m: float
    gap_m: float
    horizon_s: float
    replan_s: float


@dataclass(frozen=True, slots=True)
class _NamedColours:
    """Colours in full light, as #rrggbb."""

    red: str
    green: str
    blue: str
    yellow: str


@dataclass(frozen=True, slots=True)
class FetchSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")
    OF_ARM = Path(__file__).with_name("arm.toml")

    period_s: float
    report_s: float
    attempts: int
    robot: _FetchBody
    drive: _FetchDrive
    camera: FetchCamera
    object: _ObjectSize
    track: _TrackSettings
    search: _SearchPattern
    grip: _GripSettings
    arm: _ArmSettings
    place: _PlaceSettings
    floor: _FloorSettings
    colours: _NamedColours

    @classmethod
    def load_for_arm(cls, file: str | Path | None = None) -> Self:
        """Return the settings of a PowerBot with an arm, with the changes of a file laid over them.

        Raises:
            ConfigError: As `load`.
        """
        changes = read(cls.OF_ARM)
        return cls.load(file, laid_over(changes, read(file)) if file else changes)

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        for name, text in asdict(self.colours).items():
            if not _COLOUR.fullmatch(text):
                raise configs.ConfigError(f"{source}: colours.{name} must be a colour such as #cc1f1f, not {text!r}")
        for name, value, most in (
            ("period_s", self.period_s, 0.5),
            ("object.widest_m", self.object.widest_m, self.robot.opening_m),
            ("drive.speed_m_s", self.drive.speed_m_s, 1.0),
        ):
            if value > most:
                raise configs.ConfigError(f"{source}: {name} must be at most {most:g}, not {value:g}")

    @property
    def shades(self) -> dict[str, tuple[int, int, int]]:
        """The named colours as red, green and blue, 0 to 255."""
        found = {name: _COLOUR.fullmatch(text) for name, text in asdict(self.colours).items()}
        return {name: (int(each[1], 16), int(each[2], 16), int(each[3], 16)) for name, each in found.items() if each}

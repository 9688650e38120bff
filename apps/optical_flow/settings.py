"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

import math
from dataclasses import dataclass
from pathlib import Path

import configs
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class _RobotSize:
    """The hull, and where the camera is."""

    front_m: float
    rear_m: float
    width_m: float
    camera_m: float

    @property
    def turning_m(self) -> float:
        """Radius of the circle about the axle that the hull needs to turn on the spot, m."""
        return math.hypot(max(self.front_m, self.rear_m), self.width_m / 2.0)


@dataclass(frozen=True, slots=True)
class _FlowDrive:
    """How the robot moves."""

    speed_m_s: float
    slow_m_s: float
    turn_rad_s: float
    steer_rad_s: float
    gain: float
    horizon_s: float
    side_gap_m: float
    front_gap_m: float
    unseen_gap_m: float
    look_m: float


@dataclass(frozen=True, slots=True)
class _SituationLimits:
    """From where on an obstacle makes a situation."""

    near_s: float
    front_s: float
    side_m: float
    corner_m: float
    hold_s: float


@dataclass(frozen=True, slots=True)
class _MemorySettings:
    """What is remembered of the surroundings."""

    range_m: float
    cell_m: float
    hit: float
    miss: float
    most: float
    most_free: float
    forget_s: float
    forget_rad: float
    obstacle: float
    free_share: float
    reflex_s: float
    reflex_columns: float
    reflex_m: float
    doubt: float
    settle_s: float
    least_m_s: float
    most_rad_s: float


@dataclass(frozen=True, slots=True)
class _CoverageSettings:
    """What a direction is worth."""

    directions: int
    unvisited: float
    turn_cost: float
    unknown_cost: float
    width_m: float
    fade_s: float


@dataclass(frozen=True, slots=True)
class _FlowSafety:
    """When the robot stops."""

    silent_s: float
    unseen_s: float
    check_s: float
    unknown_m: float
    back_m: float


@dataclass(frozen=True, slots=True)
class _FilmSettings:
    """Frames of the film."""

    rate: float
    longest_s: float


@dataclass(frozen=True, slots=True)
class FlowPageSettings:
    """The live page."""

    host: str
    rate: float
    watched_s: float
    wait_s: float
    old_s: float


@dataclass(frozen=True, slots=True)
class FlowSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    period_s: float
    report_s: float
    robot: _RobotSize
    drive: _FlowDrive
    situation: _SituationLimits
    memory: _MemorySettings
    coverage: _CoverageSettings
    safety: _FlowSafety
    film: _FilmSettings
    page: FlowPageSettings

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        for name, value, most in (
            ("period_s", self.period_s, 0.5),
            ("drive.speed_m_s", self.drive.speed_m_s, 1.0),
            ("drive.slow_m_s", self.drive.slow_m_s, self.drive.speed_m_s),
            ("memory.least_m_s", self.memory.least_m_s, self.drive.slow_m_s),
            ("memory.free_share", self.memory.free_share, 1.0),
            ("situation.near_s", self.situation.near_s, self.situation.front_s),
        ):
            if value > most:
                raise configs.ConfigError(f"{source}: {name} must be at most {most:g}, not {value:g}")

"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

from dataclasses import dataclass
from pathlib import Path

from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class StationSettings:
    """The station, and what a scan of it looks like."""

    ahead_m: float
    width_m: float
    tolerance_m: float
    search_m: float
    search_rad: float
    apart_m: float
    flat_m: float
    echoes: int
    sightings: int
    share: float


@dataclass(frozen=True, slots=True)
class ApproachSettings:
    """How the robot drives to the dock."""

    away_m: float
    off_m: float
    turned_rad: float
    speed_m_s: float
    turn_rad_s: float
    look_s: float
    ahead_m: float
    gain: float
    straight_m_s: float
    creep_m_s: float
    braking_m_s2: float


@dataclass(frozen=True, slots=True)
class DockSettings:
    """Where the robot has to stand in the end."""

    along_m: float
    across_m: float
    turned_rad: float


@dataclass(frozen=True, slots=True)
class ClearSettings:
    """Room that has to be free."""

    beside_m: float
    ahead_m: float
    station_m: float
    wait_s: float


@dataclass(frozen=True, slots=True)
class ChargeSettings:
    """Charging, and leaving the dock."""

    wait_s: float
    back_m_s: float
    leave_m: float


@dataclass(frozen=True, slots=True)
class DockingSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    period_s: float
    report_s: float
    attempts: int
    priority: int
    silent_s: float
    station: StationSettings
    approach: ApproachSettings
    dock: DockSettings
    clear: ClearSettings
    charge: ChargeSettings

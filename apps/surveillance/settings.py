"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from configs.loader import build
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class PatrolSettings:
    """Visits of rooms."""

    speed_m_s: float
    corner_s: float
    dwell_s: float
    reached_m: float
    attempts: int
    barred_s: float
    stuck_rooms: int


@dataclass(frozen=True, slots=True)
class AuctionSettings:
    """The contract net."""

    bids_s: float
    trade: float
    trades: int
    trade_s: float
    retry_s: float


@dataclass(frozen=True, slots=True)
class TeamTrustSettings:
    """When a robot is able to patrol."""

    deviation_m: float
    lost_s: float
    silent_s: float
    battery: float
    battery_again: float


@dataclass(frozen=True, slots=True)
class PlainDriveSettings:
    """Driving without the indoor navigation."""

    gap_m: float
    speed_m_s: float
    blocked_s: float


@dataclass(frozen=True, slots=True)
class ScanChangeSettings:
    """What of a laser scan the map does not explain."""

    range_m: float
    wall_m: float
    angle_rad: float
    turn_s: float
    gap_m: float
    echoes: int
    solid_m: float
    width_m: float
    doubt: float


@dataclass(frozen=True, slots=True)
class SonarChangeSettings:
    """What of the sonar's echoes the map does not explain."""

    range_m: float
    wall_m: float


@dataclass(frozen=True, slots=True)
class CameraChangeSettings:
    """What moves in the images of a standing robot."""

    area: float
    standing_s: float


@dataclass(frozen=True, slots=True)
class AlarmSettings:
    """When something unexplained is an intruder."""

    scans: int
    sonar_readings: int
    images: int
    confirm_s: float
    forget_s: float
    jump_m: float
    same_m: float
    same_s: float
    learn: bool
    still_m: float
    furniture_s: float


@dataclass(frozen=True, slots=True)
class MemberSettings:
    """Robots of the team, which are no intruders."""

    radius_m: float
    speed_m_s: float
    radius_most_m: float


@dataclass(frozen=True, slots=True)
class PursuitSettings:
    """Following an intruder."""

    distance_m: float
    replan_m: float
    lost_s: float
    longest_s: float


@dataclass(frozen=True, slots=True)
class SurveillanceSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    rooms: tuple[str, ...]
    patrol: PatrolSettings
    auction: AuctionSettings
    trust: TeamTrustSettings
    drive: PlainDriveSettings
    scan: ScanChangeSettings
    sonar: SonarChangeSettings
    camera: CameraChangeSettings
    alarm: AlarmSettings
    member: MemberSettings
    follow: PursuitSettings

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> "SurveillanceSettings":
        """Return settings that came in a message.

        Raises:
            ConfigError: They are not complete or not valid.
        """
        return build(cls, table, "the settings of the patrol")

    def to_table(self) -> dict[str, Any]:
        """Return them for a message."""
        return {**asdict(self), "rooms": list(self.rooms)}

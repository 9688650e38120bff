"""Settings of the application; `settings.toml` beside this module gives all of them with their units and meaning."""

from dataclasses import dataclass
from pathlib import Path

import configs
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class _DriveSettings:
    """How the follower drives."""

    gap: float
    nearest: float
    reach: float
    speed: float
    turn: float
    acceleration: float
    braking: float
    gap_gain: float
    aim: float
    least_aim: float
    resting: float
    starting: float
    face: float
    trail: float


@dataclass(frozen=True, slots=True)
class LeaderSettings:
    """What is known of the leader's motion, and how sightings of it are believed."""

    carried: float
    acceleration_deviation: float
    turn_acceleration_deviation: float
    first_speed_deviation: float
    first_turn_deviation: float
    position_deviation: float
    distance_deviation: float
    heading_deviation: float
    gate: float
    refusals: int
    apart: float


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """What is done when the leader is not seen."""

    coast: float
    sweep_after: float
    pan: float
    pan_speed: float
    pan_step: float
    pan_period: float
    pan_repeat: float
    pan_lead: float
    speed: float
    turn: float
    give_up: float


@dataclass(frozen=True, slots=True)
class RoomSettings:
    """The size of the follower, and its distances from obstacles."""

    half_width: float
    front: float
    margin: float
    tight: float
    leader_radius: float
    range: float


@dataclass(frozen=True, slots=True)
class _ViewSettings:
    """Where the camera is, and what is made of its pictures."""

    field_of_view: float
    head_silent: float
    forward: float
    moved: float


@dataclass(frozen=True, slots=True)
class FollowingSettings(ShippedSettings):
    """All of them; `settings.toml` has their units and meaning."""

    SHIPPED = Path(__file__).with_name("settings.toml")
    MAY_BE_ZERO = True

    period: float
    report: float
    silent: float

    drive: _DriveSettings
    leader: LeaderSettings
    search: SearchSettings
    room: RoomSettings
    camera: _ViewSettings

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        if self.period == 0.0:
            raise configs.ConfigError(f"{source}: period must be more than 0 s")
        if self.drive.gap <= self.drive.nearest:
            nearest, gap = self.drive.nearest, self.drive.gap
            raise configs.ConfigError(
                f"{source}: drive.gap must be more than drive.nearest, {nearest:g} m, not {gap:g}"
            )

"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

from dataclasses import dataclass
from pathlib import Path

import configs
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class MapSettings:
    """How often the map is drawn, and what is kept for it."""

    soonest_s: float
    wait_s: float
    cell_m: float
    most_cells: int
    look_s: float


@dataclass(frozen=True, slots=True)
class DriverLimits:
    """How fast robots are driven, and when they are not driven any more."""

    old_s: float
    silent_s: float
    release_s: float
    lease_s: float
    linear: float
    angular: float


@dataclass(frozen=True, slots=True)
class AccessSettings:
    """For how long somebody stays known."""

    session_s: float
    pause_s: float


@dataclass(frozen=True, slots=True)
class ConsoleSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    map: MapSettings
    drive: DriverLimits
    access: AccessSettings

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        drive = self.drive
        if not drive.silent_s < drive.release_s or drive.silent_s > 0.5:
            raise configs.ConfigError(
                f"{source}: drive.silent_s is {drive.silent_s:g} s; it must be at most 0.5 s, and below drive.release_s"
            )

"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

from dataclasses import dataclass
from pathlib import Path

import configs
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class ImageTimes:
    """How old and how large images may be."""

    old_s: float
    wait_s: float
    linger_s: float
    most_bytes: int


@dataclass(frozen=True, slots=True)
class ControlLimits:
    """How a head is steered, and when it is not steered any more."""

    silent_s: float
    release_s: float
    lease_s: float
    step: float
    zoom_step: float
    look_s: float


@dataclass(frozen=True, slots=True)
class RemoteVisionSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    images: ImageTimes
    control: ControlLimits

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        if self.control.zoom_step <= 1.0:
            raise configs.ConfigError(f"{source}: control.zoom_step must be more than 1")
        if self.control.release_s < self.control.silent_s or self.control.silent_s <= self.images.wait_s:
            raise configs.ConfigError(
                f"{source}: the times must ascend: images.wait_s, then control.silent_s, then control.release_s"
            )

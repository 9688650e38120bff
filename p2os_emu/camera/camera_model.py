"""What an emulated camera is, from `configs/accessories/camera.toml`."""

from dataclasses import dataclass
from math import radians


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Where it sits, what it sees without a head, and how its pictures are packed.

    forward_m: of the eye, ahead of the axle. height_m: above the floor. wide_deg: horizontal field of view.
    quality: of the JPEG, 1 to 95.
    """

    forward_m: float
    height_m: float
    wide_deg: float
    quality: int

    @property
    def field_of_view(self) -> float:
        """Horizontal, rad."""
        return radians(self.wide_deg)

"""The calibration of a camera as data."""

from dataclasses import asdict, dataclass
from math import isfinite

from configs.loader import ConfigError

_DISTORTION = ("k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True, slots=True)
class CameraCalibration:
    """A calibrated camera, at its widest zoom.

    width, height: of its images, px. fx, fy: focal lengths, cx, cy: principal point, px. distortion: k1, k2, p1, p2, k3
    of OpenCV and of ROS (`plumb_bob`). error_px: rms distance of the corners of the chessboard from the model.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    error_px: float = 0.0

    def __post_init__(self) -> None:
        for name in ("width", "height", "fx", "fy"):
            if not getattr(self, name) > 0:
                raise ConfigError(f"{name} of a camera's calibration must be above 0, not {getattr(self, name)}")
        if not all(map(isfinite, (self.fx, self.fy, self.cx, self.cy, *self.distortion))):
            raise ConfigError("the numbers of a camera's calibration must be finite")

    @property
    def model(self) -> dict[str, float]:
        """The fields of `vision.camera_model.PinholeModel`."""
        table = asdict(self)
        del table["error_px"]
        return table | dict(zip(_DISTORTION, table.pop("distortion"), strict=True))

    @property
    def toml(self) -> str:
        """An inline table."""
        table = asdict(self)
        table["distortion"] = list(self.distortion)
        return "{ " + ", ".join(f"{name} = {value!r}" for name, value in table.items()) + " }"

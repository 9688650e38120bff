"""Camera model: pinhole with lens distortion, from a field of view or from a calibration.

Pixels count right and down from the centre of the upper left one. A ray is a vector in the camera's frame with the axes
of a robot (REP 103): x forward along the optical axis, y left, z up.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from math import isfinite, pi, tan
from typing import Any, Self

import cv2
import numpy as np

from vision.image import Floats, VisionError


@dataclass(frozen=True, slots=True)
class PinholeModel:
    """Width and height in px, focal lengths and principal point in px, and distortion.

    k1, k2, k3: radial, p1, p2: tangential distortion, as in OpenCV and in ROS (`plumb_bob`).
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
                raise VisionError(f"{each.name} of a camera model must be a finite number, not {value!r}")
        if min(self.width, self.height, self.fx, self.fy) <= 0:
            raise VisionError("width, height and focal lengths of a camera model must be positive")

    @classmethod
    def from_field_of_view(cls, width: int, height: int, horizontal: float) -> Self:
        """Return the model of a camera without distortion and with square pixels.

        Args:
            width, height: px.
            horizontal: Angle of view from the left to the right edge, rad.
        Raises:
            VisionError: The angle is not between 0 and pi, or the size not positive.
        """
        if not 0.0 < horizontal < pi:
            raise VisionError(f"a field of view is between 0 and {pi:.4f} rad, not {horizontal:g}")
        focal = width / 2.0 / tan(horizontal / 2.0)
        return cls(width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the model that `to_dict` described.

        Raises:
            VisionError: A value is missing, unknown or no number.
        """
        try:
            return cls(**data)
        except TypeError:
            names = ", ".join(each.name for each in fields(cls))
            raise VisionError(f"a camera model has {names}, not {', '.join(map(str, data))}"[:300]) from None

    def to_dict(self) -> dict[str, float]:
        """Return the model as JSON-like data."""
        return asdict(self)

    def scaled(self, width: int, height: int) -> Self:
        """Return the model for the whole image at another size."""
        across, down = width / self.width, height / self.height
        return type(self)(
            width,
            height,
            self.fx * across,
            self.fy * down,
            (self.cx + 0.5) * across - 0.5,
            (self.cy + 0.5) * down - 0.5,
            *self.distortion.tolist(),
        )

    @property
    def matrix(self) -> Floats:
        """Camera matrix of OpenCV, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Floats:
        """k1, k2, p1, p2, k3: the order of OpenCV."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    def pixels_of(self, rays: Floats) -> Floats:
        """Return where rays meet the image, px, shape (n, 2); NaN for those that point backwards.

        Args:
            rays: Shape (n, 3), of any length.
        """
        rays = np.asarray(rays, np.float64)
        forward = np.where(rays[:, 0] > 1e-9, rays[:, 0], np.nan)
        x, y = -rays[:, 1] / forward, -rays[:, 2] / forward
        if self.distortion.any():
            square = x * x + y * y
            radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
            x, y = (
                x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x),
                y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y,
            )
        return np.stack((self.fx * x + self.cx, self.fy * y + self.cy), axis=1)

    def rays_of(self, pixels: Floats) -> Floats:
        """Return the rays through pixels, shape (n, 3), with x = 1.

        Args:
            pixels: Shape (n, 2).
        """
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        if self.distortion.any() and len(pixels):
            points = cv2.undistortPoints(pixels.reshape(-1, 1, 2), self.matrix, self.distortion)
            x, y = np.asarray(points, np.float64).reshape(-1, 2).T
        else:
            x, y = (pixels[:, 0] - self.cx) / self.fx, (pixels[:, 1] - self.cy) / self.fy
        return np.stack((np.ones_like(x), -x, -y), axis=1)


def camera_model(properties: Mapping[str, Any], width: int, height: int) -> PinholeModel | None:
    """Return the model of a camera for images of a size; None if it is not known.

    Args:
        properties: Of its agent: `model`, as `PinholeModel.to_dict` returns it, or else `field_of_view`, rad.
        width, height: px.
    Raises:
        VisionError: They describe no camera.
    """
    match properties:
        case {"model": dict(model)}:
            return PinholeModel.from_dict(model).scaled(width, height)
        case {"field_of_view": int(angle) | float(angle)}:
            return PinholeModel.from_field_of_view(width, height, angle)
    return None

"""Where a camera head is to look: by a step, by a point of the image, or by a drag over it. Pure geometry.

Angles as on the bus: rad, pan to the left, tilt up; zoom is the magnification, 1 at the widest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import asin, atan, atan2, cos, hypot, isfinite, pi, sin
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # it loads OpenCV
    from vision.camera_model import PinholeModel

STEPS: Mapping[str, tuple[int, int, int]] = {
    "ArrowLeft": (1, 0, 0),
    "ArrowRight": (-1, 0, 0),
    "ArrowUp": (0, 1, 0),
    "ArrowDown": (0, -1, 0),
    "+": (0, 0, 1),
    "-": (0, 0, -1),
}
"""By key: steps of pan, tilt and zoom."""


@dataclass(frozen=True, slots=True)
class HeadPlace:
    """Where a head looks: pan and tilt, rad, and magnification."""

    pan: float = 0.0
    tilt: float = 0.0
    zoom: float = 1.0

    @classmethod
    def from_result(cls, result: object) -> "HeadPlace | None":
        """Return what an agent of a head reports; None if a part is not known."""
        match result:
            case {"pan": float() | int() as pan, "tilt": float() | int() as tilt, "zoom": float() | int() as zoom}:
                return cls(float(pan), float(tilt), float(zoom))
        return None

    def limited(self, limits: Mapping[str, Any]) -> "HeadPlace":
        """Return the nearest place within the limits of a head: a pair of numbers for each axis that has them."""
        values = {}
        for axis in ("pan", "tilt", "zoom"):
            match limits.get(axis):
                case [float() | int() as low, float() | int() as high]:
                    values[axis] = min(max(getattr(self, axis), low), high)
        return replace(self, **values)

    def __str__(self) -> str:
        return f"pan {self.pan * 180 / pi:.0f}°, tilt {self.tilt * 180 / pi:.0f}°, zoom {self.zoom:.1f}"


def view_of(camera: Mapping[str, Any], head: Mapping[str, Any]) -> dict[str, Any]:
    """Return the properties that describe the lens of a camera: `model` or `field_of_view`; empty if neither is known.

    Args:
        camera, head: Properties of the agents of both; without a head empty.
    """
    for properties in (camera, head):
        for name in ("model", "field_of_view"):
            value = properties.get(name)
            if isinstance(value, dict | int | float):
                return {name: value}
    return {}


def zoomed(model: "PinholeModel", zoom: float) -> "PinholeModel":
    """Return the model of a camera at a magnification; the given one is for the widest zoom."""
    zoom = max(zoom, 1.0) if isfinite(zoom) else 1.0
    return replace(model, fx=model.fx * zoom, fy=model.fy * zoom)


def horizontal_view(model: "PinholeModel") -> float:
    """Return the horizontal field of view, rad."""
    return 2.0 * atan(model.width / 2.0 / model.fx)


def stepped(place: HeadPlace, key: str, view: float, step: float, zoom_step: float) -> HeadPlace:
    """Return the place after a step.

    Args:
        place: Before it.
        key: Of `STEPS`.
        view: Field of view, rad.
        step: Part of the field of view.
        zoom_step: Factor.
    """
    left, up, nearer = STEPS[key]
    return HeadPlace(place.pan + left * step * view, place.tilt + up * step * view, place.zoom * zoom_step**nearer)


def centred(place: HeadPlace, model: "PinholeModel", pixel: tuple[float, float]) -> HeadPlace:
    """Return the place from which a point of the image is in its centre.

    Args:
        place: When the image was taken.
        model: Of the camera at that zoom.
        pixel: The point, px.
    """
    azimuth, elevation = _direction(place.tilt, _ray(model, pixel))
    return HeadPlace(place.pan + azimuth, elevation, place.zoom)


def dragged(start: HeadPlace, model: "PinholeModel", taken: tuple[float, float], to: tuple[float, float]) -> HeadPlace:
    """Return the place from which a point of the image is at another one, as if the image were moved by hand.

    Args:
        start: When the drag began.
        model: Of the camera at that zoom.
        taken: The point, px.
        to: Where it is to be, px.
    """
    azimuth, elevation = _direction(start.tilt, _ray(model, taken))
    left, up = aim = _ray(model, to)
    # The elevation of a ray is that of its end: |ray| sin(elevation) = hypot(1, up) sin(tilt + atan(up)).
    rise = sin(elevation) * hypot(1.0, left, up) / hypot(1.0, up)
    tilt = asin(min(max(rise, -1.0), 1.0)) - atan(up)
    beside, _ = _direction(tilt, aim)
    return HeadPlace(start.pan + azimuth - beside, tilt, start.zoom)


def _ray(model: "PinholeModel", pixel: tuple[float, float]) -> tuple[float, float]:
    """Return how far left and up a ray through a pixel is, 1 ahead."""
    import numpy as np  # with the model it is loaded in any case

    _, left, up = model.rays_of(np.array([pixel]))[0].tolist()
    return left, up


def _direction(tilt: float, ray: tuple[float, float]) -> tuple[float, float]:
    """Return azimuth from the head's pan, and elevation, of a ray of a camera that looks up by a tilt."""
    left, up = ray
    ahead, above = cos(tilt) - up * sin(tilt), sin(tilt) + up * cos(tilt)
    return atan2(left, ahead), atan2(above, hypot(left, ahead))

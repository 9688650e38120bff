"""Coloured objects in an image: where they stand on the floor, and how large they are. Loads OpenCV."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan, atan2, cos, hypot, inf, sin, tan

import numpy as np

from apps.fetch.settings import FetchCamera
from vision.blobs import Blob
from vision.camera_model import PinholeModel
from vision.colours import ColourTable
from vision.image import Pixels

_SHADES = np.linspace(0.4, 1.0, 12)  # of a colour, from shadow to full light
_PATCH = 12  # px, of the drawn patch that a colour is trained from
_EDGE = 2  # px from the edge of the image, within which a blob may be cut off


@dataclass(frozen=True, slots=True)
class ObjectSighting:
    """An object that stands on the floor, in one image.

    colour: name of the channel. x, y: the middle of its face on the floor, m in base_link. width, height: m.
    """

    colour: str
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class CameraView:
    """What the camera sees of the floor: how far to both sides, rad, and from which distance before the axle, m."""

    half_angle: float
    nearest: float


class ObjectSight:
    """Finds objects of the colours of a table in the images of one camera.

    camera: its model.
    """

    def __init__(self, settings: FetchCamera, camera: PinholeModel, table: ColourTable) -> None:
        """Begin.

        Args:
            settings: Where the camera is on the robot.
            camera: Its model, at the size of the images.
            table: Channels with names.
        """
        self._settings = settings
        self.camera = camera
        self._table = table

    def look(self, pixels: Pixels, pan: float = 0.0, tilt: float = 0.0) -> list[ObjectSighting]:
        """Return the objects that stand wholly in the image.

        Args:
            pixels: In the order of OpenCV.
            pan, tilt: Of the camera, rad to the left and up.
        Raises:
            VisionError: It is no colour image.
        """
        found = self._table.find(pixels, round(self._settings.smallest_px))
        sightings = (
            self._sighting(self._table.channels[number].name, blob, pan, tilt)
            for number, blobs in found.items()
            for blob in blobs
        )
        return [each for each in sightings if each is not None]

    def view(self, tilt: float) -> CameraView:
        """Return what the camera sees of the floor at a tilt, rad up."""
        camera, where = self.camera, self._settings
        down = atan((camera.height - 1 - camera.cy) / camera.fy) - tilt
        nearest = where.forward_m + (where.height_m / tan(down) if down > 0.0 else inf)
        return CameraView(atan(camera.width / 2.0 / camera.fx), max(nearest, where.hidden_m))

    def _sighting(self, colour: str, blob: Blob, pan: float, tilt: float) -> ObjectSighting | None:
        """Return where a blob stands; None if it is cut off or hidden by the hull, or no floor is at its lower edge."""
        camera, where = self.camera, self._settings
        if (
            blob.bottom >= camera.height - _EDGE
            or blob.left < _EDGE
            or blob.right >= camera.width - _EDGE
            or blob.top < _EDGE
        ):
            return None
        centre = (blob.left + blob.right) / 2.0
        rays = camera.rays_of(np.array([[centre, blob.bottom + where.edge_px], [centre, blob.top - 0.5]]))
        (ahead, left, up), (top_ahead, top_left, top_up) = (_turned(ray, pan, tilt) for ray in rays.tolist())
        if up >= 0.0:
            return None
        scale = -where.height_m / up
        distance = scale * hypot(ahead, left)
        x = where.forward_m + distance * ahead / hypot(ahead, left)
        if distance > where.range_m or x < where.hidden_m:
            return None
        height = where.height_m + distance * top_up / hypot(top_ahead, top_left)
        width = blob.width * scale / camera.fx
        away, bearing = distance + width / 2.0, atan2(left, ahead)  # it is as deep as it is wide
        x = where.forward_m + away * cos(bearing)
        return ObjectSighting(colour, x, away * sin(bearing), width, height)


def named_colours(shades: Mapping[str, tuple[int, int, int]]) -> ColourTable:
    """Return a table of colours by their names, from shadow to full light.

    Args:
        shades: Red, green and blue of each, 0 to 255.
    """
    table = ColourTable()
    for channel, (name, (red, green, blue)) in enumerate(shades.items(), 1):
        drawn = np.rint(_SHADES[:, None] * np.array([blue, green, red])).astype(np.uint8)
        patch = np.repeat(np.repeat(drawn[:, None], _PATCH, axis=1), 2, axis=0)
        table.train(channel, patch, (0, 0, _PATCH, len(patch)), name)
    return table


def _turned(ray: list[float], pan: float, tilt: float) -> tuple[float, float, float]:
    """Return a ray of the camera in axes of the robot: ahead, left, up."""
    x, y, z = ray
    ahead, up = cos(tilt) * x - sin(tilt) * z, sin(tilt) * x + cos(tilt) * z
    return cos(pan) * ahead - sin(pan) * y, sin(pan) * ahead + cos(pan) * y, up

"""Colour channels on images of the bus. Loads OpenCV."""

from collections.abc import Mapping
from math import atan2, hypot
from typing import Any

import numpy as np

from agents.components.component import known
from agents.components.vision.image_tools import ImageTools, described
from vision.blobs import Blob
from vision.camera_model import PinholeModel, camera_model
from vision.colours import ColourTable
from vision.image import Image


class ColourTools(ImageTools):
    """The channels, and what they find."""

    def __init__(self, text: str, *, has_noise: bool) -> None:
        """Begin with channels.

        Args:
            text: A file of colours; empty for no channels.
            has_noise: As for `ImageTools`.
        Raises:
            VisionError: A line of it is wrong.
        """
        super().__init__(has_noise=has_noise)
        self.table = ColourTable.load(text.encode()) if text else ColourTable()

    def channels(self) -> list[dict[str, Any]]:
        """Return number, name and how many colours each channel has."""
        return [
            {"channel": number, "name": channel.name, "colours": len(channel.models)}
            for number, channel in sorted(self.table.channels.items())
        ]

    def blobs(self, image: Image, properties: Mapping[str, Any], smallest: int) -> dict[str, Any]:
        """Return the blobs of each channel that has some, in px, and rad where the camera is known."""
        camera = camera_model(properties, image.width, image.height)
        found = self.table.find(image.pixels, smallest)
        return {
            "width": image.width,
            "height": image.height,
            "channels": {str(number): [_described(blob, camera) for blob in blobs] for number, blobs in found.items()},
        }


def _described(blob: Blob, camera: PinholeModel | None) -> dict[str, Any]:
    bearing = elevation = None
    if camera is not None:
        x, y, z = camera.rays_of(np.array([[blob.x, blob.y]]))[0].tolist()
        bearing, elevation = known(atan2(y, x)), known(atan2(z, hypot(x, y)))
    return {**described(blob), "bearing": bearing, "elevation": elevation}

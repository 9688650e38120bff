"""Images of the bus: decoding, what makes them useless all the same, colour channels and motion. Loads OpenCV."""

import base64
import binascii
from collections.abc import Mapping
from math import atan2, hypot
from typing import Any

import numpy as np

from agents.components.component import known
from bus.messages import CompressedImage, stamp_ns
from vision.blobs import Blob
from vision.camera_model import PinholeModel, camera_model
from vision.colours import ColourTable
from vision.image import Image, VisionError
from vision.motion import MotionDetector

_DARKEST = 16
"""Brightness, of 255, that one pixel in a thousand of an image that is not black exceeds."""
_SAME = 10
"""Equal files in succession, from which on the camera may be frozen."""
_GAP = 2.0
"""Seconds between two images, from which on the background of motion is built anew."""
_MOVES = "the camera moves; motion is tracked when robot and head stand"


class ImageTools:
    """Takes the images of one camera as they come.

    trouble: what is wrong with the latest one, for a person; None if nothing is.
    """

    def __init__(self, *, has_noise: bool) -> None:
        """Begin with no image.

        Args:
            has_noise: Whether images of the camera differ even if nothing moves, as those of all real cameras do.
        """
        self.trouble: str | None = None
        self._has_noise = has_noise
        self._exposure = 0  # ns
        self._file = b""
        self._same = 0

    def image(self, message: CompressedImage | None, text: str) -> Image:
        """Return the image of a message, or without one that of a request, in base64.

        Raises:
            VisionError: It is no base64, or `decoded` and `Image.decode` refuse it.
        """
        if message is not None:
            return self.decoded(message)
        try:
            return Image.decode(base64.b64decode(text, validate=True))
        except binascii.Error as err:
            raise VisionError(f"the image must be a JPEG or PNG file in base64 ({err})") from None

    def decoded(self, message: CompressedImage) -> Image:
        """Return the image of a message.

        Raises:
            VisionError: It is torn, damaged or too large.
        """
        data, exposure = message.data.tobytes(), stamp_ns(message.header)
        if data != self._file:
            self._same = 0
        elif exposure != self._exposure:  # it may also be used several times
            self._same += 1
        self._file, self._exposure = data, exposure
        image = Image.decode(data)
        self.trouble = None
        if self._has_noise and self._same >= _SAME:
            self.trouble = f"{self._same + 1} images in succession are the same; the camera may be frozen"
        if float(np.percentile(image.pixels[::2, ::2], 99.9)) < _DARKEST:
            self.trouble = "the image is black; is the lens covered, or the light off?"
        return image


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
            "channels": {str(number): [_located(blob, camera) for blob in blobs] for number, blobs in found.items()},
        }


class MotionTools(ImageTools):
    """Compares each image with the background."""

    def __init__(self, *, has_noise: bool) -> None:
        """Begin without a background; has_noise: as for `ImageTools`."""
        super().__init__(has_noise=has_noise)
        self._detector = MotionDetector()
        self._stamp: float | None = None  # s, of the image before

    def result(self, image: Image, stamp: float, has_moved: bool) -> dict[str, Any]:
        """Return what moves.

        Args:
            image: The image.
            stamp: s, of its exposure.
            has_moved: Whether the camera has moved since the image before.
        """
        apart = None if self._stamp is None else stamp - self._stamp
        if has_moved or apart is None or not 0.0 <= apart <= _GAP:
            self._detector.reset()
        self._stamp = stamp
        found = None
        if not has_moved and apart != 0.0:  # 0: the same image is asked for again
            found = self._detector.update(image.pixels, apart if apart is not None and apart > 0.0 else _GAP)
        return {
            "trouble": _MOVES if has_moved else self.trouble,
            "width": image.width,
            "height": image.height,
            "settled": found is not None and found.settled,
            "blobs": [described(blob) for blob in (found.blobs if found is not None else ())],
        }


def described(blob: Blob) -> dict[str, Any]:
    """Return area, centroid and bounding box of a blob, px, as agents publish them."""
    return {
        "area": blob.area,
        "x": known(blob.x, 2),
        "y": known(blob.y, 2),
        "left": blob.left,
        "right": blob.right,
        "top": blob.top,
        "bottom": blob.bottom,
    }


def _located(blob: Blob, camera: PinholeModel | None) -> dict[str, Any]:
    bearing = elevation = None
    if camera is not None:
        x, y, z = camera.rays_of(np.array([[blob.x, blob.y]]))[0].tolist()
        bearing, elevation = known(atan2(y, x)), known(atan2(z, hypot(x, y)))
    return {**described(blob), "bearing": bearing, "elevation": elevation}

"""Images of the bus decoded, and what makes a camera's images useless although they can be decoded. Loads OpenCV."""

import base64
import binascii
from typing import Any

import numpy as np

from agents.components.component import known
from bus.messages import CompressedImage, stamp_ns
from vision.blobs import Blob
from vision.image import Image, VisionError

_DARKEST = 16
"""Brightness, of 255, that one pixel in a thousand of an image that is not black exceeds."""
_SAME = 10
"""Equal files in succession, from which on the camera may be frozen."""


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

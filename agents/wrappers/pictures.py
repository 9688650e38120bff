"""Pictures for functions in C: from a compressed picture to bytes of pixels, and back."""

from typing import Any

from agents.wrappers.wrapper_file import Colours
from configs.extras import missing, needs

QUALITY = 90  # of JPEG, percent


class PicturesNotPossible(RuntimeError):
    """OpenCV is missing, or these bytes are no picture."""


def pixels(compressed: bytes, colours: Colours) -> dict[str, Any]:
    """Arguments for a function: `image` (bytes, row by row from the top left), `width` and `height` in pixels.

    Raises:
        PicturesNotPossible: OpenCV is missing, or these bytes are no picture.
    """
    cv2, numpy = _opencv()
    how = cv2.IMREAD_GRAYSCALE if colours is Colours.GREY else cv2.IMREAD_COLOR
    image = cv2.imdecode(numpy.frombuffer(compressed, numpy.uint8), how) if compressed else None
    if image is None:
        raise PicturesNotPossible(f"{len(compressed)} bytes are no picture that OpenCV can read")
    if colours is Colours.RGB:
        image = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    return {"image": image.tobytes(), "width": image.shape[1], "height": image.shape[0]}


def compressed(image: bytes, width: int, height: int) -> bytes:
    """A JPEG picture of pixels, grey or in colour as their number tells.

    Raises:
        PicturesNotPossible: OpenCV is missing, or there are not as many pixels as there should be.
    """
    cv2, numpy = _opencv()
    channels = len(image) // (width * height) if width * height else 0
    if channels not in (1, 3) or len(image) != width * height * channels:
        raise PicturesNotPossible(f"{len(image)} bytes are no picture of {width} by {height}, grey or in colour")
    array = numpy.frombuffer(image, numpy.uint8).reshape((height, width, channels))
    if channels == 3:
        array = cv2.cvtColor(array, cv2.COLOR_RGB2BGR)
    _, coded = cv2.imencode(".jpg", array, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return bytes(coded)


def _opencv() -> tuple[Any, Any]:
    if missing("vision"):
        raise PicturesNotPossible(needs("a wrapper with pictures", "vision"))
    import cv2  # late: only wrappers with pictures need it
    import numpy

    return cv2, numpy

"""JPEG files: whether they are whole, the size of the picture, and smaller copies."""

from math import sqrt
from struct import unpack_from

from cameras.errors import CameraNotUsable
from configs.extras import missing, needs

START, END = b"\xff\xd8", b"\xff\xd9"
MARKER = 0xFF
WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xDA)))
"""Markers that no length follows."""
NO_FRAMES = frozenset((0xC4, 0xC8, 0xCC))
"""Markers from 0xC0 to 0xCF that begin no frame."""
TRIES = 8
SPARE = 0.9
"""Of the scale that the sizes in bytes suggest: small pictures have more bytes for each pixel."""


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Width and height in pixels; None of what is no whole JPEG.

    Source: ITU-T T.81, annex B: a frame's header gives its height and then its width.
    """
    if not isinstance(data, bytes):
        raise TypeError(f"a picture must be bytes, not {type(data).__name__}")
    if not (data.startswith(START) and data.rstrip(b"\0").endswith(END)):
        return None
    at = len(START)
    while at + 9 <= len(data):
        if data[at] != MARKER:
            return None
        kind = data[at + 1]
        if 0xC0 <= kind <= 0xCF and kind not in NO_FRAMES:
            height, width = unpack_from(">HH", data, at + 5)
            return width, height
        at += 1 if kind == MARKER else 2 if kind in WITHOUT_LENGTH else 2 + unpack_from(">H", data, at + 2)[0]
    return None


def shrunk(jpeg: bytes, most: int) -> bytes:
    """Return the picture, scaled down until it has no more than `most` bytes; as it is where it fits.

    Raises:
        CameraNotUsable: It cannot be made smaller here.
    """
    if len(jpeg) <= most:
        return jpeg
    if missing("vision"):
        raise CameraNotUsable(needs("making a picture smaller", "vision"))
    import cv2  # here and not at the top: it is a large part that only this needs
    import numpy as np

    picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    smaller = jpeg
    for _ in range(TRIES):
        if picture is None or min(picture.shape[:2]) < 2:
            break
        scale = SPARE * min(1.0, sqrt(most / len(smaller)))
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        _, data = cv2.imencode(".jpg", picture)
        smaller = bytes(data)
        if len(smaller) <= most:
            return smaller
    raise CameraNotUsable("the picture is no JPEG that can be made smaller")

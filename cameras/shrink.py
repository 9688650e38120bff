"""Pictures made smaller, for whoever can carry only so many bytes of them."""

from math import sqrt

from cameras.errors import CameraNotUsable
from configs.extras import missing, needs

TRIES = 8
SPARE = 0.9
"""Of the scale that the sizes in bytes suggest: small pictures have more bytes for each pixel."""


def shrunk(jpeg: bytes, most: int) -> bytes:
    """The picture, scaled down until it has no more than `most` bytes; as it is where it fits.

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

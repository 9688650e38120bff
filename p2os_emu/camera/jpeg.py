"""JPEG files of drawn pictures."""

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image


def encode_jpeg(colours: NDArray[np.uint8], quality: int) -> bytes:
    """Return the file of a picture.

    Args:
        colours: Rows of pixels with red, green, blue.
        quality: 1 to 95.
    """
    file = io.BytesIO()
    Image.fromarray(colours).save(file, "JPEG", quality=quality)
    return file.getvalue()

"""Films read back, frame by frame."""

from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from apps.film import Pixels


def frames_of(file: Path) -> list[Pixels]:
    """Return the frames of a GIF or MP4: blue, green and red."""
    found: list[Pixels] = []
    if file.suffix == ".gif":
        with Image.open(file) as film:
            for number in range(film.n_frames):  # type: ignore[attr-defined]  # of GIFs; the stubs have it on no image
                film.seek(number)
                found.append(np.asarray(film.convert("RGB"), np.uint8)[:, :, ::-1])
        return found
    video = cv2.VideoCapture(str(file))
    while True:
        has_come, image = video.read()
        if not has_come:
            return found
        found.append(np.asarray(image, np.uint8))

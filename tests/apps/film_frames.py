"""Films read back, frame by frame."""

from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageSequence

from apps.film import Pixels


def frames_of(file: Path) -> list[Pixels]:
    """Return the frames of a GIF or MP4: blue, green and red."""
    if file.suffix == ".gif":
        with Image.open(file) as film:
            frames = ImageSequence.Iterator(film)
            return [np.asarray(frame.convert("RGB"), np.uint8)[:, :, ::-1] for frame in frames]
    found: list[Pixels] = []
    video = cv2.VideoCapture(str(file))
    while True:
        has_come, image = video.read()
        if not has_come:
            return found
        found.append(np.asarray(image, np.uint8))

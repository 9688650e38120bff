"""Motion tracking on images of the bus. Loads OpenCV."""

from typing import Any

from agents.components.vision.image_tools import ImageTools, described
from vision.image import Image
from vision.motion import MotionDetector

_GAP = 2.0
"""Seconds between two images, from which on the background is built anew."""
_MOVES = "the camera moves; motion is tracked when robot and head stand"


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

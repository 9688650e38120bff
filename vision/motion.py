"""Motion tracking with a standing camera: differences from a background that adapts, and the blobs of what differs.

The background has a mean and a deviation for each pixel, both adapting (running Gaussian average: Wren et al.,
"Pfinder", PAMI 19, 1997). Changes of the light that are the same everywhere are removed first.
"""

from dataclasses import dataclass
from math import exp

import cv2
import numpy as np

from vision.blobs import MOST, Blob, blobs_of
from vision.image import Pixels, VisionError, grey_pixels

_MOVED = 0.5  # share of the pixels that differ when the camera itself was moved
_SHARE = 16  # each so many pixels count for the brightness of the light


@dataclass(frozen=True, slots=True)
class MotionParameters:
    """Parameters of motion tracking.

    adapt: s until the background has taken over 63 % of a slow change. absorb: the same where something moves or has
    stopped. least: difference of brightness, of 255, that counts in any case. deviations: standard deviations of a
    pixel that count. size: px of gaps that are closed, and of specks that are removed.
    """

    adapt: float = 2.0
    absorb: float = 20.0
    least: float = 18.0
    deviations: float = 4.0
    size: int = 3

    def __post_init__(self) -> None:
        if min(self.adapt, self.absorb, self.least, self.deviations) <= 0.0 or not 1 <= self.size <= 31:
            raise VisionError("times, differences and deviations of motion tracking must be positive, size 1 to 31 px")


@dataclass(frozen=True, slots=True, eq=False)
class MotionResult:
    """What moved.

    mask: binary image. blobs: the largest first. settled: whether there is a background to compare with; without it
    mask and blobs are empty.
    """

    mask: Pixels
    blobs: tuple[Blob, ...]
    settled: bool


class MotionDetector:
    """Compares each image with the background of those before."""

    def __init__(self, parameters: MotionParameters | None = None) -> None:
        self._parameters = parameters or MotionParameters()
        self._mean: np.ndarray | None = None
        self._variance = np.zeros(())
        self._images = 0

    def reset(self) -> None:
        """Forget the background: the camera was turned."""
        self._mean = None

    def update(self, pixels: Pixels, dt: float, smallest: int = 25, most: int = MOST) -> MotionResult:
        """Take the next image and return what moved.

        Args:
            pixels: Colour or grey. After a change of its size the background is built anew.
            dt: s since the image before.
            smallest: Area in pixels that a blob has at least.
            most: Blobs.
        Raises:
            VisionError: dt is not positive.
        """
        if not 0.0 < dt < 1e6:
            raise VisionError(f"the time between two images must be positive, not {dt:g} s")
        values = np.asarray(cv2.GaussianBlur(grey_pixels(pixels), (3, 3), 0), np.float32)
        if self._mean is None or self._mean.shape != values.shape:
            return self._begun(values)
        self._images += 1
        light = _gain(values, self._mean)
        difference = np.abs(values - light * self._mean)
        limit = np.maximum(self._parameters.least, self._parameters.deviations * np.sqrt(self._variance))
        element = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (self._parameters.size,) * 2)
        moving = (difference > limit).astype(np.uint8) * np.uint8(255)
        mask = np.asarray(cv2.morphologyEx(moving, cv2.MORPH_OPEN, element), np.uint8)
        mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, element), np.uint8)
        if np.count_nonzero(mask) > _MOVED * mask.size:
            return self._begun(values)
        self._adapt(values, difference, moving > 0, light, dt)
        return MotionResult(mask, blobs_of(mask, smallest, most).get(255, ()), True)

    def _begun(self, values: np.ndarray) -> MotionResult:
        self._mean = values.copy()
        self._variance = np.full(values.shape, (self._parameters.least / self._parameters.deviations) ** 2, np.float32)
        self._images = 1
        return MotionResult(np.zeros(values.shape, np.uint8), (), False)

    def _adapt(self, values: np.ndarray, difference: np.ndarray, moving: np.ndarray, light: float, dt: float) -> None:
        """Take the image into the background; the first ones count more, as for a mean of all."""
        assert self._mean is not None  # `update` has seen to it
        quick = max(1.0 - exp(-dt / self._parameters.adapt), 1.0 / (self._images + 1))
        slow = 1.0 - exp(-dt / self._parameters.absorb)
        rate = np.where(moving, np.float32(slow), np.float32(quick))
        self._mean = light * self._mean  # the mean follows the light at once
        self._mean += rate * (values - self._mean)
        still = ~moving
        self._variance[still] += quick * (difference[still] ** 2 - self._variance[still])


def _gain(values: np.ndarray, mean: np.ndarray) -> float:
    """Return by how much the light has changed: the median ratio of pixels that are neither black nor white."""
    now, before = values.ravel()[::_SHARE], mean.ravel()[::_SHARE]
    usable = (before > 20.0) & (before < 235.0) & (now < 250.0)
    if np.count_nonzero(usable) < 20:
        return 1.0
    return float(np.clip(np.median(now[usable] / before[usable]), 0.3, 3.0))

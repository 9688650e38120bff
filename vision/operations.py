"""All operations on images, in one table. An operation never changes its input."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from vision.image import Floats, ImageKind, Pixels, grey_pixels
from vision.operation import Arguments, Numbers, Operation, OperationParameter

_SHAPES = {"rectangle": cv2.MORPH_RECT, "ellipse": cv2.MORPH_ELLIPSE, "cross": cv2.MORPH_CROSS}
_WEIGHTS = {"mean": cv2.ADAPTIVE_THRESH_MEAN_C, "gaussian": cv2.ADAPTIVE_THRESH_GAUSSIAN_C}
_CHANNELS = ("blue", "green", "red")


def _bytes(values: Any) -> Pixels:
    return np.asarray(values, np.uint8)


def _convolve(pixels: Pixels, given: Arguments) -> Pixels:
    """Convolution in the mathematical sense: `filter2D` correlates, so the kernel is turned by half a turn."""
    kernel: Floats = np.array(given["kernel"])[::-1, ::-1] * given["scale"]
    rows, columns = kernel.shape
    anchor = ((columns - 1) // 2, (rows - 1) // 2)
    return _bytes(cv2.filter2D(pixels, -1, np.ascontiguousarray(kernel), anchor=anchor, delta=given["offset"]))


def _blur(pixels: Pixels, given: Arguments) -> Pixels:
    for _ in range(given["passes"]):
        pixels = _bytes(cv2.blur(pixels, (3, 3)))
    return pixels


def _morphology(kind: int) -> Callable[[Pixels, Arguments], Pixels]:
    def compute(pixels: Pixels, given: Arguments) -> Pixels:
        element = cv2.getStructuringElement(_SHAPES[given["shape"]], (given["size"], given["size"]))
        return _bytes(cv2.morphologyEx(pixels, kind, element, iterations=given["passes"]))

    return compute


def _threshold(pixels: Pixels, given: Arguments) -> Pixels:
    kind = cv2.THRESH_BINARY_INV if given["invert"] else cv2.THRESH_BINARY
    return _bytes(cv2.threshold(pixels, given["level"], 255, kind)[1])


def _otsu(pixels: Pixels, given: Arguments) -> Pixels:
    kind = cv2.THRESH_BINARY_INV if given["invert"] else cv2.THRESH_BINARY
    return _bytes(cv2.threshold(pixels, 0, 255, kind | cv2.THRESH_OTSU)[1])


def _adaptive(pixels: Pixels, given: Arguments) -> Pixels:
    kind = cv2.THRESH_BINARY_INV if given["invert"] else cv2.THRESH_BINARY
    weights = _WEIGHTS[given["weights"]]
    return _bytes(cv2.adaptiveThreshold(pixels, 255, weights, kind, given["size"], given["offset"]))


def _canny(pixels: Pixels, given: Arguments) -> Pixels:
    return _bytes(cv2.Canny(pixels, given["low"], given["high"], apertureSize=3, L2gradient=True))


def _sobel(pixels: Pixels, given: Arguments) -> Pixels:
    """Magnitude of the gradient, scaled so that a step from black to white gives 255 for each size."""
    size, direction = given["size"], given["direction"]
    smooth, slope = cv2.getDerivKernels(0, 1, size)
    scale = 2.0 / float(smooth.sum() * np.abs(slope).sum())
    across = cv2.Sobel(pixels, cv2.CV_32F, 1, 0, ksize=size, scale=scale)
    down = cv2.Sobel(pixels, cv2.CV_32F, 0, 1, ksize=size, scale=scale)
    gradient = {"x": across, "y": down}.get(direction)
    return _bytes(cv2.convertScaleAbs(cv2.magnitude(across, down) if gradient is None else gradient))


def _histogram(pixels: Pixels, given: Arguments) -> Numbers:
    """Count the pixels in ranges of equal width of the values 0 to 255, for each channel."""
    bins = given["bins"]
    channels = dict(zip(_CHANNELS, np.moveaxis(pixels, 2, 0), strict=True)) if pixels.ndim == 3 else {"grey": pixels}
    bin_of_value = np.arange(256) * bins // 256
    result: Numbers = {"from": [-(-edge * 256 // bins) for edge in range(bins)]}
    for name, channel in channels.items():
        counts = np.bincount(np.ascontiguousarray(channel).ravel(), minlength=256)
        result[name] = [int(count) for count in np.bincount(bin_of_value, counts, bins)]
    return result


def _size(default: int, low: int = 1, high: int = 99) -> OperationParameter:
    return OperationParameter("size", "odd", default, low, high, "px")


_GREY = frozenset((ImageKind.GREY, ImageKind.BINARY))
_PASSES = OperationParameter("passes", "integer", 1, 1, 20)
_INVERT = OperationParameter("invert", "flag", False)
_ELEMENT = (_size(3), OperationParameter("shape", "choice", "rectangle", choices=tuple(_SHAPES)), _PASSES)

_TABLE = (
    Operation("grey", "brightness of a colour image", lambda pixels, _: grey_pixels(pixels), gives="grey"),
    Operation(
        "convolution",
        "convolution with any kernel, times scale, plus offset",
        _convolve,
        (
            OperationParameter("kernel", "matrix"),
            OperationParameter("scale", "number", 1.0, -1000.0, 1000.0),
            OperationParameter("offset", "number", 0.0, -255.0, 255.0),
        ),
        gives="smooth",
    ),
    Operation(
        "gaussian",
        "Gaussian filter",
        lambda pixels, given: _bytes(cv2.GaussianBlur(pixels, (0, 0), given["sigma"])),
        (OperationParameter("sigma", "number", 1.5, 0.1, 50.0, "px"),),
        gives="smooth",
    ),
    Operation(
        "box",
        "mean of a square",
        lambda pixels, given: _bytes(cv2.blur(pixels, (given["size"],) * 2)),
        (_size(3),),
        gives="smooth",
    ),
    Operation("blur", "mean of 3 x 3 pixels, repeated", _blur, (_PASSES,), gives="smooth"),
    Operation(
        "median",
        "median of a square; removes single wrong pixels and keeps edges",
        lambda pixels, given: _bytes(cv2.medianBlur(pixels, given["size"])),
        (_size(3, high=31),),
    ),
    Operation("erosion", "least value around each pixel; bright areas shrink", _morphology(cv2.MORPH_ERODE), _ELEMENT),
    Operation(
        "dilation", "largest value around each pixel; bright areas grow", _morphology(cv2.MORPH_DILATE), _ELEMENT
    ),
    Operation("opening", "erosion, then dilation; removes small bright areas", _morphology(cv2.MORPH_OPEN), _ELEMENT),
    Operation("closing", "dilation, then erosion; fills small dark areas", _morphology(cv2.MORPH_CLOSE), _ELEMENT),
    Operation(
        "threshold",
        "white above a level",
        _threshold,
        (OperationParameter("level", "integer", 127, 0, 255), _INVERT),
        _GREY,
        "binary",
    ),
    Operation("otsu", "white above the level that best separates two classes", _otsu, (_INVERT,), _GREY, "binary"),
    Operation(
        "adaptive",
        "white above the mean around each pixel minus offset",
        _adaptive,
        (
            _size(11, low=3),
            OperationParameter("offset", "number", 2.0, -255.0, 255.0),
            OperationParameter("weights", "choice", "mean", choices=tuple(_WEIGHTS)),
            _INVERT,
        ),
        _GREY,
        "binary",
    ),
    Operation(
        "canny",
        "thin edges: gradients above high, and those above low that are connected with them",
        _canny,
        (
            OperationParameter("low", "number", 50.0, 0.0, 1500.0),
            OperationParameter("high", "number", 150.0, 0.0, 1500.0),
        ),
        _GREY,
        "binary",
    ),
    Operation(
        "sobel",
        "magnitude of the gradient",
        _sobel,
        (
            OperationParameter("direction", "choice", "both", choices=("x", "y", "both")),
            _size(3, low=3, high=7),
        ),
        _GREY,
        "grey",
    ),
    Operation(
        "histogram",
        "pixels in each range of values, for each channel",
        _histogram,
        (OperationParameter("bins", "integer", 256, 1, 256),),
        gives="numbers",
    ),
)
OPERATIONS = {operation.name: operation for operation in _TABLE}
"""All operations, by name."""

"""Blobs: connected areas of pixels of one class, with area, centroid and bounding box.

All classes are labelled in one pass over runs: pixels of one class side by side in one row. Runs that touch in
neighbouring rows, diagonally too, are connected (the run-length method of CMVision: Bruce, Balch and Veloso, "Fast and
inexpensive color image segmentation for interactive robots", IROS 2000), here by array operations on all runs at once.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.image import Pixels

MOST = 10
"""Blobs of one class that are reported, as by ACTS."""

_Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Blob:
    """A connected area.

    area: pixels. x, y: centroid, px from the centre of the upper left pixel, right and down.
    left, top, right, bottom: the outermost columns and rows that belong to it.
    """

    area: int
    x: float
    y: float
    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """Columns of the bounding box."""
        return self.right - self.left + 1

    @property
    def height(self) -> int:
        """Rows of the bounding box."""
        return self.bottom - self.top + 1


def blobs_of(classes: Pixels, smallest: int = 1, most: int = MOST) -> dict[int, tuple[Blob, ...]]:
    """Return the blobs of each class that occurs, the largest first.

    Args:
        classes: Shape (height, width); 0 for pixels of no class.
        smallest: Area in pixels that a blob has at least.
        most: Blobs of each class.
    """
    height, width = classes.shape
    stride = width + 1
    flat: Pixels = np.zeros(height * stride + 1, np.uint8)  # a column of no class behind each row, so runs end there
    flat[1:].reshape(height, stride)[:, :width] = classes
    changes = np.flatnonzero(flat[1:] != flat[:-1])
    class_of = flat[1:][changes]
    solid = np.flatnonzero(class_of)
    if not len(solid):
        return {}
    starts, ends = changes[solid], changes[solid + 1]  # the end is the first pixel behind the run
    class_of = class_of[solid]
    labels = _connected(starts, ends, class_of, stride)

    roots = np.flatnonzero(labels == np.arange(len(labels)))
    count = len(roots)
    component = np.empty_like(labels)
    component[roots] = np.arange(count)
    component = component[labels]
    rows, lefts = np.divmod(starts, stride)
    lengths = ends - starts
    areas = np.bincount(component, lengths, count)
    x = np.bincount(component, lengths * (lefts + (lengths - 1) / 2.0), count) / areas
    y = np.bincount(component, lengths * rows, count) / areas
    left, right = np.full(count, width), np.zeros(count, np.intp)
    top, bottom = rows[roots], np.zeros(count, np.intp)  # a root is the first run of its component
    np.minimum.at(left, component, lefts)
    np.maximum.at(right, component, lefts + lengths - 1)
    np.maximum.at(bottom, component, rows)

    large = np.flatnonzero(areas >= smallest)
    of_class = class_of[roots]
    found: dict[int, list[Blob]] = {}
    for at in large[np.lexsort((-areas[large], of_class[large]))].tolist():
        same = found.setdefault(int(of_class[at]), [])
        if len(same) < most:
            box = (int(left[at]), int(top[at]), int(right[at]), int(bottom[at]))
            same.append(Blob(int(areas[at]), float(x[at]), float(y[at]), *box))
    return {number: tuple(same) for number, same in found.items()}


def _connected(starts: _Indices, ends: _Indices, class_of: Pixels, stride: int) -> _Indices:
    """Return for each run the first run that it is connected with."""
    first = np.searchsorted(ends, starts + stride)  # of the runs in the row below that it touches
    counts = np.searchsorted(starts, ends + stride, "right") - first
    above = np.repeat(np.arange(len(starts)), counts)
    below = np.arange(len(above)) + np.repeat(first - (np.cumsum(counts) - counts), counts)
    alike = class_of[above] == class_of[below]
    above, below = above[alike], below[alike]
    labels = np.arange(len(starts))
    while len(above):
        lower, upper = labels[above], labels[below]
        np.minimum.at(labels, np.maximum(lower, upper), np.minimum(lower, upper))
        while not np.array_equal(labels, further := labels[labels]):
            labels = further
        apart = labels[above] != labels[below]
        above, below = above[apart], below[apart]
    return labels

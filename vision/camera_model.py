"""Camera model: pinhole with lens distortion, from a field of view or from chessboard images.

Pixels count right and down from the centre of the upper left one. A ray is a vector in the camera's frame with the axes
of a robot (REP 103): x forward along the optical axis, y left, z up.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from math import isfinite, pi, radians, tan
from typing import Any, Self

import cv2
import numpy as np

from vision.image import Floats, Pixels, VisionError, grey_pixels

FEWEST_VIEWS = 6
"""Images of the chessboard that a calibration needs."""
_LARGEST_ERROR = 1.5  # px rms, above which a calibration is no use
_LEAST_TILT = radians(12.0)  # of at least one board to another; parallel boards do not determine the focal length
_LEAST_COVER = 0.25  # share of the image that the boards cover together
_ENDED = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-4)


@dataclass(frozen=True, slots=True)
class PinholeModel:
    """Width and height in px, focal lengths and principal point in px, and distortion.

    k1, k2, k3: radial, p1, p2: tangential distortion, as in OpenCV and in ROS (`plumb_bob`).
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
                raise VisionError(f"{each.name} of a camera model must be a finite number, not {value!r}")
        if min(self.width, self.height, self.fx, self.fy) <= 0:
            raise VisionError("width, height and focal lengths of a camera model must be positive")

    @classmethod
    def from_field_of_view(cls, width: int, height: int, horizontal: float) -> Self:
        """Return the model of a camera without distortion and with square pixels.

        Args:
            width, height: px.
            horizontal: Angle of view from the left to the right edge, rad.
        Raises:
            VisionError: The angle is not between 0 and pi, or the size not positive.
        """
        if not 0.0 < horizontal < pi:
            raise VisionError(f"a field of view is between 0 and {pi:.4f} rad, not {horizontal:g}")
        focal = width / 2.0 / tan(horizontal / 2.0)
        return cls(width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the model that `to_dict` described.

        Raises:
            VisionError: A value is missing, unknown or no number.
        """
        try:
            return cls(**data)
        except TypeError:
            names = ", ".join(each.name for each in fields(cls))
            raise VisionError(f"a camera model has {names}, not {', '.join(map(str, data))}"[:300]) from None

    def to_dict(self) -> dict[str, float]:
        """Return the model as JSON-like data."""
        return asdict(self)

    def scaled(self, width: int, height: int) -> Self:
        """Return the model for the whole image at another size."""
        across, down = width / self.width, height / self.height
        return type(self)(
            width,
            height,
            self.fx * across,
            self.fy * down,
            (self.cx + 0.5) * across - 0.5,
            (self.cy + 0.5) * down - 0.5,
            *self.distortion.tolist(),
        )

    @property
    def matrix(self) -> Floats:
        """Camera matrix of OpenCV, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Floats:
        """k1, k2, p1, p2, k3: the order of OpenCV."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    def pixels_of(self, rays: Floats) -> Floats:
        """Return where rays meet the image, px, shape (n, 2); NaN for those that point backwards.

        Args:
            rays: Shape (n, 3), of any length.
        """
        rays = np.asarray(rays, np.float64)
        forward = np.where(rays[:, 0] > 1e-9, rays[:, 0], np.nan)
        x, y = -rays[:, 1] / forward, -rays[:, 2] / forward
        if self.distortion.any():
            square = x * x + y * y
            radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
            x, y = (
                x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x),
                y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y,
            )
        return np.stack((self.fx * x + self.cx, self.fy * y + self.cy), axis=1)

    def rays_of(self, pixels: Floats) -> Floats:
        """Return the rays through pixels, shape (n, 3), with x = 1.

        Args:
            pixels: Shape (n, 2).
        """
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        if self.distortion.any() and len(pixels):
            points = cv2.undistortPoints(pixels.reshape(-1, 1, 2), self.matrix, self.distortion)
            x, y = np.asarray(points, np.float64).reshape(-1, 2).T
        else:
            x, y = (pixels[:, 0] - self.cx) / self.fx, (pixels[:, 1] - self.cy) / self.fy
        return np.stack((np.ones_like(x), -x, -y), axis=1)


@dataclass(frozen=True, slots=True)
class _CalibrationResult:
    """A camera model and how good it is.

    error: rms distance of the corners from where the model has them, px. used: the images that count, from 0.
    words: quality and what to do about it, for a person.
    """

    model: PinholeModel
    error: float
    used: tuple[int, ...]
    words: str


def calibrate(images: Sequence[Pixels], columns: int, rows: int, square: float = 0.03) -> _CalibrationResult:
    """Return the camera model by images of a chessboard (Zhang, PAMI 22, 2000).

    Args:
        images: Of one size, colour or grey, the board at different places and angles.
        columns, rows: Inner corners of the board: one less than squares.
        square: Side of a square, m.
    Raises:
        VisionError: Too few images show the whole board, or what they show does not determine the camera.
    """
    if columns < 3 or rows < 3 or columns == rows or square <= 0.0:
        raise VisionError(
            f"a chessboard needs at least 3 inner corners each way, not the same number, and squares of positive size; "
            f"not {columns} x {rows} of {square:g} m"
        )
    greys = [grey_pixels(image) for image in images]
    sizes = {grey.shape for grey in greys}
    if len(sizes) > 1:
        raise VisionError(f"the images have {len(sizes)} different sizes; take all with the same settings")
    corners = [_corners(grey, columns, rows) for grey in greys]
    used = [at for at, found in enumerate(corners) if found is not None]
    if len(used) < FEWEST_VIEWS:
        raise VisionError(
            f"the whole board of {columns} x {rows} inner corners is in {len(used)} of {len(images)} images; "
            f"take at least {FEWEST_VIEWS} with all corners in view, sharp and evenly lit"
        )
    board = np.zeros((columns * rows, 3), np.float32)
    board[:, :2] = np.mgrid[:columns, :rows].T.reshape(-1, 2) * square
    height, width = greys[0].shape
    points = [found for found in corners if found is not None]
    return _solved(points, board, (width, height), used)


def _solved(points: list[Pixels], board: np.ndarray, size: tuple[int, int], used: list[int]) -> _CalibrationResult:
    """Fit the model, and once more without images that fit much worse than the others."""
    flags = cv2.CALIB_FIX_K3  # a third radial coefficient is not determined by a few images
    for _ in range(2):
        boards = [board] * len(points)
        result = cv2.calibrateCameraExtended(boards, points, size, None, None, flags=flags)  # type: ignore[call-overload]  # the stubs demand matrices where OpenCV takes None
        error, matrix, distortion, turns = result[0], result[1], result[2].ravel(), result[3]
        each = result[7].ravel()
        good = [at for at, own in enumerate(each) if own <= max(0.5, 3.0 * float(np.median(each)))]
        if len(good) == len(points) or len(good) < FEWEST_VIEWS:
            break
        points, used = [points[at] for at in good], [used[at] for at in good]
    if not error <= _LARGEST_ERROR:
        raise VisionError(
            f"the corners are {error:.1f} px from where a camera would have them; "
            "check the number of corners, and take sharp images of a flat board"
        )
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    if np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)) < _LEAST_TILT:
        raise VisionError("the board is parallel in all images; tilt it by 20 to 40 degrees in some of them")
    cover = np.concatenate(points).reshape(-1, 2)
    share = float(np.prod(np.ptp(cover, axis=0)) / (size[0] * size[1]))
    words = f"{len(points)} images, error {error:.2f} px"
    if share < _LEAST_COVER:
        words += f"; the boards cover {share:.0%} of the image, so its edges are uncertain: take some near the edges"
    model = PinholeModel(*size, matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *distortion[:5].tolist())
    return _CalibrationResult(model, float(error), tuple(used), words)


def _corners(grey: Pixels, columns: int, rows: int) -> Pixels | None:
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    found, corners = cv2.findChessboardCorners(grey, (columns, rows), flags=flags)
    if not found:
        return None
    apart = np.linalg.norm(np.diff(corners.reshape(rows, columns, 2), axis=1), axis=2).min()
    reach = int(np.clip(apart / 3.0, 2.0, 7.0))  # not as far as the next corner
    return np.asarray(cv2.cornerSubPix(grey, corners, (reach, reach), (-1, -1), _ENDED))

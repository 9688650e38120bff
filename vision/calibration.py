"""Camera calibration: a camera model from views of a chessboard (Zhang, PAMI 22, 2000)."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, isfinite, radians

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera_model import PinholeModel
from vision.image import Floats, Pixels, VisionError, grey_pixels

FEWEST_VIEWS = 6
"""Different views of the chessboard that a calibration needs."""
_LARGEST_ERROR = 1.5  # px rms, above which a calibration is no use
_LEAST_TILT = radians(12.0)  # of at least one board to another; parallel boards do not determine the focal length
_ALIKE = 0.025  # of the image's width: views are alike if no corner of one is farther from that of the other
_STILL = 0.01  # likewise: from one image of a camera to the next, of a board that is held still
_EDGE = 0.12  # of the image's width or height: a corner that is nearer to an edge shows the distortion there
_SLANT = radians(15.0)  # of a board that is slanted
_SLANTED = 2  # views that are to be slanted sideways, and as many up or down
_UNSURE = 0.005  # of the focal length: standard deviation above which more views are wanted
_SEARCH = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY


@dataclass(frozen=True, slots=True)
class Chessboard:
    """A flat chessboard: inner corners in a row and in a column, one less than squares, and side of a square, m."""

    columns: int
    rows: int
    square: float

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 3 or self.columns == self.rows:
            raise VisionError(
                f"a chessboard needs at least 3 inner corners each way, not the same number; "
                f"not {self.columns} x {self.rows}"
            )
        if not (isfinite(self.square) and self.square > 0.0):
            raise VisionError(f"the side of a square must be more than 0 m, not {self.square:g}")

    @property
    def points(self) -> NDArray[np.float32]:
        """Corners on the board, m, shape (n, 3), float32."""
        points = np.zeros((self.columns * self.rows, 3), np.float32)
        points[:, :2] = np.mgrid[: self.columns, : self.rows].T.reshape(-1, 2) * self.square
        return points

    def corners_in(self, pixels: Pixels) -> Floats | None:
        """Return the corners in an image, px, shape (n, 2), row by row; None if it does not show the whole board.

        Source: Duda and Frese, Accurate detection and localization of checkerboard corners, BMVC 2018.
        """
        grey = grey_pixels(pixels).copy()  # OpenCV equalises it in place
        found, corners = cv2.findChessboardCornersSB(grey, (self.columns, self.rows), flags=_SEARCH)
        return np.asarray(corners, np.float64).reshape(-1, 2) if found else None

    def __str__(self) -> str:
        return f"board of {self.columns} x {self.rows} inner corners"


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """A camera model and how good it is.

    error: rms distance of the corners from where the model has them, px. used: names of the views that count.
    advice: what would make it better, in words; empty if nothing is missing.
    """

    model: PinholeModel
    error: float
    used: tuple[str, ...]
    advice: str


@dataclass(frozen=True, slots=True)
class _View:
    """Corners in one image, px, shape (n, 2). sideways, upwards: by which the board is slanted, about, rad."""

    name: str
    corners: Floats
    sideways: float
    upwards: float


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """A model by some views, None if it is no camera.

    error: rms of the corners, px; errors: of each view. turns: of each board, as rotation vectors. deviation: standard
    deviation of the focal length, as a share of it.
    """

    model: PinholeModel | None
    error: float
    errors: Floats
    turns: Sequence[np.ndarray]
    deviation: float


class CalibrationViews:
    """Collects views of a chessboard that differ, and calibrates the camera by them.

    size: width and height of the images, px; None before the first.
    """

    def __init__(self, board: Chessboard) -> None:
        """Begin without views."""
        self.size: tuple[int, int] | None = None
        self._board = board
        self._first = ""
        self._views: list[_View] = []
        self._before: Floats | None = None  # corners in the image before
        self._fit: _Fit | None = None  # by all views

    def __len__(self) -> int:
        return len(self._views)

    def add(self, name: str, pixels: Pixels, *, is_live: bool = False) -> str:
        """Look for the board in an image; returns why the image is not used, in words, or nothing.

        Args:
            name: Of the image, for messages.
            pixels: Colour or grey.
            is_live: The image before was taken a moment ago, so that a board that moves is seen; it would be blurred.
        Raises:
            VisionError: The image has another size than those before.
        """
        size = (pixels.shape[1], pixels.shape[0])
        if self.size is None:
            self.size, self._first = size, name
        if size != self.size:
            raise VisionError(
                f"{self._first} has {self.size[0]} x {self.size[1]} px and {name} has {size[0]} x {size[1]}; "
                "take all images with one camera at one resolution"
            )
        corners = self._board.corners_in(pixels)
        before, self._before = self._before, corners
        if corners is None:
            return f"does not show the whole {self._board}"
        if is_live and (before is None or _apart(before, corners) > _STILL * size[0]):
            return "shows the board moving; hold it still"
        for view in self._views:
            if _apart(view.corners, corners) < _ALIKE * size[0]:
                return f"is like {view.name}"
        self._views.append(_View(name, corners, *self._slant(corners, size)))
        self._fit = None
        return ""

    def missing(self, views: int = FEWEST_VIEWS) -> list[str]:
        """Return what kinds of views are missing, in words; empty if the camera can be calibrated well.

        Args:
            views: How many are wanted.
        """
        missing = [f"{views - len(self)} more views"] if len(self) < views else []
        if self.size is None or not self._views:
            return missing
        places = np.concatenate([view.corners for view in self._views]) / self.size
        low, high = places.min(axis=0), places.max(axis=0)
        edges = (low[0], "left"), (1.0 - high[0], "right"), (low[1], "upper"), (1.0 - high[1], "lower")
        missing += [f"near the {edge} edge" for distance, edge in edges if distance > _EDGE]
        sideways = sum(abs(view.sideways) > _SLANT for view in self._views)
        upwards = sum(abs(view.upwards) > _SLANT for view in self._views)
        missing += ["slanted sideways"] if sideways < _SLANTED else []
        missing += ["slanted up or down"] if upwards < _SLANTED else []
        if missing or len(self) < FEWEST_VIEWS:
            return missing
        deviation = self._fitted_by_all(self.size).deviation
        if deviation > _UNSURE:
            missing.append(f"nearer or more slanted, since the focal length is known to {deviation:.1%} only")
        return missing

    def solve(self) -> CalibrationResult:
        """Return the camera model by the views.

        Raises:
            VisionError: There are too few, or they do not determine the camera, or do not fit a camera.
        """
        if len(self) < FEWEST_VIEWS or self.size is None:
            raise VisionError(
                f"{len(self)} different views of the {self._board} were found; take at least {FEWEST_VIEWS}, "
                "with all corners in view, sharp and evenly lit"
            )
        views = self._views
        fit = self._fitted_by_all(self.size)
        most = max(0.5, 3.0 * float(np.median(fit.errors)))
        good = [view for view, own in zip(views, fit.errors, strict=True) if own <= most]
        if FEWEST_VIEWS <= len(good) < len(views):  # without images that fit much worse than the others
            views = good
            fit = self._fitted(views, self.size)
        normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in fit.turns])
        if np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)) < _LEAST_TILT:
            raise VisionError("the board is parallel in all images; tilt it by 20 to 40 degrees in some of them")
        if not fit.error <= _LARGEST_ERROR or fit.model is None:
            raise VisionError(
                f"the corners are {fit.error:.1f} px from where a camera would have them, and {_LARGEST_ERROR} px are "
                "allowed; check the number of corners, and take sharp images of a flat board"
            )
        lacking = self.missing()
        advice = f"better with views {', '.join(lacking)}" if lacking else ""
        return CalibrationResult(fit.model, fit.error, tuple(view.name for view in views), advice)

    def _fitted_by_all(self, size: tuple[int, int]) -> _Fit:
        if self._fit is None:
            self._fit = self._fitted(self._views, size)
        return self._fit

    def _fitted(self, views: Sequence[_View], size: tuple[int, int]) -> _Fit:
        """Return the model by some views."""
        flags = cv2.CALIB_FIX_K3  # a third radial coefficient is not determined by a few images
        boards = [self._board.points] * len(views)
        corners = [view.corners.astype(np.float32) for view in views]
        # The matrices are not read with these flags; they are written.
        result = cv2.calibrateCameraExtended(boards, corners, size, np.eye(3), np.zeros(5), flags=flags)
        error, matrix, distortion, turns = result[0], result[1], result[2].ravel(), result[3]
        try:
            model = PinholeModel(
                *size,
                *(round(float(matrix[at]), 4) for at in ((0, 0), (1, 1), (0, 2), (1, 2))),  # the last digits depend
                *(round(each, 6) for each in distortion[:5].tolist()),  # on the threads of OpenCV
            )
        except VisionError:  # infinite or negative: the caller reports the error in px
            model = None
        focal, deviations = np.array([matrix[0, 0], matrix[1, 1]]), result[5].ravel()[:2]
        deviation = float((deviations / np.abs(focal)).max())
        return _Fit(model, round(float(error), 4), np.asarray(result[7].ravel(), np.float64), turns, deviation)

    def _slant(self, corners: Floats, size: tuple[int, int]) -> tuple[float, float]:
        """Return by how much a board is slanted sideways and upwards, rad, for a camera with a usual lens."""
        focal = float(max(size))
        matrix = np.array([[focal, 0.0, size[0] / 2.0], [0.0, focal, size[1] / 2.0], [0.0, 0.0, 1.0]])
        found, turn, _ = cv2.solvePnP(self._board.points, corners, matrix, None)
        if not found:
            return 0.0, 0.0
        x, y, z = cv2.Rodrigues(turn)[0][:, 2].tolist()
        return atan2(x, abs(z)), atan2(y, abs(z))


def _apart(first: Floats, second: Floats) -> float:
    """Return the largest distance between the same corners of two views, px."""
    return float(np.linalg.norm(first - second, axis=1).max())

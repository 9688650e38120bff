"""Optical flow between images of the bus, and time to contact. Loads OpenCV."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import tan
from typing import Any

import cv2
import numpy as np

from agents.components.component import known
from agents.components.vision.flow_inputs import GAP, CameraMotion, FlowOptions
from agents.components.vision.image_tools import ImageTools
from vision.camera_model import PinholeModel, camera_model
from vision.contact import WIDTH, ContactEstimator, ContactParameters
from vision.flow import FlowGeometry, dense_flow, sparse_flow, yaw_vector
from vision.image import Floats, Image, Pixels, VisionError, grey_pixels

SMALLEST = 16
"""Width and height of an image, px."""
NO_MODEL = "the field of view of the camera is not known, so there are no times; set camera.field_of_view_rad"
_STEP = 8  # px of the image that is worked on, from one vector of a dense flow to the next
_FEWEST = 3  # corners that a column needs
_EXPANSION = 2.0  # px of expansion in the last frame before contact, that a corner needs for a time


@dataclass(frozen=True, slots=True, eq=False)
class _Compared:
    """Two images compared: vectors at points, px of the small image, with and without the camera's rotation.

    points, flow, translation: shape (n, 2); translation is None if the rotation is not known.
    interval: s. rates, deviations: 1/s by column. yaw: rad within the interval. focus: px.
    """

    points: Floats
    flow: Floats
    translation: Floats | None
    interval: float
    yaw: float | None
    rates: Floats
    deviations: Floats
    focus: tuple[float, float] | None = None


class FlowTools(ImageTools):
    """Compares images as they come."""

    def __init__(self, *, has_noise: bool) -> None:
        """Begin with no image.

        Args:
            has_noise: As for `ImageTools`.
        """
        super().__init__(has_noise=has_noise)
        self._before: tuple[Pixels, float] | None = None  # small, and its stamp, s
        self._made_for: object = None
        self._estimator: ContactEstimator | None = None
        self._geometry: FlowGeometry | None = None

    @property
    def stamp(self) -> float | None:
        """Stamp of the image with which the next one is compared, s."""
        return self._before[1] if self._before else None

    def result(
        self, image: Image, stamp: float, motion: CameraMotion, properties: Mapping[str, Any], options: FlowOptions
    ) -> dict[str, Any]:
        """Return flow, rates and times by column; an interval of None if there is no image to compare with.

        Raises:
            VisionError: The image is too small, or the properties describe no camera.
        """
        width = min(WIDTH, image.width)
        size = width, round(image.height * width / image.width)
        if min(size) < SMALLEST:
            raise VisionError(
                f"optical flow needs images of at least {SMALLEST} x {SMALLEST} px, not {image.width} x {image.height}"
            )
        small = np.asarray(cv2.resize(grey_pixels(image.pixels), size, interpolation=cv2.INTER_AREA), np.uint8)
        camera = camera_model(properties, *size)
        if self._made_for != (size, camera, options):
            self._made_for, self._before = (size, camera, options), None
            is_dense = options.method == "dense"
            self._estimator = (
                ContactEstimator(camera, ContactParameters(options.columns)) if camera and is_dense else None
            )
            self._geometry = FlowGeometry(camera) if camera and not is_dense else None
        before, self._before = self._before, (small, stamp)
        dt = stamp - before[1] if before else 0.0
        if before is None or not 0.0 < dt <= GAP:
            if self._estimator:
                self._estimator.reset()
                self._estimator.update(small, GAP)
            return {"interval": None, "trouble": self.trouble}
        if self._estimator:
            compared = self._contact(self._estimator, small, dt, motion, options.ahead)
        elif options.method == "dense":
            compared = _without_times(*_sampled(dense_flow(before[0], small)), dt, options.columns)
        else:
            points, flow = sparse_flow(before[0], small)
            compared = _without_times(points, flow, dt, options.columns)
            if self._geometry is not None and motion.yaw is not None:
                compared = _with_times(self._geometry, compared, motion, options)
        scale = image.width / width
        return self._described(compared, camera, motion, options, scale, width)

    def _contact(
        self, estimator: ContactEstimator, small: Pixels, dt: float, motion: CameraMotion, ahead: float
    ) -> _Compared:
        result = estimator.update(small, dt, motion.yaw, motion.pan, motion.tilt, motion.way(dt, ahead))
        assert result is not None  # it has taken an image before
        points, flow = _sampled(result.flow)
        rates = 1.0 / result.times  # infinite where nothing comes nearer
        return _Compared(
            points,
            flow,
            _sampled(result.translation)[1],
            result.interval,
            result.yaw,
            rates,
            result.deviations,
            result.focus,
        )

    def _described(
        self,
        compared: _Compared,
        camera: PinholeModel | None,
        motion: CameraMotion,
        options: FlowOptions,
        scale: float,
        width: int,
    ) -> dict[str, Any]:
        """Return the result in px of the camera's image and in seconds. scale: px of it for one of the small image."""
        edges = np.linspace(-0.5, width - 0.5, options.columns + 1)
        column = np.clip(np.searchsorted(edges, compared.points[:, 0]) - 1, 0, options.columns - 1)
        speed = scale / compared.interval
        times = [1.0 / rate if rate > 1e-3 else np.nan for rate in compared.rates.tolist()]
        rotation = None if compared.translation is None else "flow" if motion.yaw is None else "odometry"
        bearings = None
        if camera is not None:
            middles = np.stack(((edges[1:] + edges[:-1]) / 2.0, np.full(options.columns, camera.cy)), axis=1)
            bearings = [known(angle) for angle in np.arctan(camera.rays_of(middles)[:, 1]).tolist()]
        trouble = self.trouble or (NO_MODEL if camera is None else None)
        result: dict[str, Any] = {
            "trouble": trouble,
            "method": options.method,
            "interval": known(compared.interval),
            "ahead": options.ahead,
            "yaw": None if compared.yaw is None else known(compared.yaw),
            "rotation": rotation,
            "bearings": bearings,
            "flow": _medians(compared.flow * speed, column, options.columns),
            "translation": None
            if compared.translation is None
            else _medians(compared.translation * speed, column, options.columns),
            "rates": [known(rate) for rate in compared.rates.tolist()],
            "times": [known(time, 3) for time in times],
            "deviations": [known(deviation) for deviation in compared.deviations.tolist()],
            "focus": None
            if compared.focus is None
            else [known((each + 0.5) * scale - 0.5, 1) for each in compared.focus],
        }
        if options.vectors:
            both = np.hstack(((compared.points + 0.5) * scale - 0.5, compared.flow * speed))
            result["vectors"] = np.round(both, 1).tolist()
        return result


def _sampled(field: Floats) -> tuple[Floats, Floats]:
    """Return points of a dense field in a grid, and the vectors there."""
    rows, columns = np.mgrid[_STEP // 2 : field.shape[0] : _STEP, _STEP // 2 : field.shape[1] : _STEP]
    points = np.stack((columns.ravel(), rows.ravel()), axis=1).astype(np.float64)
    return points, field[rows.ravel(), columns.ravel()]


def _without_times(points: Floats, flow: Floats, dt: float, columns: int) -> _Compared:
    unknown = np.full(columns, np.nan)
    return _Compared(points, flow, None, dt, None, unknown, unknown)


def _with_times(geometry: FlowGeometry, compared: _Compared, motion: CameraMotion, options: FlowOptions) -> _Compared:
    """Return the same with times: in each column the median over the corners in a strip at the horizon."""
    assert motion.yaw is not None
    columns, travel = options.columns, motion.yaw / 2.0 - motion.pan + motion.slip(options.ahead)
    strip = ContactParameters(columns)
    at = np.rint(compared.points).astype(int)
    rows, across = at[:, 1], at[:, 0]
    translation = compared.flow - geometry.of_rotation(yaw_vector(motion.yaw, motion.tilt))[rows, across]
    expansion = geometry.of_expansion((tan(min(max(travel, -1.2), 1.2)), -tan(motion.tilt)))[rows, across]
    square = (expansion**2).sum(axis=1)
    rate = (translation * expansion).sum(axis=1) / np.maximum(square, 1e-9) / compared.interval
    elevation = np.arctan(geometry.slopes[rows, across, 1]) + motion.tilt
    usable = (square > _EXPANSION**2) & (elevation < strip.above) & (elevation > -strip.below)
    column = across * columns // geometry.camera.width
    rates, deviations = np.full(columns, np.nan), np.full(columns, np.nan)
    for number in range(columns):
        own = rate[usable & (column == number)]
        if len(own) >= _FEWEST:
            rates[number] = max(0.0, float(np.median(own)))
            deviations[number] = 1.4826 * float(np.median(np.abs(own - np.median(own))))
    return _Compared(
        compared.points, compared.flow, translation, compared.interval, motion.yaw, rates, deviations, None
    )


def _medians(vectors: Floats, column: np.ndarray, columns: int) -> list[list[float | None] | None]:
    """Return the median vector of each column, [right, down]; None where there are too few."""
    result: list[list[float | None] | None] = []
    for number in range(columns):
        own = vectors[column == number]
        if len(own) < _FEWEST:
            result.append(None)
            continue
        ordered = np.sort(own, axis=0)  # several times faster than np.median for so few
        middle = (ordered[(len(own) - 1) // 2] + ordered[len(own) // 2]) / 2.0
        result.append([known(each, 2) for each in middle.tolist()])
    return result

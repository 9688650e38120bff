"""Time to contact for each column of the image, from optical flow alone: neither speed nor distances are needed.

The flow without the camera's rotation grows with the distance from the focus of expansion and with 1 / time to contact
(Lee, Perception 5, 1976). Each column is the weighted median over its pixels, of the component along the gradient of
brightness, which is the one that can be seen; a Kalman filter for each column follows the approach.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import atan2, radians, tan

import cv2
import numpy as np

from vision.camera_model import PinholeModel
from vision.flow import FlowGeometry, dense_flow, yaw_vector
from vision.image import Floats, Pixels, VisionError, grey_pixels

WIDTH = 160
"""Columns of the image that is worked on; larger ones are made smaller."""
_TEXTURE = 8.0  # grey levels for each px, of a gradient that counts half
_STEP = 2  # only each so many pixels each way are used
_FEWEST = 8.0  # pixels with good texture and expansion that a column needs
_FLOW = 2.5  # px of flow that are aimed at, by comparing with an earlier image
_TURN = 6.0  # px of flow by rotation that are allowed for that
_SAME = 0.05  # mean difference, of 255, of images that are taken for one and the same
_CHANGE = 0.5  # 1/s, by which 1 / time to contact may change by itself, relative to its value and more
_SURPRISE = 4.0  # standard deviations, from which on the filter begins anew


@dataclass(frozen=True, slots=True)
class ContactParameters:
    """Parameters of the time to contact.

    columns: of the result. above, below: rad from the horizon to the top and bottom of the strip that is used, which
    the floor must not fill. history: s that the image may be old with which the latest one is compared.
    """

    columns: int = 16
    above: float = radians(25.0)
    below: float = radians(8.0)
    history: float = 0.5

    def __post_init__(self) -> None:
        if not 1 <= self.columns <= 80 or min(self.above, self.below, self.history) <= 0.0:
            raise VisionError("there must be 1 to 80 columns, and the strip and the history must be positive")


@dataclass(frozen=True, slots=True, eq=False)
class ContactResult:
    """Flow and time to contact of one image.

    flow: px for each pixel since the image that was compared, shape (height, width, 2), of at most 160 columns.
    translation: the same without rotation. interval: s between both images. yaw: rad that the camera turned meanwhile.
    focus: px of the focus of expansion that the flow has; None where it has none.
    bearings: of the columns from left to right, rad, left positive. times: s to contact; inf where nothing comes
    nearer, NaN where it is not known. deviations: standard deviations of 1 / times, 1/s.
    """

    flow: Floats
    translation: Floats
    interval: float
    yaw: float
    focus: tuple[float, float] | None
    bearings: Floats
    times: Floats
    deviations: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Earlier:
    """An earlier image. age: s. turned: rad by which the camera turned since. ahead, aside: m that it was carried."""

    image: Pixels
    age: float = 0.0
    turned: float = 0.0
    ahead: float = 0.0
    aside: float = 0.0

    @property
    def slip(self) -> float:
        """Angle from the robot's chord to the direction in which the camera was carried, rad."""
        return atan2(self.aside, self.ahead) if self.ahead > 0.0 else 0.0

    def later(self, dt: float, turn: float, way: tuple[float, float]) -> "_Earlier":
        """Return it dt s later, after a turn of the camera, rad, and a way ahead and aside, m."""
        return replace(
            self,
            age=self.age + dt,
            turned=self.turned + turn,
            ahead=self.ahead + way[0],
            aside=self.aside + way[1],
        )


class ContactEstimator:
    """Takes images of one camera as they come."""

    def __init__(self, camera: PinholeModel, parameters: ContactParameters | None = None) -> None:
        self._parameters = parameters or ContactParameters()
        self._given = (camera.height, camera.width)
        width = min(WIDTH, camera.width)
        self._camera = camera.scaled(width, max(16, round(camera.height * width / camera.width)))
        self._geometry = FlowGeometry(self._camera)
        count = self._parameters.columns
        edges = np.linspace(-0.5, width - 0.5, count + 1)
        owner = np.clip(np.searchsorted(edges, np.arange(0, width, _STEP)) - 1, 0, count - 1)
        most = int(np.bincount(owner, minlength=count).max())
        self._pixels = np.full((count, most), len(owner))  # of each column, one in `_STEP`; none where a row has fewer
        for number in range(count):
            own = np.flatnonzero(owner == number)
            self._pixels[number, : len(own)] = own
        middles = np.stack(((edges[1:] + edges[:-1]) / 2.0, np.full(count, self._camera.cy)), axis=1)
        self.bearings: Floats = np.arctan(self._camera.rays_of(middles)[:, 1])
        ends = np.arctan(self._camera.rays_of(np.stack((edges, np.full(count + 1, self._camera.cy)), axis=1))[:, 1])
        self._edges = np.stack((ends[:-1], ends[1:]), axis=1)  # rad, left and right, of each column
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._history: deque[_Earlier] = deque()
        self._rate = np.full(self._parameters.columns, np.nan)
        self._variance = np.full(self._parameters.columns, np.inf)
        self._turn, self._step = 0.0, 1.0  # rad by which the camera turned in the last time step, and its s
        self._speed = 0.0  # px/s of the flow without rotation, about

    def update(
        self,
        pixels: Pixels,
        dt: float,
        yaw: float | None = None,
        pan: float = 0.0,
        tilt: float = 0.0,
        way: tuple[float, float] = (0.0, 0.0),
    ) -> ContactResult | None:
        """Take the next image; returns the result, or None of the first one.

        An image that equals the one before says nothing: the camera may be frozen. All times are NaN then.

        Args:
            pixels: Colour or grey, of the camera's size.
            dt: s since the image before.
            yaw: Rotation of the camera since the image before, rad, left positive; None to estimate it from the flow.
            pan, tilt: Direction of the camera to the robot's front, rad, left and up positive.
            way: By how much the robot has carried the camera forward and to the left since the image before; only the
                ratio counts. A camera before the axle moves sideways in turns. Zeros: straight ahead.
        Raises:
            VisionError: The image has another size, or dt is not positive.
        """
        if not 0.0 < dt < 1e6:
            raise VisionError(f"the time between two images must be positive, not {dt:g} s")
        grey = grey_pixels(pixels)
        if grey.shape != self._given:
            raise VisionError(f"the image has the shape {grey.shape} and the camera {self._given}; scale the model")
        size = (self._camera.width, self._camera.height)
        small = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.uint8)
        self._turn = self._turn / self._step * dt if yaw is None else yaw
        self._step = dt
        self._history = deque(each.later(dt, self._turn, way) for each in self._history)
        while len(self._history) > 1 and self._history[1].age >= self._parameters.history:
            self._history.popleft()
        result = self._compared(small, dt, yaw, pan, tilt) if self._history else None
        self._history.append(_Earlier(small))
        return result

    def _compared(self, image: Pixels, dt: float, yaw: float | None, pan: float, tilt: float) -> ContactResult:
        if float(np.mean(cv2.absdiff(image, self._history[-1].image))) < _SAME:
            self._rate[:], self._variance[:] = np.nan, np.inf
            nothing = np.zeros((*image.shape, 2))
            unknown = np.full(self._parameters.columns, np.nan)
            return ContactResult(nothing, nothing, dt, 0.0, None, self.bearings, unknown, unknown.copy())
        partner = self._partner()
        before, interval, turned = partner.image, partner.age, partner.turned
        flow = dense_flow(before, image)
        across, down = (cv2.Sobel(before, cv2.CV_32F, *order, ksize=3, scale=0.125) for order in ((1, 0), (0, 1)))
        gradient = np.stack((across, down), axis=2).astype(np.float64)
        strength = (gradient**2).sum(axis=2)
        texture = strength / (strength + _TEXTURE**2)
        rotation = yaw_vector(turned, tilt)
        focus = (tan(-pan), -tan(tilt))
        if yaw is None:
            rotation = self._geometry.rotation_in(flow, focus, texture)
            wrong = float(rotation @ yaw_vector(1.0, tilt)) - turned
            self._history = deque(replace(each, turned=each.turned + wrong) for each in self._history)
            self._turn += wrong
            turned += wrong
        # A robot that turns while it drives travels along a chord, half of the turn to the side.
        focus = (tan(np.clip(turned / 2.0 - pan + partner.slip, -1.2, 1.2)), focus[1])
        translation = flow - self._geometry.of_rotation(rotation)
        rate, variance = self._columns(translation, gradient, texture, focus, tilt)
        rate, variance = self._carried(rate, variance, focus[0], turned)
        rate, variance = rate / interval, variance / interval**2
        length = np.linalg.norm(translation[::4, ::4], axis=2)
        self._speed = float(np.median(length)) / interval
        self._filtered(rate, variance, dt, turned * dt / interval)
        return ContactResult(
            flow,
            translation,
            interval,
            turned,
            self._focus(translation, texture),
            self.bearings,
            np.where(
                np.isnan(self._rate), np.nan, np.where(self._rate > 1e-3, 1.0 / np.maximum(self._rate, 1e-3), np.inf)
            ),
            np.sqrt(self._variance),
        )

    def _partner(self) -> "_Earlier":
        """Return the image to compare with: as old as the flow needs to be measured well, without too much rotation."""
        chosen = self._history[-1]
        for each in reversed(self._history):
            if each.age > self._parameters.history or abs(each.turned) * self._camera.fx > _TURN:
                break
            chosen = each
            if self._speed * each.age >= _FLOW:
                break
        return chosen

    def _columns(
        self, translation: Floats, gradient: Floats, texture: Floats, focus: tuple[float, float], tilt: float
    ) -> tuple[Floats, Floats]:
        """Return 1 / time to contact of each column, in intervals, and its variance; NaN and inf where not known."""
        elevation = np.arctan(self._geometry.slopes[:, self._camera.width // 2, 1]) + tilt
        strip = np.flatnonzero((elevation < self._parameters.above) & (elevation > -self._parameters.below))[::_STEP]
        columns = np.arange(0, self._camera.width, _STEP)
        chosen = np.ix_(strip, columns)
        slopes = gradient[chosen]
        along = slopes / np.maximum(np.hypot(slopes[..., :1], slopes[..., 1:]), 1e-9)
        expansion = (self._geometry.of_expansion(focus, chosen) * along).sum(axis=2)
        moved = (translation[chosen] * along).sum(axis=2)
        weights = texture[chosen] * np.abs(expansion)
        rates = moved / np.where(np.abs(expansion) < 1.0, np.copysign(1.0, expansion), expansion)
        weights[np.abs(expansion) < 2.0] = 0.0
        # All pixels of a column are one row, which ends with pixels without weight where it has fewer than others.
        at = np.minimum(self._pixels, len(columns) - 1)
        count = len(at)
        values = rates[:, at].transpose(1, 0, 2).reshape(count, -1)
        weights = np.where(self._pixels < len(columns), weights[:, at], 0.0).transpose(1, 0, 2).reshape(count, -1)
        middles, spreads, full = _weighted_medians(values, weights)
        good = np.where(weights > 0.0, texture[chosen][:, at].transpose(1, 0, 2).reshape(count, -1), 0.0).sum(axis=1)
        full = np.minimum(full, good)
        enough = full >= _FEWEST
        result = np.where(enough, middles, np.nan)
        # Neighbouring pixels share their flow.
        variance = np.where(enough, spreads**2 / np.maximum(full, 1.0) * 4.0 + 1e-6, np.inf)
        return result, variance

    def _carried(self, rate: Floats, variance: Floats, focus: float, turned: float) -> tuple[Floats, Floats]:
        """Return rates, per interval, by the columns in which things are now; flow is measured where they were before.

        Where several things are in one column, the nearest counts. focus: slope of the direction of travel. turned: rad
        in the interval.
        """
        slopes = focus + (np.tan(self._edges) - focus) * (1.0 + rate)[:, None]
        ends = np.arctan(slopes) - turned
        is_there = (self.bearings <= ends[:, :1]) & (self.bearings >= ends[:, 1:])
        inside = np.where(is_there, rate[:, None], -np.inf)
        nearest = np.argmax(inside, axis=0)
        is_known = is_there.any(axis=0)
        return np.where(is_known, rate[nearest], np.nan), np.where(is_known, variance[nearest], np.inf)

    def _filtered(self, rate: Floats, variance: Floats, dt: float, yaw: float) -> None:
        """Take a measurement of all columns into the filters, 1/s. yaw: rad that the camera turned in dt."""
        known = ~np.isnan(self._rate)
        if known.any() and yaw:
            order = np.argsort(self.bearings)
            at = self.bearings[order]
            self._rate = np.interp(self.bearings + yaw, at, self._rate[order], np.nan, np.nan)
            self._variance = np.where(np.isnan(self._rate), np.inf, self._variance)
        predicted = self._rate / np.maximum(1.0 - self._rate * dt, 0.2)  # the time to contact has become shorter by dt
        spread = self._variance + (_CHANGE * (np.abs(np.nan_to_num(predicted)) + 0.05)) ** 2 * dt
        measured = ~np.isnan(rate)
        fresh = np.isnan(predicted) | (np.abs(rate - predicted) > _SURPRISE * np.sqrt(spread + variance))
        with np.errstate(invalid="ignore"):  # inf / inf of columns that are not known, which are replaced below
            gain = np.where(fresh, 1.0, spread / (spread + variance))
            kept = (1.0 - gain) * spread
        self._rate = np.where(measured, np.where(fresh, rate, predicted + gain * (rate - predicted)), predicted)
        self._variance = np.where(measured, np.where(fresh, variance, kept), spread)
        lost = ~measured & (self._variance > (0.5 * np.abs(np.nan_to_num(self._rate)) + 0.05) ** 2)
        self._rate[lost], self._variance[lost] = np.nan, np.inf

    def _focus(self, translation: Floats, texture: Floats) -> tuple[float, float] | None:
        slopes = self._geometry.focus_in(translation, texture)
        if slopes is None:
            return None
        x, y = self._camera.pixels_of(np.array([[1.0, *slopes]]))[0].tolist()
        return x, y


def _weighted_medians(values: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """Return for each row the weighted median, the deviation about it, and how many full weights there are."""
    middles = _medians(values, weights)
    spreads = 1.4826 * _medians(np.abs(values - middles[:, None]), weights)
    squares = (weights**2).sum(axis=1)
    return middles, spreads, weights.sum(axis=1) ** 2 / np.where(squares > 0.0, squares, 1.0)


def _medians(values: Floats, weights: Floats) -> Floats:
    order = np.argsort(values, axis=1)
    total = np.cumsum(np.take_along_axis(weights, order, axis=1), axis=1)
    half = (total < total[:, -1:] / 2.0).sum(axis=1)
    return np.asarray(np.take_along_axis(values, np.take_along_axis(order, half[:, None], axis=1), axis=1)[:, 0])

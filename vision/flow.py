"""Optical flow: dense or at corners, and the part of it that comes from the camera's own rotation.

For a camera that moves, the flow of a pixel is that of its rotation, the same for all depths, plus a movement away from
the focus of expansion by its distance from there over the time to contact (Longuet-Higgins and Prazdny, Proc. R. Soc.
Lond. B 208, 1980).
"""

from math import cos, sin
from typing import Any

import cv2
import numpy as np

from vision.camera_model import PinholeModel
from vision.image import Floats, Pixels, VisionError, grey_pixels

_SMALL = 200  # px wide; smaller images are compared at a finer scale
_CORNERS = 200
_BACK = 0.5  # px by which a corner may miss its place when it is followed back
_WINDOW = (15, 15)
_LEVELS = 3
_ROUNDS = 5  # of the robust fit of a rotation
_WRONG = 0.3  # px of a flow's component that should be none, from which on it counts less


def dense_flow(before: Pixels, after: Pixels) -> Floats:
    """Return for each pixel of an image where it is in the next, px to the right and down, shape (height, width, 2).

    Source: Kroeger et al., "Fast optical flow using dense inverse search", ECCV 2016.

    Raises:
        VisionError: The images have different sizes, or are smaller than 16 x 16 px.
    """
    one, two = _same_size(before, after)
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    if one.shape[1] <= _SMALL:
        search.setFinestScale(1)  # the preset's is 2, a quarter of the size: 40 px of 160, in which edges are lost
    return np.asarray(search.calc(one, two, None), np.float64)  # type: ignore[call-overload]  # the stubs demand a matrix where OpenCV takes None


def sparse_flow(before: Pixels, after: Pixels, points: Floats | None = None) -> tuple[Floats, Floats]:
    """Return points of an image and where they moved, both of shape (n, 2), px.

    Points that cannot be followed to the next image and back are left out.

    Args:
        before, after: Colour or grey images of one size.
        points: To follow, shape (n, 2); corners of the first image where it is None.

    Source: Bouguet, "Pyramidal implementation of the Lucas Kanade feature tracker", 2000.

    Raises:
        VisionError: The images have different sizes, or are smaller than 16 x 16 px.
    """
    one, two = _same_size(before, after)
    if points is None:
        found = cv2.goodFeaturesToTrack(one, _CORNERS, 0.01, 5.0)
        points = np.zeros((0, 2)) if found is None else np.asarray(found, np.float64).reshape(-1, 2)
    start = np.asarray(points, np.float32).reshape(-1, 1, 2)
    if not len(start):
        return np.zeros((0, 2)), np.zeros((0, 2))
    moved, is_there, _ = cv2.calcOpticalFlowPyrLK(one, two, start, start.copy(), winSize=_WINDOW, maxLevel=_LEVELS)
    back, is_back, _ = cv2.calcOpticalFlowPyrLK(two, one, moved, moved.copy(), winSize=_WINDOW, maxLevel=_LEVELS)
    good = (is_there.ravel() == 1) & (is_back.ravel() == 1)
    good &= np.linalg.norm((back - start).reshape(-1, 2), axis=1) < _BACK
    kept = start.reshape(-1, 2)[good]
    return np.asarray(kept, np.float64), np.asarray(moved.reshape(-1, 2)[good] - kept, np.float64)


class FlowGeometry:
    """What the flow of each pixel means for one camera.

    Rotations are vectors about the axes of the camera, x forward, y left, z up: roll, pitch, yaw.

    slopes: y / x and z / x of the ray through each pixel, shape (height, width, 2).
    """

    def __init__(self, camera: PinholeModel) -> None:
        self.camera = camera
        columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        pixels = np.stack((columns, rows), axis=2).reshape(-1, 2).astype(np.float64)
        shape = (camera.height, camera.width)
        self._pixels = pixels.reshape(*shape, 2)
        self._rays = camera.rays_of(pixels)
        self.slopes: Floats = self._rays[:, 1:].reshape(*shape, 2)
        # Pixels for a small change of each slope: the inverse of the derivative of slopes by pixels.
        by_column, by_row = (np.asarray(np.gradient(self.slopes, axis=axis)) for axis in (1, 0))
        self._per_slope: Floats = np.linalg.inv(np.stack((by_column, by_row), axis=3))
        self._slope_per: Floats = np.asarray(np.linalg.inv(self._per_slope), np.float64)
        y, z = self.slopes[..., 0], self.slopes[..., 1]
        one_by_one = np.stack(
            (
                np.stack((z, -y), axis=2),
                np.stack((y * z, 1.0 + z * z), axis=2),
                np.stack((-1.0 - y * y, -y * z), axis=2),
            )
        )
        self._rotations = np.einsum("rcij,krcj->rcik", self._per_slope, one_by_one)

    def of_rotation(self, rotation: Floats) -> Floats:
        """Return the flow by a rotation of the camera, shape (height, width, 2), px.

        Args:
            rotation: Vector in the frame of the camera before it, rad.
        """
        turned = self._rays @ cv2.Rodrigues(np.asarray(rotation, np.float64))[0]
        flow: Floats = self.camera.pixels_of(turned).reshape(self._pixels.shape) - self._pixels
        return flow

    def of_expansion(self, focus: tuple[float, float], chosen: Any = ...) -> Floats:
        """Return the flow of things that are one frame before contact, shape (height, width, 2), px.

        That of others is this over their time to contact, counted in frames.

        Args:
            focus: y / x and z / x of the direction of travel.
            chosen: Index of the rows and columns of the result; all by default.
        """
        away, per_slope = self.slopes[chosen] - np.array(focus), self._per_slope[chosen]
        # Written out here and below, since NumPy multiplies many small matrices slowly.
        flow: Floats = per_slope[..., 0] * away[..., :1] + per_slope[..., 1] * away[..., 1:]
        return flow

    def rotation_in(self, flow: Floats, focus: tuple[float, float], weights: Floats, step: int = 4) -> Floats:
        """Return the rotation of the camera, estimated from the flow alone: vector in the frame of the camera, rad.

        Across the direction from the focus of expansion there is no flow but that of the rotation, whatever the depths.

        Args:
            flow: Dense flow, px.
            focus: y / x and z / x of the direction of travel.
            weights: Of the pixels, such as how much texture they have, shape (height, width).
            step: Only each so many pixels each way are used.
        """
        expansion = self.of_expansion(focus, np.s_[::step, ::step]).reshape(-1, 2)
        length = np.linalg.norm(expansion, axis=1)
        across = np.stack((-expansion[:, 1], expansion[:, 0]), axis=1) / np.maximum(length, 1e-9)[:, None]
        system = np.einsum("nik,ni->nk", self._rotations[::step, ::step].reshape(-1, 2, 3), across)
        right = (flow[::step, ::step].reshape(-1, 2) * across).sum(axis=1)
        trust = weights[::step, ::step].ravel() * np.minimum(1.0, length / 5.0)
        rotation = np.zeros(3)
        robust = trust
        for _ in range(_ROUNDS):
            normal = (system.T * robust) @ system + np.eye(3) * 1e-3
            rotation = np.linalg.solve(normal, (system.T * robust) @ right)
            robust = trust / (1.0 + ((right - system @ rotation) / _WRONG) ** 2)
        return rotation

    def focus_in(self, flow: Floats, weights: Floats, step: int = 4) -> tuple[float, float] | None:
        """Return the focus of expansion of a flow without rotation, as slopes; None where there is too little flow.

        It is the point nearest to the lines along the flow of all pixels.
        """
        slope_per, part = self._slope_per[::step, ::step], flow[::step, ::step]
        along = (slope_per[..., 0] * part[..., :1] + slope_per[..., 1] * part[..., 1:]).reshape(-1, 2)
        length = np.linalg.norm(flow[::step, ::step].reshape(-1, 2), axis=1)
        across = np.stack((-along[:, 1], along[:, 0]), axis=1)
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        right = (across * self.slopes[::step, ::step].reshape(-1, 2)).sum(axis=1)
        trust = weights[::step, ::step].ravel() * np.minimum(1.0, length) ** 2
        if trust.sum() < 10.0:
            return None
        robust, focus = trust, np.zeros(2)
        for _ in range(_ROUNDS):
            normal = (across.T * robust) @ across + np.eye(2) * 1e-6
            focus = np.linalg.solve(normal, (across.T * robust) @ right)
            robust = trust / (1.0 + ((right - across @ focus) / 0.05) ** 2)
        return float(focus[0]), float(focus[1])


def yaw_vector(yaw: float, tilt: float = 0.0) -> Floats:
    """Return a rotation about the vertical (rad, left positive) in the frame of a camera that is tilted up, rad."""
    return np.array([sin(tilt), 0.0, cos(tilt)]) * yaw


def _same_size(before: Pixels, after: Pixels) -> tuple[Pixels, Pixels]:
    one, two = grey_pixels(before), grey_pixels(after)
    if one.shape != two.shape:
        raise VisionError(f"optical flow needs two images of one size, not of {one.shape} and {two.shape} px")
    if min(one.shape) < 16:
        raise VisionError(f"optical flow needs images of at least 16 x 16 px, not {one.shape[1]} x {one.shape[0]}")
    return one, two

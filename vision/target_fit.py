"""Pose of a target by its edges: they are searched across their predicted places, and the pose follows.

The method is that of RAPID (Harris and Stennett, BMVC 1990) with colour: an edge is where the image crosses half of the
way from the colour inside the rectangle to that outside. Poses are in the levelled frame of the camera: origin in the
camera, x forward, y left, z up, without the camera's tilt.
"""

from dataclasses import dataclass
from math import cos, radians, sin

import cv2
import numpy as np

from vision.camera_model import PinholeModel
from vision.image import Floats, Pixels

LEANING = radians(1.5)
"""Standard deviation of pitch and roll of a target to the camera: floors are not plane, robots pitch."""

_PER_EDGE = 8  # samples along an edge
_ACROSS = 17  # samples across it
_REACHES = (6.0, 4.0, 3.0, 2.5)  # px to each side that are searched, by iteration
_CONTRAST = 25.0  # between inside and outside, of 255, that an edge needs
_ROBUST = 0.4  # px, from which on an edge counts less
_INLIER = 1.0  # px that an edge may be away
_LEAST_NOISE = 0.15  # px; standard deviation of an edge in the best of images
_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0))
_ALONG = np.linspace(0.12, 0.88, _PER_EDGE)


@dataclass(frozen=True, slots=True, eq=False)
class TargetFit:
    """A pose and how well it agrees with the image.

    pose: x, y, z (m), yaw, pitch, roll (rad). deviations: their standard deviations. error: rms of the edges, px.
    support: share of the edges of each rectangle that are where the pose has them, of those that can be seen.
    seen: share of each rectangle's samples that can be seen: inside the image and not behind another rectangle.
    """

    pose: Floats
    deviations: Floats
    error: float
    support: Floats
    seen: Floats


def placed(points: Floats, pose: Floats, tilt: float) -> Floats:
    """Return points of the target in the frame of the camera, shape (n, 3).

    Args:
        points: Shape (n, 3), in the target's frame.
        pose: x, y, z, yaw, pitch, roll in the levelled frame.
        tilt: Of the camera, rad, up.
    """
    x, y, z, yaw, pitch, roll = pose
    about_z = np.array([[cos(yaw), -sin(yaw), 0.0], [sin(yaw), cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cos(pitch), 0.0, sin(pitch)], [0.0, 1.0, 0.0], [-sin(pitch), 0.0, cos(pitch)]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cos(roll), -sin(roll)], [0.0, sin(roll), cos(roll)]])
    untilted = np.array([[cos(tilt), 0.0, sin(tilt)], [0.0, 1.0, 0.0], [-sin(tilt), 0.0, cos(tilt)]])
    result: Floats = (points @ (about_z @ about_y @ about_x).T + np.array([x, y, z])) @ untilted.T
    return result


def fit(pixels: Pixels, camera: PinholeModel, corners: Floats, start: Floats, tilt: float) -> TargetFit | None:
    """Return the pose that agrees best with the edges in an image; None where it goes astray.

    Args:
        pixels: A colour image.
        camera: Of the size of the image.
        corners: Of the rectangles in the target's frame, shape (n, 4, 3), in their order around each rectangle.
        start: Pose to begin with: x, y, z, yaw, pitch, roll.
        tilt: Of the camera, rad, up.
    """
    pose = start.copy()
    edges = _Edges(pixels, camera, corners, tilt)
    normal = np.eye(6)
    offsets, good = np.zeros(0), np.zeros(0, bool)
    for reach in _REACHES:
        measured = edges.measured(pose, reach)
        if measured is None:
            return None
        offsets, good = measured
        if np.count_nonzero(good) < 12:
            return None
        scale = max(_LEAST_NOISE, 1.4826 * float(np.median(np.abs(offsets[good]))))
        weights = 1.0 / np.maximum(1.0, np.abs(offsets[good]) / _ROBUST) / scale**2
        usable = edges.slopes(pose)[good]
        normal = (usable.T * weights) @ usable + np.diag([1e-9, 1e-9, 1e-9, 1e-9, LEANING**-2, LEANING**-2])
        gradient = (usable.T * weights) @ offsets[good] - np.array([0, 0, 0, 0, pose[4], pose[5]]) / LEANING**2
        pose = pose + np.linalg.solve(normal, gradient)
        if not 0.1 < pose[0] < 50.0 or np.abs(pose[3:]).max() > 3.0:
            return None
    measured = edges.measured(pose, _REACHES[-1])
    if measured is None or not measured[1].any():
        return None
    offsets, good = measured
    near = good & (np.abs(offsets) <= _INLIER)
    visible = edges.visible.reshape(len(corners), -1)
    counts = visible.sum(axis=1)
    support = near.reshape(len(corners), -1).sum(axis=1) / np.maximum(counts, 1)
    error = float(np.sqrt(np.mean(np.minimum(np.abs(offsets[good]), 2.0) ** 2)))
    # Neighbouring samples of one edge see the same pixels, so only some of them are independent.
    deviations = np.sqrt(np.diag(np.linalg.inv(normal)) * 3.0)
    return TargetFit(pose, deviations, error, support, counts / visible.shape[1])


class _Edges:
    """Samples on all edges. visible: which of them the last pose showed, shape (samples,)."""

    def __init__(self, pixels: Pixels, camera: PinholeModel, corners: Floats, tilt: float) -> None:
        self._pixels, self._camera, self._corners, self._tilt = pixels, camera, corners, tilt
        begins, ends = corners[:, [a for a, _ in _EDGES]], corners[:, [b for _, b in _EDGES]]
        points = begins[:, :, None] + (ends - begins)[:, :, None] * _ALONG[:, None]
        self._points: Floats = points.reshape(-1, 3)
        self._per_rectangle = len(_EDGES) * _PER_EDGE
        grid = np.array([(u, v) for u in (0.35, 0.5, 0.65) for v in (0.2, 0.35, 0.5, 0.65, 0.8)])
        across, down = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
        inside = corners[:, :1] + across[:, None] * grid[:, :1] + down[:, None] * grid[:, 1:]
        self._inside: Floats = inside.reshape(-1, 3)
        self.visible = np.zeros(len(self._points), bool)
        self._where = self._outward = np.zeros((len(self._points), 2))

    def measured(self, pose: Floats, reach: float) -> tuple[Floats, np.ndarray] | None:
        """Return how far edges are outside of their predicted place (px), and which are found.

        None where the pose has a part of the target behind the camera.
        """
        count = len(self._points)
        rays = placed(np.concatenate((self._points, self._inside, self._corners.reshape(-1, 3))), pose, self._tilt)
        if rays[:, 0].min() < 0.05:
            return None
        at = self._camera.pixels_of(rays)
        where, inside, corners = at[:count], at[count : count + len(self._inside)], at[count + len(self._inside) :]
        corners = corners.reshape(-1, 4, 2)
        normals, inward = self._normals(corners)
        self.visible = self._visible(where, corners, rays[:, 0].reshape(-1)[-len(corners) * 4 :].reshape(-1, 4))
        offsets, good = self._crossings(where, normals, np.minimum(reach, inward), reach, self._colours(inside))
        self._where, self._outward = where, normals
        return offsets, good & self.visible

    def slopes(self, pose: Floats) -> Floats:
        """Return how far each edge of the measured pose moves outwards by each of its numbers, shape (samples, 6)."""
        step = 1e-4
        moved = [placed(self._points, pose + step * unit, self._tilt) for unit in np.eye(6)]
        shifts = self._camera.pixels_of(np.concatenate(moved)).reshape(6, -1, 2) - self._where
        result: Floats = (shifts * self._outward).sum(axis=2).T / step
        return result

    def _normals(self, corners: Floats) -> tuple[Floats, Floats]:
        """Return for each sample the direction outwards, and how many px it may search inwards."""
        begins, ends = corners[:, [a for a, _ in _EDGES]], corners[:, [b for _, b in _EDGES]]
        along = ends - begins
        along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-9)
        outward = np.stack((along[..., 1], -along[..., 0]), axis=2)
        to_middle = corners.mean(axis=1, keepdims=True) - begins
        across = (to_middle * outward).sum(axis=2)
        outward = np.where(across[..., None] > 0.0, -outward, outward)
        inward = np.maximum(np.abs(across), 0.8)  # half of the rectangle's size
        return np.repeat(outward.reshape(-1, 2), _PER_EDGE, axis=0), np.repeat(inward.ravel(), _PER_EDGE)

    def _visible(self, where: Floats, corners: Floats, depths: Floats) -> np.ndarray:
        """Tell which samples are in the image, and not behind a rectangle that is nearer."""
        height, width = self._pixels.shape[:2]
        inside = (where > 1.5) & (where < np.array([width - 2.5, height - 2.5]))
        visible = np.asarray(inside.all(axis=1))
        owner = np.repeat(np.arange(len(corners)), self._per_rectangle)
        nearness = depths.mean(axis=1)
        for number, outline in enumerate(corners):
            sides = np.roll(outline, -1, axis=0) - outline
            sides /= np.maximum(np.linalg.norm(sides, axis=1, keepdims=True), 1e-9)
            off = where[:, None] - outline
            cross = sides[:, 0] * off[..., 1] - sides[:, 1] * off[..., 0]
            turning = np.sign(cv2.contourArea(outline.astype(np.float32), oriented=True)) or 1.0
            within = (cross * -turning > -1.0).all(axis=1) | (cross * turning > -1.0).all(axis=1)
            visible &= ~(within & (owner != number) & (nearness[owner] > nearness[number]))
        return visible

    def _colours(self, inside: Floats) -> Floats:
        """Return the colour of each rectangle: the median of samples inside."""
        values = self._sampled(inside[:, 0], inside[:, 1]).reshape(len(self._corners), -1, 3)
        result: Floats = np.median(values, axis=1)
        return result

    def _crossings(
        self, where: Floats, normals: Floats, inward: Floats, outward: float, colours: Floats
    ) -> tuple[Floats, np.ndarray]:
        """Return how far outside each edge is found, and whether it is."""
        steps = np.linspace(0.0, 1.0, _ACROSS)
        along = -inward[:, None] + (inward + outward)[:, None] * steps
        x = where[:, :1] + normals[:, :1] * along
        y = where[:, 1:] + normals[:, 1:] * along
        values = self._sampled(x, y)
        own = np.repeat(colours, self._per_rectangle, axis=0)
        beyond = values[:, -4:].mean(axis=1)
        difference = own - beyond
        contrast = np.maximum((difference**2).sum(axis=1), 1e-9)
        share = ((values - beyond[:, None]) * difference[:, None]).sum(axis=2) / contrast[:, None]
        below = share < 0.5
        first = np.argmax(below, axis=1)
        found = below.any(axis=1) & (first > 0) & (contrast > _CONTRAST**2)
        first = np.maximum(first, 1)
        rows = np.arange(len(share))
        high, low = share[rows, first - 1], share[rows, first]
        part = (high - 0.5) / np.maximum(high - low, 1e-9)
        spacing = (inward + outward) / (_ACROSS - 1)
        return -inward + (first - 1 + part) * spacing, found

    def _sampled(self, x: Floats, y: Floats) -> Floats:
        """Return colours at places of the image, in the shape of the places and 3."""
        flat_x, flat_y = x.reshape(-1, 1).astype(np.float32), y.reshape(-1, 1).astype(np.float32)
        values = cv2.remap(self._pixels, flat_x, flat_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(values, np.float64).reshape(*x.shape, 3)

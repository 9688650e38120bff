"""Draws images with known truth: rectangles in space, a room with textured walls, and what a real camera adds.

It projects by its own arithmetic and shares none with the package. Axes: x forward, y left, z up; the camera is in the
origin. Pixel centres have whole coordinates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians, tan

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float64]
COLOURS = ((40, 40, 210), (50, 190, 60), (200, 90, 30))
"""Blue, green and red of left flank, centre and right flank."""
_FINE = 4  # pixels of the drawing for one of the image, each way


@dataclass(frozen=True)
class Camera:
    """A pinhole: size in px and horizontal field of view in rad; tilt up in rad."""

    width: int = 320
    height: int = 240
    view: float = radians(60.0)
    tilt: float = 0.0

    @property
    def focal(self) -> float:
        """Focal length, px."""
        return self.width / 2 / tan(self.view / 2)

    def project(self, points: Floats) -> Floats:
        """Pixels of points (n, 3) in the levelled frame."""
        x, y, z = points.T
        c, s = np.cos(self.tilt), np.sin(self.tilt)
        forward, up = c * x + s * z, c * z - s * x
        return np.stack(
            ((self.width - 1) / 2 - self.focal * y / forward, (self.height - 1) / 2 - self.focal * up / forward), axis=1
        )


@dataclass(frozen=True)
class Flaws:
    """What camera and light do: noise and blur in grey levels and px, gain of the light, JPEG quality (0: none)."""

    noise: float = 3.0
    blur: float = 0.6
    gain: float = 1.0
    quality: int = 85


def background(rng: np.random.Generator, width: int, height: int) -> Pixels:
    """A room without bright colours: patches of brownish and greyish surfaces, and a gradient of light."""
    image = np.full((height, width, 3), rng.integers(90, 170), np.float64)
    for _ in range(25):
        x, y = rng.integers(0, width), rng.integers(0, height)
        w, h = rng.integers(10, width // 2), rng.integers(10, height // 2)
        grey = rng.integers(30, 220)
        image[y : y + h, x : x + w] = np.clip(grey + rng.normal(0.0, 10.0, 3), 0, 255)
    image *= np.linspace(0.8, 1.1, width)[None, :, None]
    return np.clip(image, 0, 255).astype(np.uint8)


def quads(x: float, y: float, z: float, heading: float, roll: float = 0.0) -> list[Floats]:
    """Corners in space of the three rectangles of the standard target, by the middle between its flanks."""
    found = []
    for lateral, ahead in ((0.22, 0.0), (0.0, -0.07), (-0.22, 0.0)):
        outline = ((0.05, 0.1), (-0.05, 0.1), (-0.05, -0.1), (0.05, -0.1))
        corners = np.array([(ahead, lateral + dy, dz) for dy, dz in outline])
        c, s = np.cos(roll), np.sin(roll)
        corners[:, 1:] = corners[:, 1:] @ np.array([[c, s], [-s, c]])
        c, s = np.cos(heading), np.sin(heading)
        corners[:, :2] = corners[:, :2] @ np.array([[c, s], [-s, c]])
        found.append(corners + np.array([x, y, z]))
    return found


def draw(
    camera: Camera,
    surfaces: Sequence[tuple[Floats, tuple[int, int, int]]],
    rng: np.random.Generator,
    flaws: Flaws | None = None,
    covers: Sequence[tuple[int, int, int, int]] = (),
) -> Pixels:
    """Coloured surfaces in space (corners, colour) before a background, the far ones first.

    covers: left, top, width and height in px of grey things in front.
    """
    flaws = flaws or Flaws()
    size = (camera.width * _FINE, camera.height * _FINE)
    fine = cv2.resize(background(rng, camera.width, camera.height), size, interpolation=cv2.INTER_CUBIC)
    for corners, colour in sorted(surfaces, key=lambda each: -float(each[0][:, 0].mean())):
        outline = camera.project(corners) * _FINE + (_FINE - 1) / 2
        cv2.fillPoly(fine, [np.rint(outline * 256).astype(np.int32)], colour, cv2.LINE_AA, 8)
    for left, top, width, height in covers:
        fine[top * _FINE : (top + height) * _FINE, left * _FINE : (left + width) * _FINE] = (95, 105, 100)
    image = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA).astype(np.float64)
    return spoilt(image, rng, flaws)


def spoilt(image: Floats, rng: np.random.Generator, flaws: Flaws) -> Pixels:
    """The image as a camera would deliver it."""
    if flaws.blur:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), flaws.blur), np.float64)
    noisy = np.clip(image * flaws.gain + rng.normal(0.0, flaws.noise, image.shape), 0, 255).astype(np.uint8)
    if not flaws.quality:
        return noisy
    data = cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, flaws.quality])[1]
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR if noisy.ndim == 3 else cv2.IMREAD_GRAYSCALE), np.uint8)


class Room:
    """A box with textured walls, floor and ceiling, grey. The camera is 0.35 m above the floor.

    ahead, left, right: m from the origin to the walls; the wall behind is 3 m away.
    """

    def __init__(self, seed: int, ahead: float = 6.0, left: float = 1.5, right: float = 1.5) -> None:
        self.rng = np.random.default_rng(seed)
        self._walls = ((0, ahead), (0, -3.0), (1, left), (1, -right), (2, -0.35), (2, 2.2))
        self._textures = [self._texture() for _ in self._walls]

    def image(self, camera: Camera, x: float, y: float, heading: float, flaws: Flaws | None = None) -> Pixels:
        """What the camera sees at a place (m) with a heading (rad)."""
        rays = self._rays(camera, heading)
        values, _ = self._hit(rays, np.array([x, y, 0.0]))
        image = values.reshape(camera.height * 2, camera.width * 2).astype(np.float32)
        small = cv2.resize(image, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
        return spoilt(np.asarray(small, np.float64), self.rng, flaws or Flaws(noise=2.0, blur=0.5, quality=90))

    def depth(self, x: float, y: float, heading: float, bearing: float) -> float:
        """Forward distance (along the heading) of what a horizontal ray meets, m."""
        direction = np.array([[np.cos(heading + bearing), np.sin(heading + bearing), 0.0]])
        return float(self._hit(direction, np.array([x, y, 0.0]))[1][0]) * float(np.cos(bearing))

    def _rays(self, camera: Camera, heading: float) -> Floats:
        """Two rays for each pixel each way."""
        u = (np.arange(camera.width * 2) + 0.5) / 2 - camera.width / 2
        v = (np.arange(camera.height * 2) + 0.5) / 2 - camera.height / 2
        columns, rows = np.meshgrid(u / camera.focal, v / camera.focal)
        rays = np.stack((np.ones(columns.size), -columns.ravel(), -rows.ravel()), axis=1)
        c, s = np.cos(camera.tilt), np.sin(camera.tilt)
        rays = rays @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        c, s = np.cos(heading), np.sin(heading)
        return np.asarray(rays @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))

    def _hit(self, rays: Floats, origin: Floats) -> tuple[Floats, Floats]:
        """Brightness and distance (in lengths of the ray) of what each ray meets first."""
        nearest = np.full(len(rays), np.inf)
        values = np.zeros(len(rays))
        for (axis, place), texture in zip(self._walls, self._textures, strict=True):
            with np.errstate(divide="ignore"):  # rays along a wall never meet it
                distance = (place - origin[axis]) / rays[:, axis]
            nearer = (distance > 0) & (distance < nearest)
            at = origin + rays[nearer] * distance[nearer, None]
            across, up = (at[:, other] for other in range(3) if other != axis)
            places = np.zeros((2, -(-len(at) // 100) * 100), np.float32)  # OpenCV takes no more than 32767 rows
            places[:, : len(at)] = across / 0.01 % len(texture), up / 0.01 % len(texture)
            columns, rows = places.reshape(2, -1, 100)
            if len(at):
                values[nearer] = cv2.remap(texture, columns, rows, cv2.INTER_LINEAR).ravel()[: len(at)]
            nearest[nearer] = distance[nearer]
        return values, nearest

    def _texture(self) -> NDArray[np.float32]:
        """Smooth random patterns of several sizes, 7.2 m square."""
        size = 720
        total = np.zeros((size, size), np.float32)
        for cells, weight in ((9, 1.0), (24, 1.0), (60, 0.9), (144, 0.6)):
            coarse = self.rng.normal(size=(cells, cells)).astype(np.float32) * np.float32(weight)
            total += cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC)
        return np.asarray(np.clip(self.rng.uniform(100, 150) + 38 * total, 5, 250), np.float32)

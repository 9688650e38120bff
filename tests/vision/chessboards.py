"""Draws chessboards as a camera with lens distortion sees them, by arithmetic of its own."""

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
WIDTH, HEIGHT = 320, 240
FX, FY, CX, CY = 273.0, 270.0, 162.5, 117.2
K1, K2, P1, P2 = -0.25, 0.08, 0.001, -0.0015
COLUMNS, ROWS, SQUARE = 9, 6, 0.025
FINE = 3  # pixels of the drawing for one of the image, each way

VIEWS = (  # turns about x, y and z in rad, and the middle of the board in m
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.36)),
    ((0.5, 0.0, 0.0), (-0.10, 0.0, 0.40)),
    ((-0.5, 0.1, 0.1), (0.10, 0.02, 0.40)),
    ((0.0, 0.55, 0.0), (-0.02, 0.08, 0.40)),
    ((0.1, -0.55, -0.1), (0.04, -0.07, 0.40)),
    ((0.35, 0.35, 0.05), (-0.12, -0.06, 0.44)),
    ((-0.35, 0.35, 0.2), (0.12, -0.06, 0.44)),
    ((0.3, -0.4, -0.2), (-0.12, 0.07, 0.44)),
    ((-0.3, -0.3, 0.1), (0.13, 0.07, 0.44)),
)


@cache
def _rays() -> NDArray[np.float64]:
    """Rays through the pixels of the drawing at depth 1, by iterating the distortion of Brown's model backwards."""
    rows, columns = np.mgrid[: HEIGHT * FINE, : WIDTH * FINE]
    seen_x = ((columns + 0.5) / FINE - 0.5 - CX) / FX
    seen_y = ((rows + 0.5) / FINE - 0.5 - CY) / FY
    x, y = seen_x, seen_y
    for _ in range(12):
        square = x * x + y * y
        radial = 1.0 + K1 * square + K2 * square * square
        shift_x = 2.0 * P1 * x * y + P2 * (square + 2.0 * x * x)
        shift_y = P1 * (square + 2.0 * y * y) + 2.0 * P2 * x * y
        x, y = (seen_x - shift_x) / radial, (seen_y - shift_y) / radial
    return np.stack((x, y, np.ones_like(x)), axis=-1)


def chessboard(turn: Sequence[float], at: Sequence[float], seed: int = 0) -> Pixels:
    """Return a grey image of a chessboard of `COLUMNS` by `ROWS` inner corners, with blur and noise."""
    axes = cv2.Rodrigues(np.array(turn, float))[0]
    rays, middle = _rays(), np.array(at, float)
    depth = (middle @ axes[:, 2]) / (rays @ axes[:, 2])
    points = (rays * depth[..., None] - middle) @ axes[:, :2] / SQUARE
    column, row = points[..., 0] + (COLUMNS + 1) / 2, points[..., 1] + (ROWS + 1) / 2
    sheet = (column > -1.0) & (column < COLUMNS + 2.0) & (row > -1.0) & (row < ROWS + 2.0)
    squares = (column > 0.0) & (column < COLUMNS + 1.0) & (row > 0.0) & (row < ROWS + 1.0)
    is_dark = squares & ((np.floor(column) + np.floor(row)) % 2 == 0)
    drawn = np.where(is_dark, 30.0, np.where(sheet, 225.0, 120.0)).astype(np.float32)
    image = cv2.GaussianBlur(cv2.resize(drawn, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA), (0, 0), 0.5)
    noise = np.random.default_rng(seed).normal(0.0, 2.0, image.shape)
    return np.asarray(np.clip(np.rint(image + noise), 0, 255), np.uint8)


@cache
def chessboards() -> tuple[Pixels, ...]:
    """Return an image for each of `VIEWS`."""
    return tuple(chessboard(turn, at, seed) for seed, (turn, at) in enumerate(VIEWS))

"""The camera model: projection there and back, and calibration from drawn chessboards."""

from math import radians
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.vision_drawing import Camera, Flaws, Pixels, spoilt
from vision.camera_model import PinholeModel, calibrate
from vision.image import VisionError

MODEL = PinholeModel(320, 240, 300.0, 305.0, 158.0, 121.0, -0.2, 0.05, 0.001, -0.0005)
COLUMNS, ROWS, SQUARE = 7, 5, 0.03


def board(tilts: tuple[float, float, float], distance: float, seed: int, at: tuple[float, float] = (0, 0)) -> Pixels:
    """A chessboard seen by a camera of focal length 320 px with a centre at (170, 115), by homography."""
    cell, margin = 40, 40
    sheet = np.full(((ROWS + 1) * cell + 2 * margin, (COLUMNS + 1) * cell + 2 * margin), 230, np.uint8)
    for row in range(ROWS + 1):
        for column in range(row % 2, COLUMNS + 1, 2):
            top, left = margin + row * cell, margin + column * cell
            sheet[top : top + cell, left : left + cell] = 25
    scale = SQUARE / cell
    turn = cv2.Rodrigues(np.array(tilts))[0]
    middle = np.array([sheet.shape[1], sheet.shape[0]]) * scale / 2
    place = np.array([at[0], at[1], distance]) - turn[:, :2] @ middle
    matrix = np.array([[320.0, 0, 170], [0, 320.0, 115], [0, 0, 1]])
    homography = matrix @ np.stack((turn[:, 0] * scale, turn[:, 1] * scale, place), axis=1)
    fine = np.diag([4.0, 4.0, 1.0])
    fine[:2, 2] = 1.5
    drawn = cv2.warpPerspective(sheet, fine @ homography, (1280, 960), borderValue=120.0)
    small = cv2.resize(drawn, (320, 240), interpolation=cv2.INTER_AREA).astype(np.float64)
    return spoilt(small, np.random.default_rng(seed), Flaws(noise=2.0, blur=0.5, quality=95))


TILTS = [(0.0, 0, 0), (0.5, 0, 0.1), (-0.5, 0, 0), (0, 0.5, 0), (0, -0.5, 0.1), (0.35, 0.35, 0), (-0.3, 0.3, 0.2)]
PLACES = [(0.0, 0.0), (0.06, 0.02), (-0.05, 0.0), (0.05, -0.03), (-0.05, 0.03), (0, 0.03), (0, -0.03)]


def boards() -> list[Pixels]:
    return [board(tilt, 0.42, n, at) for n, (tilt, at) in enumerate(zip(TILTS, PLACES, strict=True))]


@given(st.floats(0, 319), st.floats(0, 239))
def test_a_ray_through_a_pixel_meets_that_pixel(x: float, y: float) -> None:
    assert np.allclose(MODEL.pixels_of(MODEL.rays_of(np.array([[x, y]]))), [[x, y]], atol=0.02)


def test_projection_agrees_with_other_arithmetic_and_with_opencv() -> None:
    points = np.random.default_rng(0).uniform((0.5, -0.4, -0.3), (3, 0.4, 0.3), (50, 3))
    camera = Camera()
    plain = PinholeModel.from_field_of_view(320, 240, radians(60.0))
    assert np.allclose(plain.pixels_of(points), camera.project(points))
    optical = np.stack((-points[:, 1], -points[:, 2], points[:, 0]), axis=1)
    expected = cv2.projectPoints(optical, np.zeros(3), np.zeros(3), MODEL.matrix, MODEL.distortion)[0]
    assert np.allclose(MODEL.pixels_of(points), expected[:, 0])


def test_what_is_behind_the_camera_has_no_pixel() -> None:
    assert np.isnan(MODEL.pixels_of(np.array([[-1.0, 0, 0]]))).all()


def test_a_scaled_model_sees_the_same_rays() -> None:
    half = MODEL.scaled(160, 120)
    corner = np.array([[-0.5, -0.5], [319.5, 239.5]])
    assert np.allclose(MODEL.rays_of(corner), half.rays_of((corner + 0.5) / 2 - 0.5), atol=1e-4)


def test_a_model_is_saved_and_loaded_and_refuses_other_data() -> None:
    assert PinholeModel.from_dict(MODEL.to_dict()) == MODEL
    with pytest.raises(VisionError, match="a camera model has width, height"):
        PinholeModel.from_dict({"width": 3})
    with pytest.raises(VisionError, match="fx of a camera model must be a finite number"):
        PinholeModel.from_dict(MODEL.to_dict() | {"fx": float("nan")})
    with pytest.raises(VisionError, match="must be positive"):
        PinholeModel.from_dict(MODEL.to_dict() | {"fx": 0.0})
    with pytest.raises(VisionError, match="between 0 and 3"):
        PinholeModel.from_field_of_view(320, 240, 4.0)


def test_calibration_finds_the_camera_that_drew_the_boards() -> None:
    result = calibrate(boards(), COLUMNS, ROWS, SQUARE)
    assert result.used == tuple(range(7))
    assert result.error < 0.3
    assert abs(result.model.fx / 320.0 - 1.0) < 0.01
    assert abs(result.model.fy / 320.0 - 1.0) < 0.01
    assert np.hypot(result.model.cx - 170.0, result.model.cy - 115.0) < 3.0
    assert "7 images, error 0." in result.words


def test_images_without_the_board_are_left_out() -> None:
    empty = np.full((240, 320), 99, np.uint8)
    result = calibrate([empty, *boards(), empty], COLUMNS, ROWS, SQUARE)
    assert result.used == tuple(range(1, 8))


@pytest.mark.parametrize(
    ("images", "corners", "reason"),
    [
        (list, (COLUMNS, ROWS), "is in 0 of 0 images; take at least 6"),
        (lambda: boards()[:4], (COLUMNS, ROWS), "is in 4 of 4 images"),
        (lambda: boards(), (6, 4), "is in 0 of 7 images"),
        (lambda: boards(), (2, 4), "at least 3 inner corners"),
        (lambda: boards(), (5, 5), "not the same number"),
        (lambda: [*boards(), np.zeros((120, 160), np.uint8)], (COLUMNS, ROWS), "2 different sizes"),
        (lambda: [board((0, 0, 0.1 * n), 0.4 + 0.02 * n, n) for n in range(6)], (COLUMNS, ROWS), "tilt it|parallel"),
    ],
)
def test_boards_that_determine_nothing_are_refused_in_words(images: Any, corners: Any, reason: str) -> None:
    with pytest.raises(VisionError, match=reason):
        calibrate(images(), corners[0], corners[1], SQUARE)

"""The camera model: projection there and back."""

from math import radians

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.vision_drawing import Camera
from vision.camera_model import PinholeModel
from vision.image import VisionError

MODEL = PinholeModel(320, 240, 300.0, 305.0, 158.0, 121.0, -0.2, 0.05, 0.001, -0.0005)


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

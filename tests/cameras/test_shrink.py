"""Making pictures smaller."""

import sys

import cv2
import numpy as np
import pytest

from cameras import CameraNotUsable, picture_size, shrunk


def picture(width: int, height: int) -> bytes:
    """Noise, which packs worst."""
    pixels = np.random.default_rng(1).integers(0, 256, (height, width, 3), np.uint8)
    return bytes(cv2.imencode(".jpg", pixels)[1])


def test_picture_that_fits_stays_as_it_is() -> None:
    jpeg = picture(40, 30)
    assert shrunk(jpeg, len(jpeg)) == jpeg


def test_picture_that_does_not_fit_keeps_its_shape_and_loses_pixels() -> None:
    jpeg = picture(1280, 960)
    small = shrunk(jpeg, 190_000)
    assert 50_000 < len(small) <= 190_000 < len(jpeg)
    size = picture_size(small)
    assert size is not None
    assert size[0] / size[1] == pytest.approx(4 / 3, rel=0.02)


def test_what_is_no_picture_cannot_be_made_smaller() -> None:
    with pytest.raises(CameraNotUsable, match="no JPEG"):
        shrunk(bytes(1000), 100)


def test_without_opencv_one_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(CameraNotUsable, match=r"needs the extra vision, not installed here; install with: "):
        shrunk(bytes(1000), 100)

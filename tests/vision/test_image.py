"""Image files: decoded within limits, refused with a reason."""

from contextlib import suppress
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vision.image import MAX_PIXELS, Image, ImageKind, VisionError, colour_pixels, grey_pixels

RNG = np.random.default_rng(0)
PICTURE = RNG.integers(0, 255, (24, 32, 3)).astype(np.uint8)
PNG, JPEG = Image.of(PICTURE).encode(), Image.of(PICTURE).encode(90)


def test_png_gives_back_the_same_pixels() -> None:
    assert np.array_equal(Image.decode(PNG).pixels, PICTURE)


def test_jpeg_of_a_grey_image_stays_grey() -> None:
    grey = Image.of(grey_pixels(PICTURE))
    assert Image.decode(grey.encode(90)).kind is ImageKind.GREY
    assert Image.decode(grey.encode()).kind is ImageKind.GREY


def test_zeros_behind_a_jpeg_do_no_harm() -> None:
    assert Image.decode(JPEG + bytes(100)).width == 32


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "neither a JPEG nor a PNG"),
        (b"GIF89a" + bytes(100), "neither a JPEG nor a PNG"),
        (PNG[:20], "ends in its header"),
        (PNG[:-5], "truncated"),
        (PNG[:60] + b"\0\0\0" + PNG[63:], "checksum"),
        (JPEG[:-2], "truncated"),
        (JPEG[: len(JPEG) // 2], "truncated"),
        (JPEG[:2], "before its image begins"),
        (JPEG[: len(JPEG) * 2 // 3] + JPEG, "torn"),
    ],
)
def test_a_damaged_file_is_refused_with_a_reason(data: bytes, reason: str) -> None:
    with pytest.raises(VisionError, match=reason):
        Image.decode(data)


def test_forty_megapixels_are_refused_by_the_header_alone() -> None:
    huge = np.zeros((5000, 8000), np.uint8)
    with pytest.raises(VisionError, match="8000 x 5000 pixels, more than 16 megapixels"):
        Image.decode(bytes(cv2.imencode(".png", huge)[1]))
    assert huge.size > MAX_PIXELS


@pytest.mark.parametrize(
    ("pixels", "reason"),
    [
        ([[1, 2]], "not list"),
        (np.zeros((4, 4)), "not an array of float64"),
        (np.zeros((4, 4, 4), np.uint8), "shape"),
        (np.zeros((0, 4), np.uint8), "no pixels"),
    ],
)
def test_what_is_no_image_is_refused(pixels: Any, reason: str) -> None:
    with pytest.raises(VisionError, match=reason):
        Image.of(pixels)


def test_a_grey_image_where_colours_are_needed_is_refused() -> None:
    with pytest.raises(VisionError, match="colour tracking needs a colour image"):
        colour_pixels(grey_pixels(PICTURE), "colour tracking")


@pytest.mark.parametrize("quality", [0, 101, 2.5, "high"])
def test_a_quality_that_is_none_is_refused(quality: Any) -> None:
    with pytest.raises(VisionError, match="from 1 to 100"):
        Image.of(PICTURE).encode(quality)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damaged_files_raise_nothing_else(data: st.DataObject) -> None:
    whole = bytearray(data.draw(st.sampled_from([PNG, JPEG])))
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(whole[: data.draw(st.integers(0, len(whole)))])
    with suppress(VisionError):  # the error that is allowed
        Image.decode(cut)

"""Colour channels and blobs: 32 channels found in drawn images, under other light, and saved and loaded."""

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.vision_drawing import Flaws, spoilt
from vision.blobs import Blob, blobs_of
from vision.colours import CHANNELS, ColourModel, ColourTable
from vision.image import Pixels, VisionError

SATURATED, PALE = 235, 110


def patches(seed: int, gain: float = 1.0) -> tuple[Pixels, list[tuple[int, int, int, int]]]:
    """32 rectangles of 16 hues, saturated and pale, on grey; with their regions."""
    image = np.full((240, 320, 3), 90.0)
    regions = []
    for number in range(CHANNELS):
        hsv = np.array([[[number % 16 * 11, SATURATED if number < 16 else PALE, 200]]], np.uint8)
        left, top = number % 8 * 40 + 5, number // 8 * 60 + 5
        image[top : top + 50, left : left + 30] = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0]
        regions.append((left, top, 30, 50))
    return spoilt(image, np.random.default_rng(seed), Flaws(noise=4.0, gain=gain)), regions


def inner(region: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
    left, top, width, height = region
    return left + 4, top + 4, width - 8, height - 8


@pytest.fixture(scope="module")
def table() -> ColourTable:
    image, regions = patches(1)
    trained = ColourTable()
    for number, region in enumerate(regions, 1):
        trained.train(number, image, inner(region), f"patch {number}")
    return trained


@pytest.mark.parametrize("gain", [0.5, 0.7, 1.0, 1.2])
def test_32_channels_are_found_under_changing_light(table: ColourTable, gain: float) -> None:
    image, regions = patches(7, gain)
    found = table.find(image)
    for number, (left, top, width, height) in enumerate(regions, 1):
        blob = found[number][0]
        assert abs(blob.x - (left + width / 2 - 0.5)) < 1.5, number
        assert abs(blob.y - (top + height / 2 - 0.5)) < 1.5, number
        assert 0.7 * width * height < blob.area <= 1.15 * width * height, number


def test_training_ignores_what_else_is_in_the_region(table: ColourTable) -> None:
    image, regions = patches(1)
    left, top, width, height = regions[0]
    other = ColourTable()
    other.train(1, image, (left - 3, top - 3, width + 6, height + 6))  # a fifth of it is background
    blob = other.find(image)[1][0]
    assert abs(blob.area - table.find(image)[1][0].area) < 0.15 * blob.area
    assert blob.left >= left - 1


def test_a_test_says_how_good_a_channel_is(table: ColourTable) -> None:
    image, regions = patches(8)
    good = table.test(3, image, inner(regions[2]))
    assert good.hits > 0.9
    assert "channel 3 has" in good.words
    assert "channel 4 has" in table.test(3, image, inner(regions[3])).words


def test_a_second_object_of_the_colour_is_reported(table: ColourTable) -> None:
    image, regions = patches(8)
    (left, top, width, height), (to_left, to_top, _, _) = regions[2], regions[20]
    image[to_top : to_top + height, to_left : to_left + width] = image[top : top + height, left : left + width]
    assert "something else has this colour" in table.test(3, image, inner(regions[2])).words


def test_a_test_of_a_channel_without_colours_says_so() -> None:
    image, regions = patches(8)
    assert ColourTable().test(20, image, inner(regions[2])).words == "channel 20 is not trained"


def test_saved_channels_find_the_same(table: ColourTable) -> None:
    image, _ = patches(9)
    loaded = ColourTable.load(table.save())
    assert loaded.save() == table.save()
    assert loaded.find(image) == table.find(image)
    assert loaded.channels[5].name == "patch 5"


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("", "line 1 of the file of colours must be"),
        ("colour-table 9", "line 1"),
        ("colour-table 1\nchannel 33", "line 2 .* from 1 to 32, not 33"),
        ("colour-table 1\n\nchannel one", "line 3 .* not 'one'"),
        ("colour-table 1\nchannel 1\nchannel 1", "line 3 .* twice"),
        ("colour-table 1\ncolour 0 0 1 0 1 0 9", "line 2 .* put a line such as"),
        ("colour-table 1\nchannel 1\ncolour 0 0 1", "line 3 .* not 3"),
        ("colour-table 1\nchannel 1\ncolour 0 0 1 0 x 0 9", "line 3 .* could not convert"),
        ("colour-table 1\nchannel 1\ncolour 0 0 nan 0 1 0 9", "line 3 .* finite"),
        ("colour-table 1\nchannel 1\ncolour 0 0 1 2 1 0 9", "line 3 .* ellipse"),
        ("colour-table 1\nchannel 1\ncolour 0 0 1 0 1 9 9", "line 3 .* darkest"),
        ("colour-table 1\nfarbe 1", "line 2 .* begins with channel, colour or #"),
    ],
)
def test_a_wrong_line_of_a_file_is_named(lines: str, reason: str) -> None:
    with pytest.raises(VisionError, match=reason):
        ColourTable.load(lines.encode())
    with pytest.raises(VisionError, match="not UTF-8"):
        ColourTable.load(b"\xff\xfe")


@pytest.mark.parametrize(
    ("region", "colour", "reason"),
    [
        ((0, 0, 3, 3), (0, 0, 200), "has 9 pixels"),
        ((-1, 0, 20, 20), (0, 0, 200), "not inside the image of 40 x 40 px"),
        ((30, 30, 20, 20), (0, 0, 200), "not inside"),
        ((0, 0, 20, 20), (5, 5, 5), "too dark"),
        ((0, 0, 20, 20), (255, 255, 255), "over-exposed"),
        ((0, 0, 40, 40), None, "several colours"),
    ],
)
def test_a_region_without_a_colour_is_refused(region: Any, colour: Any, reason: str) -> None:
    image = np.zeros((40, 40, 3), np.uint8)
    image[:] = colour or (200, 40, 40)
    if colour is None:
        image[:, :13], image[:, 13:26] = (40, 40, 200), (40, 200, 40)
    with pytest.raises(VisionError, match=reason):
        ColourTable().train(1, image, region)


@pytest.mark.parametrize("channel", [0, 33, 1.0, True, "1"])
def test_a_number_that_is_no_channel_is_refused(channel: Any) -> None:
    with pytest.raises(VisionError, match="from 1 to 32"):
        ColourTable().train(channel, patches(1)[0], (5, 5, 20, 20))


def test_a_grey_image_is_refused_and_an_empty_table_finds_nothing() -> None:
    image, _ = patches(1)
    assert ColourTable().find(image) == {}
    with pytest.raises(VisionError, match="needs a colour image"):
        ColourTable().find(image[..., 0])


def test_training_is_repeatable_and_clearing_forgets(table: ColourTable) -> None:
    image, regions = patches(1)
    again = ColourTable()
    assert again.train(1, image, inner(regions[0])) == table.channels[1].models[0]
    again.clear(1)
    assert again.find(image) == {}


@settings(max_examples=30, deadline=None)
@given(st.tuples(*[st.integers(30, 200)] * 3), st.integers(0, 1000))
def test_a_trained_colour_belongs_to_its_own_model(colour: tuple[int, int, int], seed: int) -> None:
    samples = np.clip(np.random.default_rng(seed).normal(colour, 3.0, (400, 3)), 0, 255).astype(np.uint8)
    image = samples.reshape(20, 20, 3)
    table = ColourTable()
    table.train(1, image, (0, 0, 20, 20))
    assert isinstance(table.channels[1].models[0], ColourModel)
    assert (table.classes(image) == 1).mean() > 0.9


def naive(classes: Pixels) -> dict[int, list[tuple[float, ...]]]:
    found: dict[int, list[tuple[float, ...]]] = {}
    for number in np.unique(classes[classes > 0]).tolist():
        _, _, boxes, centres = cv2.connectedComponentsWithStats((classes == number).astype(np.uint8), connectivity=8)
        for (left, top, width, height, area), (x, y) in zip(boxes[1:].tolist(), centres[1:].tolist(), strict=True):
            place = (round(x, 6), round(y, 6), left, top, left + width - 1, top + height - 1)
            found.setdefault(number, []).append((area, *place))
    return {number: sorted(blobs) for number, blobs in found.items()}


def as_tuple(blob: Blob) -> tuple[float, ...]:
    return blob.area, round(blob.x, 6), round(blob.y, 6), blob.left, blob.top, blob.right, blob.bottom


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 30), st.integers(1, 30), st.integers(1, 4), st.integers(0, 10**6))
def test_blobs_are_the_connected_components_of_each_class(height: int, width: int, classes: int, seed: int) -> None:
    image = np.random.default_rng(seed).integers(0, classes + 1, (height, width)).astype(np.uint8)
    found = blobs_of(image, 1, 10**6)
    assert {number: sorted(map(as_tuple, blobs)) for number, blobs in found.items()} == naive(image)


def test_no_more_than_ten_blobs_the_largest_first_and_none_that_is_too_small() -> None:
    image = np.zeros((40, 200), np.uint8)
    for number in range(15):
        image[1 : 3 + number, number * 12 : number * 12 + 8] = 7
    blobs = blobs_of(image, 20)[7]
    assert [blob.area for blob in blobs] == [8 * (2 + number) for number in range(14, 4, -1)]
    assert (blobs[0].width, blobs[0].height) == (8, 16)
    assert len(blobs_of(image, 100)[7]) == 4

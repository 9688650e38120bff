"""Operations and chains: what they compute, what they refuse, and which share their results."""

import json
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.shown import files
from vision.chain import MAX_STEPS, Chain
from vision.image import Image, ImageKind, VisionError
from vision.operations import OPERATIONS

RNG = np.random.default_rng(1)
COLOUR = Image.of(RNG.integers(0, 255, (30, 40, 3)).astype(np.uint8))
GREY = Image.of(RNG.integers(0, 255, (30, 40)).astype(np.uint8))
KERNEL = [[0, 0, 0], [0, 0, 1], [0, 0, 0]]


def apply(image: Image, *steps: Any) -> Image:
    result = Chain.parse(steps, image.kind).run(image)
    assert isinstance(result, Image)
    return result


@pytest.mark.parametrize("name", [name for name in OPERATIONS if name != "convolution"])
@pytest.mark.parametrize("image", [COLOUR, GREY])
def test_every_operation_gives_the_kind_that_it_announces(name: str, image: Image) -> None:
    before = image.pixels.copy()
    try:
        chain = Chain.parse([name], image.kind)
    except VisionError:
        assert image.kind not in OPERATIONS[name].takes
        return
    result = chain.run(image)
    assert (result.kind if isinstance(result, Image) else None) is chain.kind_of_result
    if isinstance(result, Image):
        assert result.pixels.ndim == (3 if result.kind is ImageKind.COLOUR else 2)
        assert result.pixels.dtype == np.uint8
        assert result.kind is not ImageKind.BINARY or set(np.unique(result.pixels)) <= {0, 255}
    assert np.array_equal(image.pixels, before)


def test_convolution_turns_the_kernel_as_mathematics_does() -> None:
    point = np.zeros((9, 9), np.uint8)
    point[4, 4] = 200
    kernel = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    result = apply(Image.of(point), {"operation": "convolution", "kernel": kernel, "scale": 1 / 200}).pixels
    assert result[3:6, 3:6].tolist() == kernel


def test_convolution_with_an_even_kernel_keeps_a_point_at_its_place() -> None:
    point = np.zeros((9, 9), np.uint8)
    point[4, 4] = 200
    result = apply(Image.of(point), {"operation": "convolution", "kernel": [[1, 1]], "scale": 0.5}).pixels
    assert result[4, 4] == 100
    assert result.sum() == 200


def test_box_blur_and_a_constant_kernel_are_the_same() -> None:
    ninth = {"operation": "convolution", "kernel": [[1] * 3] * 3, "scale": 1 / 9}
    assert np.abs(apply(GREY, ninth).pixels.astype(int) - apply(GREY, "box").pixels).max() <= 1
    assert np.array_equal(apply(GREY, "blur").pixels, apply(GREY, "box").pixels)


def test_sobel_of_a_step_from_black_to_white_is_white_for_each_size() -> None:
    step = np.zeros((20, 20), np.uint8)
    step[:, 10:] = 255
    for size in (3, 5, 7):
        assert apply(Image.of(step), {"operation": "sobel", "size": size}).pixels[10].max() == 255
    assert apply(Image.of(step), {"operation": "sobel", "direction": "y"}).pixels.max() == 0


def test_otsu_separates_two_brightnesses() -> None:
    two = np.where(np.arange(40)[None] < 15, 90, 110).repeat(30, axis=0).astype(np.uint8)
    assert (apply(Image.of(two), "otsu").pixels == np.where(two > 100, 255, 0)).all()


def test_adaptive_threshold_ignores_a_gradient_of_the_light() -> None:
    light = np.linspace(40, 220, 80)[None].repeat(40, axis=0)
    light[18:22, ::8] -= 25
    white = apply(Image.of(light.astype(np.uint8)), {"operation": "adaptive", "size": 9, "offset": 8}).pixels
    assert (white[20, ::8] == 0).mean() > 0.8
    assert (white[:10] == 255).all()


def test_opening_removes_specks_and_closing_fills_holes() -> None:
    image = np.zeros((20, 20), np.uint8)
    image[5:15, 5:15] = 255
    clean = image.copy()
    image[2, 17], image[10, 10] = 255, 0
    assert np.array_equal(apply(Image.of(image), "closing", "opening").pixels, clean)


def test_histogram_counts_every_pixel_of_every_channel() -> None:
    for bins in (1, 7, 16, 256):
        numbers = Chain.parse([{"operation": "histogram", "bins": bins}]).run(COLOUR)
        assert isinstance(numbers, dict)
        assert [sum(numbers[name]) for name in ("blue", "green", "red")] == [1200] * 3
        assert len(numbers["from"]) == bins
        below = int((COLOUR.pixels[..., 2] < numbers["from"][bins // 2]).sum())
        assert sum(numbers["red"][: bins // 2]) == below
        assert json.loads(json.dumps(numbers)) == numbers


@pytest.mark.parametrize(
    ("chain", "reason"),
    [
        ([], "1 to 32 operations, not 0"),
        ("grey", "must be a list .* not str"),
        (["grey"] * (MAX_STEPS + 1), "not 33"),
        ([3], "step 1: a step must be a name or an object"),
        (["gausian"], r"there is no operation 'gausian' \(did you mean gaussian\?\)"),
        (["zzz"], "the operations are grey, convolution"),
        ([{"operation": ["grey"]}], "there is no operation"),
        ([{"operation": "gaussian", "sigm": 2}], r"does not take 'sigm' \(did you mean sigma\?\); it takes sigma"),
        ([{"operation": "gaussian", "sigma": 99}], "sigma must be a number from 0.1 to 50 px, not 99"),
        ([{"operation": "gaussian", "sigma": float("nan")}], "not nan"),
        ([{"operation": "gaussian", "sigma": "2"}], "sigma must be a number"),
        ([{"operation": "gaussian", "sigma": True}], "not True"),
        ([{"operation": "median", "size": 4}], "size must be an odd whole number from 1 to 31 px, not 4"),
        ([{"operation": "median", "size": 3.5}], "odd whole number"),
        ([{"operation": "erosion", "shape": "elipse"}], r"did you mean ellipse\?"),
        (["grey", {"operation": "threshold", "invert": 1}], "step 2: invert must be true or false, not 1"),
        (["threshold"], "takes a grey or binary image, not a colour one; put the operation grey before it"),
        (["histogram", "grey"], "step 2: histogram before it gives numbers"),
        (["convolution"], "needs kernel: a matrix"),
        ([{"operation": "convolution", "kernel": "edge"}], "kernel must be a list of 1 to 31 rows of numbers"),
        ([{"operation": "convolution", "kernel": [[1, 2], [3]]}], "row 2 of kernel has 1 numbers, and row 1 has 2"),
        ([{"operation": "convolution", "kernel": [[1, "x"]]}], "row 1 of kernel contains 'x'; use numbers"),
        ([{"operation": "convolution", "kernel": [[1, None]]}], "contains None"),
        ([{"operation": "convolution", "kernel": [[float("inf")]]}], "contains inf"),
        ([{"operation": "convolution", "kernel": [1, 2]}], "row 1 of kernel must be a list"),
        ([{"operation": "convolution", "kernel": []}], "kernel must be a list"),
        ([{"operation": "convolution", "kernel": [[1] * 40]}], "1 to 31 numbers"),
    ],
)
def test_a_wrong_chain_is_refused_before_it_runs(chain: Any, reason: str) -> None:
    with pytest.raises(VisionError, match=reason) as caught:
        Chain.parse(chain)
    assert len(str(caught.value)) < 300


def test_a_chain_refuses_another_kind_of_image() -> None:
    with pytest.raises(VisionError, match="made for a colour image and got a grey one"):
        Chain.parse(["grey"]).run(GREY)


def test_equal_operations_have_equal_keys_however_they_are_written() -> None:
    one = Chain.parse(["grey", {"operation": "gaussian", "sigma": 2}])
    two = Chain.parse([{"operation": "grey"}, {"sigma": 2.0, "operation": "gaussian"}])
    other = Chain.parse(["grey", {"operation": "gaussian", "sigma": 2.5}])
    assert one.key == two.key != other.key
    assert one.keys[0] == other.keys[0]
    assert Chain.parse(one.described()).key == one.key


def test_chains_on_one_image_share_what_they_have_in_common() -> None:
    results: dict[str, Any] = {}
    edges = Chain.parse(["grey", "gaussian", "canny"])
    edges.run(COLOUR, results)
    kept = results[edges.keys[1]]
    black = Chain.parse(["grey", "gaussian", "otsu"])
    shared = black.run(COLOUR, results)
    assert results[black.keys[1]] is kept
    assert len(results) == 4
    alone = black.run(COLOUR)
    assert isinstance(shared, Image)
    assert isinstance(alone, Image)
    assert np.array_equal(shared.pixels, alone.pixels)


def test_the_table_describes_each_operation_for_a_form() -> None:
    for operation in OPERATIONS.values():
        form = json.loads(json.dumps(operation.described()))
        assert form["purpose"]
        for parameter in operation.parameters:
            assert parameter.default is None or parameter.checked(parameter.default) == parameter.default
            assert parameter.expected
    assert OPERATIONS["canny"].gives == "binary"


def test_program_of_the_page_runs() -> None:
    (program,) = [text for text in files("vision", "python") if "look_about" not in text]
    names: dict[str, Any] = {"jpeg": COLOUR.encode(90)}
    exec(program, names)
    assert names["result"].kind is ImageKind.BINARY


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=10,
)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from([*OPERATIONS]), st.data())
def test_any_json_either_parses_and_runs_or_is_refused(name: str, data: st.DataObject) -> None:
    names = [parameter.name for parameter in OPERATIONS[name].parameters] or ["none"]
    step = {"operation": name, data.draw(st.sampled_from(names)): data.draw(JSON)}
    with suppress(VisionError):  # the error that is allowed
        Chain.parse(["grey", step]).run(COLOUR)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.lists(st.floats(-9, 9), min_size=3, max_size=3), min_size=1, max_size=3))
def test_convolution_agrees_with_its_definition(kernel: list[list[float]]) -> None:
    got = apply(GREY, {"operation": "convolution", "kernel": kernel}).pixels
    rows, columns = len(kernel), 3
    y, x = 12, 17
    total = sum(
        kernel[i][j] * float(GREY.pixels[y - (i - rows // 2), x - (j - columns // 2)])
        for i in range(rows)
        for j in range(columns)
    )
    assert abs(float(np.clip(total, 0, 255)) - got[y, x]) <= 1

"""Camera calibration from drawn chessboards with known truth."""

import re
from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from tests.vision.chessboards import (
    COLUMNS,
    CX,
    CY,
    FX,
    FY,
    HEIGHT,
    ROWS,
    SQUARE,
    WIDTH,
    Pixels,
    chessboard,
    chessboards,
)
from vision.calibration import CalibrationResult, CalibrationViews, Chessboard
from vision.camera_model import PinholeModel
from vision.image import VisionError

BOARD = Chessboard(COLUMNS, ROWS, SQUARE)
TRUTH = PinholeModel(WIDTH, HEIGHT, FX, FY, CX, CY, -0.25, 0.08, 0.001, -0.0015)


def calibrated(images: Sequence[Pixels], board: Chessboard = BOARD) -> CalibrationResult:
    views = CalibrationViews(board)
    for number, image in enumerate(images):
        views.add(f"view {number}", image)
    return views.solve()


def test_calibration_finds_the_camera_that_drew_the_boards_within_one_percent() -> None:
    result = calibrated(chessboards())
    model = result.model
    assert result.used == tuple(f"view {number}" for number in range(9))
    assert result.error < 0.2
    assert abs(model.fx / FX - 1.0) < 0.01
    assert abs(model.fy / FY - 1.0) < 0.01
    assert np.hypot(model.cx - CX, model.cy - CY) < 0.01 * WIDTH
    grid = np.stack(np.meshgrid(np.linspace(20, WIDTH - 20, 9), np.linspace(20, HEIGHT - 20, 9)), -1).reshape(-1, 2)
    # The coefficients trade with each other; what counts is where a ray meets the image.
    assert np.abs(model.pixels_of(TRUTH.rays_of(grid)) - grid).max() < 0.01 * WIDTH


def test_the_same_images_give_the_same_model() -> None:
    assert calibrated(chessboards()[:6]) == calibrated(chessboards()[:6])


def test_images_without_the_board_and_images_that_are_alike_are_left_out_with_a_reason() -> None:
    views = CalibrationViews(BOARD)
    assert views.add("a.png", chessboards()[0]) == ""
    assert views.add("b.png", np.full((HEIGHT, WIDTH), 99, np.uint8)) == (
        "does not show the whole board of 9 x 6 inner corners"
    )
    assert views.add("c.png", chessboards()[0]) == "is like a.png"
    assert len(views) == 1


def test_a_live_board_is_used_when_it_is_held_still() -> None:
    views = CalibrationViews(BOARD)
    first, second = chessboards()[:2]
    assert "moving" in views.add("1", first, is_live=True)
    assert "moving" in views.add("2", second, is_live=True)
    assert views.add("3", second, is_live=True) == ""


def test_what_is_missing_is_told_until_the_views_suffice() -> None:
    views = CalibrationViews(BOARD)
    assert views.missing(9) == ["9 more views"]
    views.add("1", chessboard((0, 0, 0), (0, 0, 0.45)))
    assert views.missing(9) == [
        "8 more views",
        "near the left edge",
        "near the right edge",
        "near the upper edge",
        "near the lower edge",
        "slanted sideways",
        "slanted up or down",
    ]
    for number, image in enumerate(chessboards()[1:]):
        views.add(f"{number + 2}", image)
    assert views.missing(9) == []


def test_few_slanted_boards_in_the_middle_give_advice() -> None:
    turns = [(0.0, side * 0.35, 0.35 * turn) for side in (-1, 1) for turn in (-1, 0, 1)]
    result = calibrated([chessboard(turn, (0, 0, 0.42)) for turn in turns])
    assert result.advice.startswith("better with views near the left edge")
    assert result.advice.endswith("slanted up or down")


def test_views_that_determine_nothing_are_refused_in_words() -> None:
    with pytest.raises(VisionError, match=r"4 different views of the board of 9 x 6 .* take at least 6"):
        calibrated(chessboards()[:4])
    with pytest.raises(VisionError, match="1 different views"):
        calibrated([chessboards()[0]] * 9)
    with pytest.raises(VisionError, match="0 different views of the board of 7 x 5"):
        calibrated(chessboards()[:2], Chessboard(7, 5, SQUARE))
    with pytest.raises(VisionError, match="parallel in all images"):
        calibrated([chessboard((0, 0, 0.15 * n), (0.02 * n - 0.05, 0, 0.4 + 0.02 * n)) for n in range(6)])


def test_images_of_different_sizes_are_refused_by_their_names() -> None:
    views = CalibrationViews(BOARD)
    views.add("a.png", chessboards()[0])
    with pytest.raises(VisionError, match=r"a.png has 320 x 240 px and b.png has 160 x 120"):
        views.add("b.png", np.zeros((120, 160), np.uint8))


def bent(by: float) -> list[Pixels]:
    """Boards that are bent by so many px."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    images = []
    for number, image in enumerate(chessboards()):
        wave = (by * np.sin(columns / 40.0 + number)).astype(np.float32)
        images.append(np.asarray(cv2.remap(image, columns, rows + wave, cv2.INTER_LINEAR, borderValue=120), np.uint8))
    return images


def test_a_board_that_is_bent_is_refused() -> None:
    with pytest.raises(VisionError, match=r"px from where a camera would have them.*flat board"):
        calibrated(bent(6.0))


def test_views_that_do_not_tell_the_focal_length_do_not_suffice() -> None:
    views = CalibrationViews(BOARD)
    for number, image in enumerate(bent(1.5)):
        views.add(f"{number}", image)
    (missing,) = views.missing(9)
    assert re.fullmatch(r"nearer or more slanted, since the focal length is known to \d\.\d% only", missing)
    assert views.solve().advice == f"better with views {missing}"


@pytest.mark.parametrize(
    ("columns", "rows", "square", "why"),
    [(2, 4, 0.03, "at least 3 inner corners"), (5, 5, 0.03, "not the same number"), (9, 6, 0.0, "more than 0 m")],
)
def test_what_is_no_chessboard_is_refused(columns: int, rows: int, square: float, why: str) -> None:
    with pytest.raises(VisionError, match=why):
        Chessboard(columns, rows, square)

"""Chessboards of world files, and the world chessboard-lab, in which cameras are calibrated."""

import math
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from p2os_emu.world import World, WorldError, load_world
from p2os_emu.world.mirror import Mirror
from p2os_emu.world.view import View
from vision.calibration import CalibrationViews, Chessboard

BOARD = Chessboard(9, 6, 0.05)
WIDTH, HEIGHT, FIELD_OF_VIEW, EYE = 320, 240, math.radians(47.5), 0.45  # m above the floor
PLACES = ((2.6, 2.5, 0.37), (3.04, 2.74, 0.5), (3.18, 1.95, 0.5))  # m, and rad up to the board
ASIDE = (0.0, 0.18, -0.18)  # rad beside it, to each side and up and down


def test_the_camera_of_a_robot_is_calibrated_within_one_percent_by_driving_and_looking_about() -> None:
    spec = load_world("chessboard-lab")
    mirror, views = Mirror(), CalibrationViews(BOARD)
    with World(spec, perfect=True) as world:
        mirror.apply(world.sight.news(set()))
    board = next(piece for piece in spec.furniture if any(piece.board))
    assert board.square == pytest.approx(BOARD.square)
    for x, y, up in PLACES:
        ahead = math.atan2(board.y - y, board.x - x)
        for pan, tilt in product(ASIDE, ASIDE):
            picture = mirror.draw(View(x, y, EYE, ahead + pan, up + tilt, FIELD_OF_VIEW), WIDTH, HEIGHT)
            views.add(f"from {x}, {y} by {pan}, {tilt}", picture[:, :, ::-1].copy())
    mirror.close()
    assert views.missing() == []
    found = views.solve()
    assert found.model.fx == pytest.approx(WIDTH / 2.0 / math.tan(FIELD_OF_VIEW / 2.0), rel=0.01)
    assert math.hypot(found.model.cx - WIDTH / 2.0, found.model.cy - HEIGHT / 2.0) < 0.01 * WIDTH
    assert found.error < 0.5


def test_a_board_is_white_whatever_colour_its_entry_has_and_other_furniture_stays_as_it_is() -> None:
    spec = load_world("chessboard-lab")
    stand = next(piece for piece in spec.furniture if not any(piece.board))
    assert stand.board == (0, 0)
    assert replace(stand, board=(3, 4)).square == pytest.approx(0.3 / 6)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("board = [9, 2]", "board is the number of inner corners along and up, 3 to 20 each, as in [9, 6]; not [9, 2]"),
        ("board = [0, 6]", "as in [9, 6]; not [0, 6]"),
        ("board = [99, 6]", "3 to 20 each"),
        ("board = [9, 6]\nglass = true", "a board is not made of glass; leave out board or glass"),
        ('board = "9x6"', "board"),
    ],
)
def test_a_wrong_board_is_told_with_its_entry(tmp_path: Path, line: str, told: str) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(f"[[furniture]]\nat_m = [1.0, 1.0]\nsize_m = [0.7, 0.02, 0.5]\n{line}\n")
    with pytest.raises(WorldError) as caught:
        load_world(str(file))
    assert told in str(caught.value)

"""Shapes: where the virtual points are, and what cannot be formed."""

import math
from itertools import combinations
from pathlib import Path

import pytest

from apps.formation.shapes import SHAPES, ShapeError, shape_offsets


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("followers", [1, 2, 3, 5, 8])
def test_neighbours_are_a_spacing_apart(shape: str, followers: int) -> None:
    points = [(0.0, 0.0), *shape_offsets(shape, followers, 1.0, 0.5)]
    apart = [math.dist(a, b) for a, b in combinations(points, 2)]
    assert len(points) == followers + 1
    assert min(apart) == pytest.approx(1.0)


@pytest.mark.parametrize("shape", SHAPES)
def test_no_point_is_before_the_leader(shape: str) -> None:
    assert all(ahead <= 0.0 for ahead, _ in shape_offsets(shape, 6, 1.0, 0.5))


def test_a_triangle_of_three_has_equal_sides() -> None:
    (ax, ay), (bx, by) = shape_offsets("triangle", 2, 2.0, 0.5)
    assert (ax, ay) == pytest.approx((-math.sqrt(3.0), 1.0))
    assert (bx, by) == pytest.approx((-math.sqrt(3.0), -1.0))


def test_a_diamond_of_four_is_a_square_on_its_corner() -> None:
    side = math.sqrt(0.5)
    points = shape_offsets("diamond", 3, 1.0, 0.5)
    assert [x for point in points for x in point] == pytest.approx([-side, side, -side, -side, -2 * side, 0.0])


def test_offsets_come_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("offsets_m = [[-1, 0.5], [-2.0, 0], [0.0, 1.5]]")
    assert shape_offsets(str(file), 2, 1.0, 0.5) == ((-1.0, 0.5), (-2.0, 0.0))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("offsets_m = [[-1, 0.5]]", "has 1 offsets for 2 followers; add one for each follower"),
        ("offsets_m = [[-1, 0.5], [-1, 'left']]", r"\[-1, 'left'\] is no offset; expected \[x, y\] in m within 20 m"),
        ("offsets_m = [[-1, 0.5], [nan, 0]]", "is no offset"),
        ("offsets_m = [[-1000, 500], [-1000, -500]]", "is no offset; expected .* within 20 m"),
        ("offsets_m = [[-1, 0.5], [-1, 0.4]]", "two robots are 0.10 m apart; expected at least 0.60 m"),
        ("offsets_m = [[0, 0.1], [-1, 0]]", "two robots are 0.10 m apart"),
        ("offsets = [[-1, 0.5]]", r"expected offsets_m = \[\[x, y\], ...\] and nothing else"),
        ("offsets_m = 3", "expected offsets_m"),
        ("offsets_m = [", "mine.toml"),
    ],
)
def test_a_file_with_nonsense_is_refused_in_a_sentence(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ShapeError, match=told):
        shape_offsets(str(file), 2, 1.0, 0.6)


@pytest.mark.parametrize(
    ("shape", "told"), [("wegde", "did you mean wedge?"), ("xyz", "choose column"), ("no.toml", "no.toml")]
)
def test_an_unknown_shape_is_refused_with_advice(shape: str, told: str) -> None:
    with pytest.raises(ShapeError, match=told.replace("?", r"\?")):
        shape_offsets(shape, 2, 1.0, 0.6)

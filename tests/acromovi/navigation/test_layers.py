"""Boxes in rows and lines between them."""

from collections.abc import Hashable
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from acromovi.navigation.layers import BETWEEN, GraphEdge, lay_out, ranks

NAMES = st.integers(0, 7)
PAIRS = st.lists(st.tuples(NAMES, NAMES), max_size=20)


@given(PAIRS)
def test_no_pair_shares_a_row_and_the_first_of_each_pair_is_above_where_that_can_be(
    pairs: list[tuple[int, int]],
) -> None:
    rank = ranks(range(8), pairs)
    assert all(rank[first] != rank[second] for first, second in pairs if first != second)
    if pairs and pairs[0][0] != pairs[0][1]:
        first, second = pairs[0]
        assert rank[first] < rank[second]


def test_a_pair_that_closes_a_circle_stands_the_other_way_round() -> None:
    assert ranks("abc", [("a", "b"), ("b", "c"), ("c", "a")]) == {"a": 0, "b": 1, "c": 2}


@given(PAIRS, st.lists(st.floats(20.0, 200.0), min_size=8, max_size=8))
def test_nothing_overlaps_and_no_line_crosses_a_box(pairs: list[tuple[int, int]], widths: list[float]) -> None:
    pairs = [pair for pair in pairs if pair[0] != pair[1]]
    rank = ranks(range(8), pairs)
    rows: list[dict[Hashable, float]] = [{} for _ in range(max(rank.values()) + 1)]
    for name in range(8):
        rows[rank[name]][name] = widths[name]
    layout = lay_out(rows, [GraphEdge(first, second, 40.0) for first, second in pairs])
    for boxes in rows:
        places = sorted((layout.boxes[name], width) for name, width in boxes.items())
        for (x, width), (next_x, next_width) in pairwise(places):
            assert next_x - x >= (width + next_width) / 2 + BETWEEN - 1e-6
    for (first, second), way in zip(pairs, layout.ways, strict=True):
        assert way[0][0] == 2 * rank[first]
        assert way[-1][0] == 2 * rank[second]
        assert abs(way[0][1] - layout.boxes[first]) < widths[first] / 2
        for row_number, x in way[1:-1]:
            if row_number % 2 == 0:
                assert all(abs(x - layout.boxes[name]) > width / 2 for name, width in rows[row_number // 2].items())
    assert all(-1e-6 <= x <= layout.width + 1e-6 for way in layout.ways for _, x in way)


def test_the_same_boxes_and_lines_are_laid_out_alike() -> None:
    rows: list[dict[Hashable, float]] = [{"a": 50.0, "b": 60.0}, {"c": 40.0}]
    lines = [GraphEdge("a", "c", 30.0), GraphEdge("b", "c", 30.0)]
    assert lay_out(rows, lines) == lay_out(rows, lines)


def test_nothing_is_laid_out_as_nothing() -> None:
    assert lay_out([], []).width == 0.0

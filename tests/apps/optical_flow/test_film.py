"""Frames, looked at pixel by pixel."""

import numpy as np

from apps.optical_flow.film import GRAPH, HEIGHT, TEXT, WIDTH, bar_heights, draw_frame
from tests.apps.optical_flow.toy import columns

RATES = np.array([0.5, 0.25, 0.0, np.nan])
IMAGE = np.full((120, 160, 3), 60, np.uint8)
ARROW = [[80.0, 60.0, 60.0, 0.0]]  # px and px/s, from the middle to the right


def frame(words: str = "free") -> np.ndarray:
    return draw_frame(IMAGE, columns(0.0, RATES), ARROW, words)


def test_a_frame_shows_image_flow_graph_and_words() -> None:
    drawn = frame()
    assert drawn.shape == (HEIGHT + GRAPH + TEXT, WIDTH, 3)
    assert (drawn[5, 5] == 60).all()
    changed = np.argwhere((drawn[:HEIGHT] != 60).any(axis=2))
    (top, left), (bottom, right) = changed.min(axis=0), changed.max(axis=0)
    assert abs(left - 80.5 * 3) < 4  # the arrow begins at its point
    assert abs(right - (80.5 + 60 * 0.35) * 3) < 6
    assert abs((top + bottom) / 2 - 60.5 * 3) < 4
    assert (drawn[HEIGHT + GRAPH :] < 100).any()


def test_the_graph_has_a_bar_for_each_column_that_is_higher_the_nearer_it_is() -> None:
    near, farther, never, unknown = bar_heights(RATES)
    assert near is not None
    assert farther is not None
    assert near > farther > 0
    assert (never, unknown) == (0, None)
    graph = frame()[HEIGHT : HEIGHT + GRAPH]
    middles = [WIDTH * (2 * column + 1) // 8 + 1 for column in range(4)]  # beside the dotted lines
    reds = [int((graph[:, middle] == (47, 56, 181)).all(axis=1).sum()) for middle in middles]
    assert reds == [near, 0, 0, 0]
    assert (graph[-3, middles[3]] == 150).all()

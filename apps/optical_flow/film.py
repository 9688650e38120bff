"""Frames of a film with image, flow field and time to contact. OpenCV is loaded where it is used."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from apps.film import Pixels
from apps.optical_flow.columns import Floats, FlowColumns

WIDTH, HEIGHT = 480, 360  # px of the image in a frame
GRAPH, TEXT = 120, 34  # px of the graph and of the line of words below it
LONGEST = 20.0  # s of time to contact at the top of the graph
_ARROW = 0.35  # s of flow that an arrow shows
_LEAST = 4.0  # px/s; shorter flow is a dot
_GREEN, _ORANGE, _RED, _GREY = (74, 157, 42), (13, 140, 217), (47, 56, 181), (150, 150, 150)  # blue, green, red


@dataclass(frozen=True, slots=True, eq=False)
class FlowView:
    """What is drawn of one time.

    stamp: of the exposure, s. image: blue, green and red. columns: of this image. vectors: of its flow, rows of [x, y,
    right, down] in px of the image and px/s. words: situation and reason.
    """

    stamp: float
    image: Pixels
    columns: FlowColumns
    vectors: Sequence[Sequence[float]]
    words: str

    def frame(self) -> Pixels:
        """Return the drawing of it, as `draw_frame` makes it."""
        return draw_frame(self.image, self.columns, self.vectors, self.words)


def draw_frame(image: Pixels, columns: FlowColumns, vectors: Sequence[Sequence[float]], words: str) -> Pixels:
    """Return a frame: blue, green and red, shape (HEIGHT + GRAPH + TEXT, WIDTH, 3).

    Args:
        image: Blue, green and red, of any size.
        columns: Of the same image.
        vectors: Flow as rows of [x, y, right, down], px of the image and px/s.
        words: Situation and reason.
    """
    import cv2  # it takes long to load

    frame = np.full((HEIGHT + GRAPH + TEXT, WIDTH, 3), 255, np.uint8)
    frame[:HEIGHT] = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_LINEAR)
    across, down = WIDTH / image.shape[1], HEIGHT / image.shape[0]
    for x, y, right, below in vectors:
        begin = round((x + 0.5) * across), round((y + 0.5) * down)
        if np.hypot(right, below) * across < _LEAST:
            continue
        end = round((x + 0.5 + right * _ARROW) * across), round((y + 0.5 + below * _ARROW) * down)
        cv2.arrowedLine(frame[:HEIGHT], begin, end, (40, 220, 250), 1, cv2.LINE_AA, tipLength=0.3)
    _draw_graph(frame[HEIGHT : HEIGHT + GRAPH], columns.rates)
    _write(frame, words[:75], HEIGHT + GRAPH + 22)
    return frame


def bar_heights(rates: Floats) -> list[int | None]:
    """Return the height of each column's bar in the graph, px; None where the time is not known."""
    return [None if np.isnan(rate) else round(GRAPH * (1.0 - min(1.0, _time(rate) / LONGEST))) for rate in rates]


def _draw_graph(graph: Pixels, rates: Floats) -> None:
    """Draw a bar for each column: the nearer in time, the higher."""
    edges = np.linspace(0, WIDTH, len(rates) + 1).round().astype(int)
    for left, right, rate, height in zip(edges, edges[1:], rates, bar_heights(rates), strict=False):
        if height is None:
            graph[-6:, left + 1 : right] = _GREY
        else:
            colour = _RED if _time(rate) < 3.0 else _ORANGE if _time(rate) < 6.0 else _GREEN
            graph[GRAPH - height :, left + 1 : right] = colour
    for seconds in (5, 10, 15):
        row = round(GRAPH * seconds / LONGEST)
        graph[row, ::4] = _GREY
        _write(graph, f"{seconds} s", row - 2)


def _write(area: Pixels, words: str, row: int) -> None:
    import cv2

    cv2.putText(area, words, (6, row), cv2.FONT_HERSHEY_SIMPLEX, 0.38, (30, 30, 30), 1, cv2.LINE_AA)


def _time(rate: float) -> float:
    return 1.0 / rate if rate > 1.0 / LONGEST else LONGEST

"""What a program shows of its work on maps, such as that of the console: the payload of `<robot>/overlay/<program>`."""

from collections.abc import Iterable
from typing import Any

from geometry import Point


def overlay(
    words: str = "",
    *,
    points: Iterable[Point] = (),
    lines: Iterable[tuple[Point, Point]] = (),
    frame: str = "base_link",
) -> dict[str, Any]:
    """Return the payload, as JSON.

    Args:
        words: What the program does, in a few words.
        points: x and y, m.
        lines: Ends of each, m.
        frame: Of the points and lines, `base_link` or `odom`.
    """
    return {
        "frame": frame,
        "words": words,
        "points": [[round(x, 3), round(y, 3)] for x, y in points],
        "lines": [[round(value, 3) for end in line for value in end] for line in lines],
    }

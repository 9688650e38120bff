"""Colours by the names that world files use."""

from collections.abc import Mapping

Colour = tuple[float, float, float, float]
"""Red, green, blue, opacity; each 0 to 1."""

COLOURS: Mapping[str, Colour] = {
    "red": (0.80, 0.12, 0.12, 1.0),
    "orange": (0.93, 0.51, 0.12, 1.0),
    "yellow": (0.93, 0.82, 0.16, 1.0),
    "green": (0.16, 0.58, 0.24, 1.0),
    "blue": (0.14, 0.32, 0.75, 1.0),
    "white": (0.95, 0.95, 0.95, 1.0),
    "grey": (0.55, 0.55, 0.55, 1.0),
    "black": (0.10, 0.10, 0.10, 1.0),
    "brown": (0.62, 0.48, 0.34, 1.0),
}

"""Colours by the names that world files use."""

from collections.abc import Mapping

from p2os_emu.hints import nearest

Colour = tuple[float, float, float, float]
"""Red, green, blue, opacity; each 0 to 1."""

COLOURS: Mapping[str, Colour] = {
    "red": (0.80, 0.12, 0.12, 1.0),
    "orange": (0.93, 0.51, 0.12, 1.0),
    "yellow": (0.93, 0.82, 0.16, 1.0),
    "green": (0.16, 0.58, 0.24, 1.0),
    "blue": (0.14, 0.32, 0.75, 1.0),
    "white": (0.95, 0.95, 0.95, 1.0),
    "cream": (0.86, 0.85, 0.82, 1.0),
    "light grey": (0.75, 0.75, 0.73, 1.0),
    "grey": (0.55, 0.55, 0.55, 1.0),
    "dark grey": (0.30, 0.30, 0.32, 1.0),
    "black": (0.10, 0.10, 0.10, 1.0),
    "brown": (0.62, 0.48, 0.34, 1.0),
    "wood": (0.76, 0.58, 0.36, 1.0),
    "teal": (0.10, 0.55, 0.55, 1.0),
    "purple": (0.48, 0.22, 0.62, 1.0),
    "pink": (0.90, 0.50, 0.62, 1.0),
}


def check_colour(name: str) -> None:
    """See that there is such a colour.

    Raises:
        ValueError: There is not; the message names the nearest.
    """
    if name not in COLOURS:
        raise ValueError(f"there is no colour {name!r}; {nearest(name, COLOURS)}")

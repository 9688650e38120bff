"""Makes PNGs small by a palette of few colours."""

from pathlib import Path

from PIL import Image

COLOURS = 200  # in the palette


def make_small(path: Path) -> None:
    """Write a PNG anew with few colours, without transparency."""
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(path, optimize=True)

"""Size and rate of a camera's pictures: `320x240@10`."""

import re
from typing import NamedTuple

_WRITTEN = re.compile(r"(\d{1,5})x(\d{1,5})(?:@(\d{1,3}(?:\.\d{1,2})?))?")
WIDTHS = 32, 1280
HEIGHTS = 24, 960
RATES = 0.5, 30.0
USUAL_RATE = 10.0


class ImageFormat(NamedTuple):
    """width, height: pixels. rate: Hz."""

    width: int
    height: int
    rate: float

    def __str__(self) -> str:
        return f"{self.width}x{self.height}@{self.rate:g}"


def read_format(text: str) -> ImageFormat:
    """Read `WIDTHxHEIGHT@RATE`; the rate may be left out.

    Raises:
        ValueError: It is not written so, or beyond what a drawn camera can do.
    """
    found = _WRITTEN.fullmatch(text)
    if found is None:
        raise ValueError(f"{text!r} is no picture format; write WIDTHxHEIGHT@RATE, as 320x240@10")
    image = ImageFormat(int(found[1]), int(found[2]), float(found[3] or USUAL_RATE))
    for name, value, (least, most) in zip(image._fields, image, (WIDTHS, HEIGHTS, RATES), strict=True):
        if not least <= value <= most:
            raise ValueError(f"{name} {value:g} of {text!r} is not within {least:g} to {most:g}")
    return image

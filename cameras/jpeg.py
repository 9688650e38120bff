"""JPEG files, as far as one looks into them: are they whole, and how large is the picture."""

from struct import unpack_from

START, END = b"\xff\xd8", b"\xff\xd9"
MARKER = 0xFF
WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xDA)))
"""Markers that no length follows."""
NO_FRAMES = frozenset((0xC4, 0xC8, 0xCC))
"""Markers from 0xC0 to 0xCF that begin no frame."""


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Width and height in pixels; None of what is no whole JPEG.

    Source: ITU-T T.81, annex B: a frame's header gives its height and then its width.
    """
    if not isinstance(data, bytes):
        raise TypeError(f"a picture must be bytes, not {type(data).__name__}")
    if not (data.startswith(START) and data.rstrip(b"\0").endswith(END)):
        return None
    at = len(START)
    while at + 9 <= len(data):
        if data[at] != MARKER:
            return None
        kind = data[at + 1]
        if 0xC0 <= kind <= 0xCF and kind not in NO_FRAMES:
            height, width = unpack_from(">HH", data, at + 5)
            return width, height
        at += 1 if kind == MARKER else 2 if kind in WITHOUT_LENGTH else 2 + unpack_from(">H", data, at + 2)[0]
    return None

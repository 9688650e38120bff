"""Images: decoded from JPEG and PNG files within limits, checked, and encoded again.

Pixels are bytes in C order: (height, width, 3) in the order blue, green, red for a colour image, (height, width) for a
grey or binary one. A binary image has the values 0 and 255 only. Pixel (0, 0) is the upper left one.
"""

import zlib
from dataclasses import dataclass
from enum import Enum
from struct import error as struct_error
from struct import unpack_from
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float64]

MAX_PIXELS = 16_000_000
"""Pixels that an image may have. Larger ones are refused by their header, before memory is taken."""
MAX_BYTES = 32 << 20
"""Bytes that a file may have."""
_JPEG, _JPEG_END = b"\xff\xd8", b"\xff\xd9"
_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xDA)))  # markers that no length follows
_JPEG_NO_FRAMES = frozenset((0xC4, 0xC8, 0xCC))  # markers from 0xC0 to 0xCF that begin no frame
_JPEG_SCAN = 0xDA
_GREY_PNG = frozenset((0, 4))  # colour types of a PNG without colours (PNG specification, 11.2.2)


class VisionError(ValueError):
    """Something given to the vision package cannot be used. The message says what was expected and what to do."""


class ImageKind(Enum):
    """What the pixels of an image mean."""

    COLOUR = "colour"
    GREY = "grey"
    BINARY = "binary"


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """Pixels and what they mean. Operations return new images and never change these pixels."""

    pixels: Pixels
    kind: ImageKind

    @classmethod
    def of(cls, pixels: Pixels) -> Self:
        """Return pixels as an image, colour or grey by their shape.

        Raises:
            VisionError: It is no array of bytes of one of these shapes, or it is empty or too large.
        """
        if not isinstance(pixels, np.ndarray) or pixels.dtype != np.uint8:
            found = f"an array of {pixels.dtype}" if isinstance(pixels, np.ndarray) else type(pixels).__name__
            raise VisionError(f"an image must be an array of bytes (uint8), not {found}")
        if pixels.ndim not in (2, 3) or pixels.shape[2:] not in ((), (3,)):
            raise VisionError(
                f"an image has the shape (height, width) or (height, width, 3), not {pixels.shape}; convert it first"
            )
        _check_size(pixels.shape[1], pixels.shape[0])
        return cls(pixels, ImageKind.GREY if pixels.ndim == 2 else ImageKind.COLOUR)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Return the image of a JPEG or PNG file, as it was stored: an orientation in its EXIF data is not applied.

        Sixteen bits become eight, and transparency is dropped.

        Raises:
            VisionError: The file is of another kind, too large, or not complete.
        """
        if not isinstance(data, bytes | bytearray | memoryview):
            raise VisionError(f"an image file must be bytes, not {type(data).__name__}")
        data = bytes(data)
        if len(data) > MAX_BYTES:
            raise VisionError(f"the file has {len(data) >> 20} MiB; send one of at most {MAX_BYTES >> 20} MiB")
        try:
            width, height, is_grey = _header(data)
        except struct_error:
            raise VisionError("the file ends in its header; send the complete file") from None
        _check_size(width, height)
        flag = cv2.IMREAD_GRAYSCALE if is_grey else cv2.IMREAD_COLOR
        try:
            pixels = cv2.imdecode(np.frombuffer(data, np.uint8), flag | cv2.IMREAD_IGNORE_ORIENTATION)
        except cv2.error:
            pixels = None  # reported below, as files are that OpenCV returns nothing for
        if pixels is None or pixels.shape[:2] != (height, width):
            raise VisionError("the file is damaged: its pixels cannot be decoded; send it again")
        return cls.of(np.asarray(pixels, np.uint8))

    @property
    def width(self) -> int:
        """Pixels from left to right."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Pixels from top to bottom."""
        return int(self.pixels.shape[0])

    def encode(self, quality: int | None = None) -> bytes:
        """Return a file of the image: PNG, or JPEG of a quality from 1 to 100.

        Raises:
            VisionError: The quality is none.
        """
        if quality is None:
            return bytes(cv2.imencode(".png", self.pixels, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1])
        if not isinstance(quality, int) or not 1 <= quality <= 100:
            raise VisionError(f"the quality of a JPEG must be a whole number from 1 to 100, not {quality!r}")
        return bytes(cv2.imencode(".jpg", self.pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


def colour_pixels(pixels: Pixels, purpose: str) -> Pixels:
    """Return pixels that are a colour image.

    Args:
        pixels: Of any image.
        purpose: What needs them, the subject of the error.
    Raises:
        VisionError: They are not.
    """
    if Image.of(pixels).kind is not ImageKind.COLOUR:
        raise VisionError(f"{purpose} needs a colour image, not a grey one; use the image before it was made grey")
    return pixels


def grey_pixels(pixels: Pixels) -> Pixels:
    """Return the brightness of an image (ITU-R BT.601), shape (height, width); a grey image is returned as it is."""
    if Image.of(pixels).kind is ImageKind.COLOUR:
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), np.uint8)
    return pixels


def _check_size(width: int, height: int) -> None:
    if width < 1 or height < 1:
        raise VisionError("the image has no pixels")
    if width * height > MAX_PIXELS:
        raise VisionError(
            f"the image has {width} x {height} pixels, more than {MAX_PIXELS / 1e6:.0f} megapixels; make it smaller"
        )


def _header(data: bytes) -> tuple[int, int, bool]:
    """Return width, height, and whether the file has no colours."""
    if data.startswith(_JPEG):
        return _jpeg_header(data)
    if data.startswith(_PNG):
        return _png_header(data)
    raise VisionError("the data is neither a JPEG nor a PNG file; convert it to one of these")


def _jpeg_header(data: bytes) -> tuple[int, int, bool]:
    """Source: ITU-T T.81, annex B. No segment and no scan contains the start marker of a file, a torn one does."""
    whole = data.rstrip(b"\0")  # some cameras fill their buffers
    at, frame = len(_JPEG), None
    while at < len(data):
        if data[at] != 0xFF:
            raise VisionError("the file is damaged: no JPEG marker where one was expected; send it again")
        kind = data[at + 1] if at + 1 < len(data) else 0xFF
        if kind == _JPEG_SCAN:
            break
        if 0xC0 <= kind <= 0xCF and kind not in _JPEG_NO_FRAMES:
            height, width, components = unpack_from(">HHB", data, at + 5)
            frame = width, height, components == 1
        at += 1 if kind == 0xFF else 2 if kind in _JPEG_WITHOUT_LENGTH else 2 + unpack_from(">H", data, at + 2)[0]
    if frame is None:
        raise VisionError("the JPEG file ends before its image begins; send the complete file")
    if not whole.endswith(_JPEG_END):
        raise VisionError("the JPEG file is truncated: its end marker is missing; send the complete file")
    if whole.find(_JPEG, at) >= 0:
        raise VisionError("the JPEG file is torn: a second file begins inside it; send the files one by one")
    return frame


def _png_header(data: bytes) -> tuple[int, int, bool]:
    """Source: PNG specification, section 5: length, type, data and checksum of each chunk."""
    width, height, _, colours = unpack_from(">IIBB", data, len(_PNG) + 8)
    at = len(_PNG)
    while True:
        if at + 12 > len(data):
            raise VisionError("the PNG file is truncated: its last chunk is missing; send the complete file")
        (length,) = unpack_from(">I", data, at)
        chunk = data[at + 4 : at + 8 + length]
        at += 12 + length
        if at > len(data):
            raise VisionError("the PNG file is truncated: its last chunk is missing; send the complete file")
        if zlib.crc32(chunk) != unpack_from(">I", data, at - 4)[0]:
            raise VisionError("the PNG file is damaged: the checksum of a part is wrong; send it again")
        if chunk[:4] == b"IEND":
            return width, height, colours in _GREY_PNG

"""MJPEG: pictures one after the other in one endless HTTP answer, `multipart/x-mixed-replace`.

No port and no clock: bytes in, pictures out. A part tells its length, or ends where the next one begins. Many cameras
write into its head when the picture was taken, as `X-Timestamp: 1763812800.250000`.
"""

from email.message import Message
from math import isfinite
from typing import NamedTuple

MOST = 32 << 20
"""Bytes that one picture may have."""
DIGITS = 20
"""Of a length; Python refuses to read thousands of them."""
_HEAD_END = b"\r\n\r\n"


class NoPictures(ValueError):
    """What comes is no stream of pictures."""


class CameraPicture(NamedTuple):
    """jpeg: the file. taken: when, s by the clock of the camera; None where it does not tell."""

    jpeg: bytes
    taken: float | None = None


def boundary_of(content_type: str) -> bytes | None:
    """What separates the parts, from the answer's Content-Type; None where that is no multipart.

    Some cameras write the two dashes into it that belong before it; both ways are read alike.
    """
    message = Message()
    message["Content-Type"] = content_type
    boundary = message.get_param("boundary")
    if message.get_content_maintype() != "multipart" or not isinstance(boundary, str):
        return None
    return boundary.strip('"').removeprefix("--").encode("latin-1", "replace")


class MultipartDecoder:
    """Finds the parts in a stream."""

    def __init__(self, boundary: bytes) -> None:
        self._mark = b"--" + boundary
        self._buffer = bytearray()
        self._length: int | None = None  # of the part whose head has been read; -1 where it does not say
        self._taken: float | None = None
        self._searched = 0

    def receive(self, data: bytes) -> list[CameraPicture]:
        """Take bytes, in any pieces; returns the parts that are complete.

        Raises:
            NoPictures: There is no end to a part.
        """
        self._buffer += data
        found = []
        while (part := self._next()) is not None:
            found.append(part)
        if len(self._buffer) > MOST:
            raise NoPictures(f"it sends {MOST >> 20} MB without a picture among them")
        return found

    def _next(self) -> CameraPicture | None:
        if self._length is None and not self._read_head():
            return None
        if self._length == -1:
            return self._until_next_mark()
        assert self._length is not None  # the head has been read
        if len(self._buffer) < self._length:
            return None
        part = bytes(self._buffer[: self._length])
        self._forget(self._length)
        return CameraPicture(part, self._taken)

    def _read_head(self) -> bool:
        """Read on to where the next part's content begins."""
        begin = self._buffer.find(self._mark)
        if begin < 0:
            del self._buffer[: max(0, len(self._buffer) - len(self._mark))]
            return False
        end = self._buffer.find(_HEAD_END, begin)
        if end < 0:
            return False
        values = _values(bytes(self._buffer[begin:end]))
        length = values.get(b"content-length", b"")
        self._length = min(int(length[:DIGITS]), MOST + 1) if length.isdigit() else -1
        self._taken = _seconds(values.get(b"x-timestamp", b""))
        del self._buffer[: end + len(_HEAD_END)]
        self._searched = 0
        return True

    def _until_next_mark(self) -> CameraPicture | None:
        end = self._buffer.find(self._mark, max(0, self._searched - len(self._mark)))
        self._searched = len(self._buffer)
        if end < 0:
            return None
        part = bytes(self._buffer[:end]).removesuffix(b"\r\n")
        self._forget(end)
        return CameraPicture(part, self._taken)

    def _forget(self, count: int) -> None:
        del self._buffer[:count]
        self._length = None


def _values(head: bytes) -> dict[bytes, bytes]:
    """Return what a part's head says, by names in small letters."""
    lines = (line.partition(b":") for line in head.split(b"\r\n"))
    return {name.strip().lower(): value.strip() for name, _, value in lines}


def _seconds(text: bytes) -> float | None:
    """Return a finite number; None where there is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None

"""The protocol between an agent and its library process: a line of JSON, then the bytes that JSON cannot hold.

`{"function": name, "arguments": {…}, "blobs": {"image": 19200}}` and 19200 bytes out; `{"answer": {…}, "blobs": {…}}`
or `{"error": why}` back.
"""

import json
from collections.abc import Mapping
from typing import Any

from agents.wrappers.codec import Answered, Event, NonsenseHeard, ProgramCodec, RequestFailed

LARGEST = 64 * 1024 * 1024  # bytes of one frame; a picture of 4000 by 4000 in colour has 48 million


def answer(said: Mapping[str, Any] | str) -> bytes:
    """Return the frame with the result of a call, or with the text of its error."""
    if isinstance(said, str):
        return _packed({"error": said}, {})
    plain, blobs = _parted(said)
    return _packed({"answer": plain}, blobs)


def _parted(values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the values for JSON, and the bytes."""
    blobs = {key: value for key, value in values.items() if isinstance(value, bytes)}
    return {key: value for key, value in values.items() if key not in blobs}, blobs


def _packed(head: Mapping[str, Any], blobs: Mapping[str, bytes]) -> bytes:
    line = json.dumps({**head, "blobs": {key: len(blob) for key, blob in blobs.items()}})
    return b"".join((line.encode(), b"\n", *blobs.values()))


class FrameSplitter:
    """Splits portions of bytes into frames: the line's object, and the bytes by name."""

    def __init__(self) -> None:
        self._heard = bytearray()

    def receive(self, data: bytes) -> list[tuple[dict[str, Any], dict[str, bytes]]]:
        """Take some bytes.

        Raises:
            NonsenseHeard: They are no frames.
        """
        self._heard += data
        frames = []
        while (frame := self._next()) is not None:
            frames.append(frame)
        return frames

    def _next(self) -> tuple[dict[str, Any], dict[str, bytes]] | None:
        end = self._heard.find(b"\n")
        if end < 0:
            if len(self._heard) > LARGEST:
                raise NonsenseHeard("a frame is too large")
            return None
        try:
            head = json.loads(self._heard[:end])
            sizes = {str(name): int(size) for name, size in head.get("blobs", {}).items()}
        except (ValueError, AttributeError) as error:
            raise NonsenseHeard(f"it says {bytes(self._heard[:40])!r}, which begins no frame") from error
        if not 0 <= sum(sizes.values()) <= LARGEST or min(sizes.values(), default=0) < 0:
            raise NonsenseHeard("a frame is too large")
        if len(self._heard) < end + 1 + sum(sizes.values()):
            return None
        at, blobs = end + 1, {}
        for name, size in sizes.items():
            blobs[name] = bytes(self._heard[at : at + size])
            at += size
        del self._heard[:at]
        return head, blobs


class FramesCodec(ProgramCodec):
    """The agent's end."""

    def __init__(self) -> None:
        self._splitter = FrameSplitter()

    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """Encode one call."""
        plain, blobs = _parted(arguments)
        return _packed({"function": name, "arguments": plain}, blobs)

    def receive(self, data: bytes) -> list[Event]:
        """Decode the results of calls."""
        return [_event(head, blobs) for head, blobs in self._splitter.receive(data)]


def _event(head: dict[str, Any], blobs: dict[str, bytes]) -> Event:
    match head:
        case {"answer": dict(value)}:
            return Answered({**value, **blobs})
        case {"error": str(why)}:
            return RequestFailed(why)
    raise NonsenseHeard(f"the frame {head} is neither an answer nor an error")

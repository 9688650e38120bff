"""The newest sample of each key that a viewer looks at; one subscription serves all viewers."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from bus import JSON, Bus, MessageError, Sample, Subscription
from bus.aio import hand_over
from bus.bus import Closeable
from bus.messages import NS_PER_S, stamp_ns


@dataclass(frozen=True, slots=True)
class StreamItem:
    """What one sample holds.

    number: counts the samples of the stream, from 1. at: s of the loop's time when it came. stamp: s since 1970 of the
    exposure; None if it has none. image: a JPEG or PNG file, empty if there is none. values: the JSON object of a
    stream of numbers. trouble: why it cannot be used, or what its publisher reports of the image; empty for nothing.
    """

    number: int
    at: float
    stamp: float | None = None
    image: bytes = b""
    format: str = ""
    values: dict[str, Any] | None = None
    trouble: str = ""


class NewestItem:
    """The newest sample of one key. Samples come on the bus's thread, the rest is done in the event loop."""

    def __init__(self, bus: Bus, key: str) -> None:
        """Subscribe, in a running event loop."""
        self.key = key
        self.users = 0
        self.begun = asyncio.get_running_loop().time()
        self._loop = asyncio.get_running_loop()
        self._sample: Sample | None = None
        self._item: StreamItem | None = None  # the sample, decoded
        self._number = 0
        self._at = 0.0
        self._moved = asyncio.Event()
        self._subscription: Subscription = bus.subscribe(key, self._take, urgent=True)

    def close(self) -> None:
        """End the subscription."""
        self._subscription.close()

    @property
    def item(self) -> StreamItem | None:
        """The newest item; None before the first one."""
        if self._sample is not None and (self._item is None or self._item.number != self._number):
            self._item = read_item(self._sample, self._number, self._at)
        return self._item

    @property
    def silence(self) -> float:
        """s since the latest sample, or since the subscription began."""
        return self._loop.time() - (self._at or self.begun)

    async def newer(self, than: int, within: float) -> StreamItem | None:
        """Return the newest item once its number is higher; None if none comes in time, s."""
        try:
            async with asyncio.timeout(within):
                while self._number <= than:
                    await self._moved.wait()
        except TimeoutError:  # None says that none has come in time
            return None
        return self.item

    def _take(self, sample: Sample) -> None:  # on the bus's thread
        hand_over(self._loop, self._note, sample)

    def _note(self, sample: Sample) -> None:
        self._sample, self._at = sample, self._loop.time()
        self._number += 1
        self._moved.set()
        self._moved = asyncio.Event()


class SharedStreams(Closeable):
    """The streams that viewers look at. A stream ends some time after its last viewer, since viewers often return."""

    def __init__(self, bus: Bus, linger: float) -> None:
        """Begin without any.

        Args:
            bus: The bus.
            linger: s for which a stream stays subscribed after its last viewer.
        """
        self._bus = bus
        self._linger = linger
        self._streams: dict[str, NewestItem] = {}
        self._endings: dict[str, asyncio.TimerHandle] = {}

    @contextmanager
    def following(self, key: str) -> Iterator[NewestItem]:
        """Stay subscribed to a key during a block."""
        if ending := self._endings.pop(key, None):
            ending.cancel()
        stream = self._streams.get(key) or self._streams.setdefault(key, NewestItem(self._bus, key))
        stream.users += 1
        try:
            yield stream
        finally:
            stream.users -= 1
            if not stream.users and self._streams.get(key) is stream:
                loop = asyncio.get_running_loop()
                self._endings[key] = loop.call_later(self._linger, self._end, key)

    @property
    def keys(self) -> list[str]:
        """The keys that are subscribed to now."""
        return sorted(self._streams)

    def close(self) -> None:
        """End all subscriptions."""
        for ending in self._endings.values():
            ending.cancel()
        for stream in self._streams.values():
            stream.close()
        self._endings.clear()
        self._streams.clear()

    def _end(self, key: str) -> None:
        self._endings.pop(key, None)
        if stream := self._streams.pop(key, None):
            stream.close()


def read_item(sample: Sample, number: int, at: float) -> StreamItem:
    """Return what a sample holds: an image, or a JSON object; of any other sample only what is wrong with it."""
    try:
        content = sample.decoded()
        if sample.encoding == JSON:
            stamp = content.get("stamp")
            is_number = isinstance(stamp, int | float) and not isinstance(stamp, bool)
            return StreamItem(
                number, at, float(stamp) if is_number else None, values=content, trouble=_text(content.get("trouble"))
            )
        note = Sample(sample.key, sample.attachment, JSON).decoded() if sample.attachment else {}
        stamp = stamp_ns(content.header) / NS_PER_S
        return StreamItem(number, at, stamp, content.data.tobytes(), content.format, trouble=_text(note.get("trouble")))
    except (MessageError, AttributeError) as err:  # AttributeError: a message of another type
        return StreamItem(number, at, trouble=f"what comes on {sample.key} cannot be read: {err}")


def _text(trouble: object) -> str:
    return trouble if isinstance(trouble, str) else ""

"""Messages between agents to browsers over websockets.

Containers publish what their agents send only while somebody listens, so this listens only while a page shows it. A
browser requests what is new after it has drawn the last update, and names the last message that it has.
"""

import asyncio
import json
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from agents.sniffer.captured import ALL_THAT_IS_SAID, Heard, Unreadable, brief, read, shortened
from agents.sniffer.reorder import HOLD, ReorderBuffer
from apps.web.viewer import framed
from bus import Bus, BusError, Sample, Subscription
from bus.aio import hand_over

KEPT = 1000  # messages that can be shown again
_MOST = 300  # messages in one update
_WAIT = 0.5  # s after which a browser is answered although nothing has been said
_LABEL = 80  # characters of the content that are sent with an arrow
_NAME = 120  # characters of a name

NumberedMessage = tuple[int, Heard]


class MessageLog:
    """The newest messages, numbered from 1. number: of the newest."""

    def __init__(self, kept: int = KEPT) -> None:
        """Begin empty. kept: how many are kept."""
        self.number = 0
        self._kept: deque[NumberedMessage] = deque(maxlen=kept)

    def add(self, heard: Heard) -> None:
        """Add the newest."""
        self.number += 1
        self._kept.append((self.number, heard))

    def find(self, number: int) -> Heard | None:
        """Return a message; None if it is not kept any more."""
        return next((heard for each, heard in self._kept if each == number), None)

    def after(self, number: int, most: int = _MOST) -> tuple[list[NumberedMessage], int]:
        """Return the messages after one, `most` of the newest, and the number of those that are left out.

        A number that has not been given yet is of an earlier console: then all messages are new.
        """
        since = number if 0 <= number <= self.number else 0
        count = self.number - since
        found = [each for each in self._kept if each[0] > since][-most:]
        return found, count - len(found)


def message_row(number: int, heard: Heard) -> list[Any]:
    """Return a message for the browser: its number, s since 1970, sender, receivers, performative, protocol,
    conversation, the beginning of its content, and whether it tells that something is not done."""
    if isinstance(heard, Unreadable):
        return [
            number,
            heard.time,
            shortened(heard.container, _NAME),
            [],
            "unreadable",
            "",
            "",
            heard.why[:_LABEL],
            True,
        ]
    message = heard.message
    return [
        number,
        round(heard.time, 3),
        shortened(str(message.sender), _NAME),
        [shortened(str(each), _NAME) for each in message.receivers],
        str(message.performative),
        shortened(message.protocol, _NAME),
        shortened(message.conversation_id, _NAME),
        brief(message.content, _LABEL),
        heard.is_no,
    ]


class SnifferFeed:
    """What the agents of the team send each other, while a page shows it. log: the newest messages."""

    def __init__(self, bus: Bus) -> None:
        """Begin, in a running event loop; nothing is done until a browser looks."""
        self.log = MessageLog()
        self._bus = bus
        self._loop = asyncio.get_running_loop()
        self._in_order = ReorderBuffer()
        self._watching = 0
        self._subscription: Subscription | None = None
        self._is_due = False
        self._came = asyncio.Event()

    async def serve(self, browser: WebSocket, is_open: Callable[[], bool]) -> None:
        """Answer the requests of one browser until it ends.

        Args:
            browser: The websocket.
            is_open: Whether its page is.
        """
        await browser.accept()
        try:
            with self._listening() as trouble:
                while is_open():
                    number = _number_in(await browser.receive_text())
                    if number == self.log.number:
                        with suppress(TimeoutError):  # the reply tells that nothing has come
                            async with asyncio.timeout(_WAIT):
                                await self._came.wait()
                    found, left_out = self.log.after(number)
                    head = {"rows": [message_row(*each) for each in found], "left_out": left_out, "words": trouble}
                    await browser.send_bytes(framed({**head, "number": self.log.number}, b""))
                await browser.close(4001, "this page is not known; load it again")
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it was closed while a reply was awaited
            return

    @contextmanager
    def _listening(self) -> Iterator[str]:
        """Listen during a block; gives why that is not possible, empty if it is."""
        trouble = ""
        if self._subscription is None:
            try:
                take = partial(hand_over, self._loop, self._take)
                self._subscription = self._bus.subscribe(ALL_THAT_IS_SAID, take)
            except BusError as err:  # not allowed by the role, or closed
                trouble = str(err)
        self._watching += 1
        try:
            yield trouble
        finally:
            self._watching -= 1
            if not self._watching and self._subscription is not None:
                self._subscription.close()
                self._subscription = None

    def _take(self, sample: Sample) -> None:
        self._in_order.add(read(sample, time.time()), time.monotonic())
        if not self._is_due:
            self._is_due = True
            self._loop.call_later(HOLD, self._log_due)

    def _log_due(self) -> None:
        self._is_due = False
        for heard in self._in_order.due(time.monotonic()):
            self.log.add(heard)
        if self._in_order.waiting:
            self._is_due = True
            self._loop.call_later(HOLD / 4, self._log_due)
        self._came.set()
        self._came.clear()


def _number_in(text: str) -> int:
    """Return the number of the last message that a browser has; 0 if it has none."""
    try:
        number = json.loads(text)
    except (ValueError, RecursionError):
        return 0
    return number if isinstance(number, int) else 0

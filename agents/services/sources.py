"""Streams of the bus that subscribers share: each needs one subscription on the bus."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agents.platform import AgentName, NameNotValid
from agents.services.selection import Selection, Sieve
from bus import Refused, keys
from bus.messages import to_json


class Subscriber:
    """A subscriber to a source, and the newest value that it has not got yet.

    who: it. is_patient: it waits for its source, and for its return.
    """

    def __init__(self, who: AgentName, selection: Selection, is_patient: bool) -> None:
        self.who = who
        self.selection = selection
        self.is_patient = is_patient
        self.sieve = Sieve(selection)
        self._called = asyncio.Event()
        self._why_ended = ""
        self._is_checked = False

    def offer(self, value: Mapping[str, Any]) -> None:
        """Take a value of the source."""
        missing = [] if self._is_checked else self.selection.missing(value)
        self._is_checked = True
        if missing:
            self.end(f"there is no field {', '.join(missing)}; there are {', '.join(value)}")
            return
        self.sieve.offer(value)
        self._called.set()

    def end(self, why: str) -> None:
        """End it, since no more values will come."""
        self._why_ended = self._why_ended or why
        self._called.set()

    async def next(self) -> dict[str, Any]:
        """Return the next selected value, as soon as it is due.

        Raises:
            Refused: No more will come; the message says why. A waiting value is returned before.
        """
        now = asyncio.get_running_loop().time
        while True:
            value = self.sieve.take(now())
            if value is not None:
                return value
            wait = self.sieve.due(now())
            if wait is None and self._why_ended:
                raise Refused(self._why_ended)
            self._called.clear()
            try:
                async with asyncio.timeout(wait):
                    await self._called.wait()
            except TimeoutError:
                pass  # the time has come


Hear = Callable[[Any], Awaitable[None]]
Listen = Callable[[str, Hear], Callable[[], None]]
"""Has a coroutine function hear a key of the bus; returns what ends that."""


class StreamSource:
    """One stream, and its subscribers.

    key: where it flows. token: there while its maker lives. close: ends the subscription on the bus.
    """

    def __init__(self, key: str, listen: Listen) -> None:
        """Start without subscribers."""
        self.key = key
        self.token = token_of(key)
        self.close = listen(key, self.hear)
        self.subscribers: list[Subscriber] = []
        self._newest: Mapping[str, Any] | None = None

    async def hear(self, message: Any) -> None:
        """Take a message; it is converted to JSON once."""
        self._newest = value = to_json(message) if not isinstance(message, dict) else message
        for subscriber in self.subscribers:
            subscriber.offer(value)

    def join(self, subscriber: Subscriber) -> None:
        """Add a subscriber, which first gets the newest known value."""
        self.subscribers.append(subscriber)
        if self._newest is not None:
            subscriber.offer(self._newest)

    def lose(self, why: str) -> None:
        """Note that the publisher has gone: end the subscribers that do not wait, and forget the newest value."""
        self._newest = None
        for subscriber in self.subscribers:
            if not subscriber.is_patient:
                subscriber.end(why)


def source_key(agent: str, key: str) -> str:
    """Return the key of a subscriber's stream.

    Raises:
        Refused: It names none or two, or one that is not valid.
    """
    if bool(agent) == bool(key):
        raise Refused('name a source, and one only: "agent": "sonar@happy", or "key": "happy/odom"')
    if agent:
        try:
            return AgentName.parse(agent).results_key
        except NameNotValid as err:
            raise Refused(str(err)) from err
    if not all(keys.split(key)) or set("*$?#") & set(key) or key.startswith(("/", "@")) or key.endswith("/"):
        raise Refused(f"{key!r} is not the key of a stream; give one like happy/odom, without wildcards")
    topic = keys.topic_of(key)
    if topic is not None and topic.kind is not keys.Kind.STREAM:
        raise Refused(f"{key} is no stream but a {topic.kind}; subscribe to one of `acromovi topics`")
    if topic is keys.CAMERA:
        raise Refused(f"pictures are too large for messages; listen to {key} on the bus itself")
    return key


def token_of(key: str) -> str:
    """Return the liveliness token of a stream's publisher: an agent or a robot's gateway."""
    try:
        return AgentName.of_key(key).alive_key
    except NameNotValid:
        return f"{keys.split(key)[0]}/alive"


def maker_of(token: str) -> str:
    """Return the owner of a token, as text."""
    robot, suffix = keys.split(token)
    return f"the gateway of {robot}" if suffix == keys.ALIVE.suffix else str(AgentName.of_key(token))

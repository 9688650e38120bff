"""Streams of the bus that many subscribers share: one subscription on the bus each, however many want its values."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agents.platform import AgentName, NameNotValid
from agents.services.selection import Selection, Sieve
from bus import Refused, keys
from bus.messages import to_json


class Subscriber:
    """One who wants values of a source, and what it has not been told yet: the newest value, and no more than one.

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
        """A value has come."""
        missing = [] if self._is_checked else self.selection.missing(value)
        self._is_checked = True
        if missing:
            self.end(f"there is no field {', '.join(missing)}; there are {', '.join(value)}")
            return
        self.sieve.offer(value)
        self._called.set()

    def end(self, why: str) -> None:
        """No more values will come."""
        self._why_ended = self._why_ended or why
        self._called.set()

    async def next(self) -> dict[str, Any]:
        """The next value that is wanted, as soon as it may be told.

        Raises:
            Refused: No more will come; says why. What waited until then has been told before.
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
    """One stream, and those who want it.

    key: where it flows. token: there while its maker lives. close: ends the subscription on the bus.
    """

    def __init__(self, key: str, listen: Listen) -> None:
        """Begin to listen, without subscribers."""
        self.key = key
        self.token = token_of(key)
        self.close = listen(key, self.hear)
        self.subscribers: list[Subscriber] = []
        self._newest: Mapping[str, Any] | None = None

    async def hear(self, message: Any) -> None:
        """A message has come; it is made JSON once, for all."""
        self._newest = value = to_json(message) if not isinstance(message, dict) else message
        for subscriber in self.subscribers:
            subscriber.offer(value)

    def join(self, subscriber: Subscriber) -> None:
        """Tell one more, beginning with the newest value that is known."""
        self.subscribers.append(subscriber)
        if self._newest is not None:
            subscriber.offer(self._newest)

    def lose(self, why: str) -> None:
        """Its maker has gone: who is not patient is told, and what was the newest is so no more."""
        self._newest = None
        for subscriber in self.subscribers:
            if not subscriber.is_patient:
                subscriber.end(why)


def source_key(agent: str, key: str) -> str:
    """The key of the stream that a subscriber means.

    Raises:
        Refused: It names none or two, or what can be no source.
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
    """The token that is there while the maker of a stream lives: an agent's, or that of a robot's gateway."""
    try:
        return AgentName.of_key(key).alive_key
    except NameNotValid:
        return f"{keys.split(key)[0]}/alive"


def maker_of(token: str) -> str:
    """Who shows a token, in words."""
    robot, suffix = keys.split(token)
    return f"the gateway of {robot}" if suffix == keys.ALIVE.suffix else str(AgentName.of_key(token))

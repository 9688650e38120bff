"""The subscription service: a component's data at the rate of the application, filtered, on change.

    async with agent.subscribe("subscription@acromovi", "data", agent="sonar@happy", rate=2.0) as values:
        async for value in values:
            ...

Subscribers to the same source share one subscription on the bus. A source that is not present is refused, and one that
disappears ends the subscription with a failure, unless the subscriber sets `wait`: then it waits for the source and for
its return.
"""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from functools import partial
from typing import Any, ClassVar

from agents.platform import Agent, AgentName, NameNotValid, Restart, asker, request, subscription
from agents.platform.stream import Stream
from agents.services.selection import Selection, Sieve
from bus import Refused, keys
from bus import Subscription as Held
from bus.aio import hand_over
from bus.messages import to_json

TOKENS = ("*/alive", "*/agents/*/alive")
MEETING_TIME = 0.3  # s in which a session that has just been opened learns who is there
KEEP = 16  # messages of a source that wait while one is being dealt with


Hear = Callable[[Any], Awaitable[None]]
Listen = Callable[[str, Hear], Callable[[], None]]
"""Has a coroutine function hear a key of the bus; returns what ends that."""


class _Subscriber:
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


class _StreamSource:
    """One stream, and its subscribers.

    key: where it flows. token: there while its maker lives. close: ends the subscription on the bus.
    """

    def __init__(self, key: str, listen: Listen) -> None:
        """Start without subscribers."""
        self.key = key
        self.token = _token_of(key)
        self.close = listen(key, self.hear)
        self.subscribers: list[_Subscriber] = []
        self._newest: Mapping[str, Any] | None = None

    async def hear(self, message: Any) -> None:
        """Take a message; it is converted to JSON once."""
        self._newest = value = to_json(message) if not isinstance(message, dict) else message
        for subscriber in self.subscribers:
            subscriber.offer(value)

    def join(self, subscriber: _Subscriber) -> None:
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


class SubscriptionService(Agent):
    """Sends applications what components publish."""

    services: ClassVar[tuple[str, ...]] = ("subscription",)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._sources: dict[str, _StreamSource] = {}
        self._alive: set[str] = set()
        self._watching: list[Held] = []

    async def setup(self) -> None:
        """Watch the sources."""
        loop = asyncio.get_running_loop()

        def on_bus_thread(key: str, is_alive: bool) -> None:
            hand_over(loop, self._follow_token, key, is_alive)

        self._watching += [self.bus.watch_alive(expression, on_bus_thread) for expression in TOKENS]
        await asyncio.sleep(MEETING_TIME)

    async def take_down(self) -> None:
        """End all subscriptions."""
        for held in self._watching:
            held.close()
        for source in self._sources.values():
            source.close()

    @subscription("data")
    async def data(
        self,
        agent: str = "",
        key: str = "",
        rate: Any = None,
        fields: Any = None,
        on_change: Any = None,
        where: Any = None,
        wait: bool = False,
    ) -> AsyncIterator[dict[str, Any]]:
        """What an agent publishes, or what flows on a key; `selection.Selection` says what the filters mean."""
        wanted, selection = _source_key(agent, key), Selection.read(rate, fields, on_change, where)
        token = _token_of(wanted)
        if not wait and token not in self._alive:
            raise Refused(f"{_maker_of(token)} is not there; to wait for it, subscribe with wait=true")
        subscriber = _Subscriber(asker(), selection, wait)
        source = self._join(subscriber, wanted)
        try:
            while True:
                yield await subscriber.next()
        finally:
            self._leave(source, subscriber)

    @request("subscriptions")
    async def subscriptions(self) -> list[dict[str, Any]]:
        """Who subscribes to what, and how many values each was told, and was not because newer ones came."""
        return [
            {
                "subscriber": str(subscriber.who),
                "source": source.key,
                "is_there": source.token in self._alive,
                "rate": 1.0 / subscriber.selection.period if subscriber.selection.period else None,
                "fields": list(subscriber.selection.fields),
                "on_change": dict(subscriber.selection.on_change),
                "where": {path: dict(bounds) for path, bounds in subscriber.selection.where.items()},
                "told": subscriber.sieve.told,
                "skipped": subscriber.sieve.skipped,
            }
            for source in self._sources.values()
            for subscriber in source.subscribers
        ]

    def _listen(self, key: str, hear: Hear) -> Callable[[], None]:
        stream = Stream(key, hear, KEEP, partial(self.home.report, self.name, f"a sample on {key} is left out"))
        held = self.bus.subscribe(key, stream.take, urgent=True)
        running = self.add(stream, Restart())

        def close() -> None:
            held.close()
            running.stop()

        return close

    def _join(self, subscriber: _Subscriber, key: str) -> _StreamSource:
        if key not in self._sources:
            self._sources[key] = _StreamSource(key, self._listen)
        self._sources[key].join(subscriber)
        return self._sources[key]

    def _leave(self, source: _StreamSource, subscriber: _Subscriber) -> None:
        source.subscribers.remove(subscriber)
        if not source.subscribers:
            self._sources.pop(source.key).close()

    def _follow_token(self, token: str, is_alive: bool) -> None:
        (self._alive.add if is_alive else self._alive.discard)(token)
        for source in list(self._sources.values()):
            if source.token == token and not is_alive:
                source.lose(f"{_maker_of(token)} has gone")


def _source_key(agent: str, key: str) -> str:
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


def _token_of(key: str) -> str:
    """Return the liveliness token of a stream's publisher: an agent or a robot's gateway."""
    try:
        return AgentName.of_key(key).alive_key
    except NameNotValid:
        return f"{keys.split(key)[0]}/alive"


def _maker_of(token: str) -> str:
    """Return the owner of a token, as text."""
    robot, suffix = keys.split(token)
    return f"the gateway of {robot}" if suffix == keys.ALIVE.suffix else str(AgentName.of_key(token))

"""The agent from which an application gets a component's data at its own rate, filtered, on change.

    async with agent.subscribe("subscription@acromovi", "data", agent="sonar@happy", rate=2.0) as values:
        async for value in values:
            ...

Who subscribes to the same source shares one subscription on the bus. A source that is not there is refused, and one
that goes ends the subscription with a failure, unless the subscriber says `wait`: then it waits for the source, and
after that for its return.
"""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from functools import partial
from typing import Any, ClassVar

from agents.platform import Agent, AgentName, Restart, asker, request, subscription
from agents.platform.stream import Stream
from agents.services.selection import Selection, SelectionNotValid
from agents.services.sources import Hear, StreamSource, Subscriber, maker_of, source_key, token_of
from bus import Refused
from bus import Subscription as Held
from bus.aio import hand_over

TOKENS = ("*/alive", "*/agents/*/alive")
MEETING_TIME = 0.3  # s in which a session that has just been opened learns who is there
KEEP = 16  # messages of a source that wait while one is being dealt with


class SubscriptionService(Agent):
    """Tells applications what components publish."""

    services: ClassVar[tuple[str, ...]] = ("subscription",)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._sources: dict[str, StreamSource] = {}
        self._alive: set[str] = set()
        self._watching: list[Held] = []

    async def setup(self) -> None:
        """Learn who is there."""
        loop = asyncio.get_running_loop()

        def on_bus_thread(key: str, is_alive: bool) -> None:
            hand_over(loop, self._follow_token, key, is_alive)

        self._watching += [self.bus.watch_alive(expression, on_bus_thread) for expression in TOKENS]
        await asyncio.sleep(MEETING_TIME)

    async def take_down(self) -> None:
        """Listen no more."""
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
        wanted, selection = source_key(agent, key), read(rate, fields, on_change, where)
        token = token_of(wanted)
        if not wait and token not in self._alive:
            raise Refused(f"{maker_of(token)} is not there; to wait for it, subscribe with wait=true")
        subscriber = Subscriber(asker(), selection, wait)
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

    def _join(self, subscriber: Subscriber, key: str) -> StreamSource:
        if key not in self._sources:
            self._sources[key] = StreamSource(key, self._listen)
        self._sources[key].join(subscriber)
        return self._sources[key]

    def _leave(self, source: StreamSource, subscriber: Subscriber) -> None:
        source.subscribers.remove(subscriber)
        if not source.subscribers:
            self._sources.pop(source.key).close()

    def _follow_token(self, token: str, is_alive: bool) -> None:
        (self._alive.add if is_alive else self._alive.discard)(token)
        for source in list(self._sources.values()):
            if source.token == token and not is_alive:
                source.lose(f"{maker_of(token)} has gone")


def read(rate: Any, fields: Any, on_change: Any, where: Any) -> Selection:
    """What a subscriber wants.

    Raises:
        Refused: It cannot be given.
    """
    try:
        return Selection.read(rate, fields, on_change, where)
    except SelectionNotValid as err:
        raise Refused(str(err)) from err

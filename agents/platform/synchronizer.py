"""Synchronizes data of several sources by their stamps into sets.

    listen_together(self, {"sonar": sonar_key, "laser": scan_key}, stamp, self.look, tolerance=0.1, patience=1.0)

    async def look(self, measured):      # {"sonar": ..., "laser": ...}

A set is complete when it has a datum of every source and no two are further apart than the tolerance. Of those that
could be made the newest is, each datum is used once, and in every source sets follow each other in time. A source that
has kept a datum waiting for too long is missed: sets are then complete without it, until its data fit again.
"""

import asyncio
from bisect import bisect_left, insort
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from agents.platform.agent import Agent

D = TypeVar("D")

KEPT = 16  # data of each source that wait for those of others


@dataclass(frozen=True, slots=True)
class _Waiting(Generic[D]):
    stamp: float
    datum: D
    came: float


class Synchronizer(Generic[D]):
    """Matches data by their stamps; time is an argument.

    dropped: number of data that were in no set, since they came too late, or others took too long.
    """

    def __init__(self, sources: Iterable[str], *, tolerance: float, patience: float, keep: int = KEPT) -> None:
        """Make an empty one.

        Args:
            sources: Their names.
            tolerance: s by which stamps of one set may differ.
            patience: s that a datum waits for those of other sources; after it they are missed.
            keep: Data of each source that wait; beyond that the oldest is dropped.
        Raises:
            ValueError: A number is not valid, or there is no source.
        """
        self._waiting: dict[str, list[_Waiting[D]]] = {source: [] for source in sources}
        if not (self._waiting and tolerance >= 0.0 and patience > 0.0 and keep >= 1):
            raise ValueError("a synchronizer needs sources, a tolerance of at least 0 s, patience, and keeps a datum")
        self.dropped = 0
        self._tolerance = tolerance
        self._patience = patience
        self._keep = keep
        self._used = dict.fromkeys(self._waiting, -inf)  # stamps of the last set that each was in
        self._heard_at = dict.fromkeys(self._waiting, -inf)
        self._since: dict[str, float] = {}  # when the first datum came that waits, or was dropped, since the last set
        self._recent: deque[float] = deque(maxlen=keep)  # stamps of sets, for readmitting sources
        self._missed: set[str] = set()

    @property
    def missed(self) -> frozenset[str]:
        """The sources that are not waited for."""
        return frozenset(self._missed)

    def add(self, source: str, stamp: float, datum: D, now: float) -> dict[str, D] | None:
        """Take a datum.

        Args:
            source: Its source.
            stamp: s, when it was measured; data may come in any order.
            datum: Anything.
            now: s of a steady clock.
        Returns:
            The newest complete set, by source, where there is one now; missed sources may be absent.
        """
        if not isfinite(stamp) or stamp <= self._used[source] or stamp in self._stamps(source):
            self.dropped += 1
            return None
        waiting = self._waiting[source]
        insort(waiting, _Waiting(stamp, datum, now), key=_stamp)
        if len(waiting) > self._keep:
            self._drop(source, 1)
        self._heard_at[source] = now
        self._since.setdefault(source, now)
        self._welcome(source, stamp)
        self._lose_patience(source, now)
        return self._newest_set()

    def _welcome(self, source: str, stamp: float) -> None:
        """Readmit the missed sources that have a datum at this time."""
        if source not in self._missed:
            self._missed -= {each for each in self._missed if self._fits(stamp, self._stamps(each))}
        elif self._fits(stamp, self._recent) or any(self._fits(stamp, self._stamps(each)) for each in self._needed):
            self._missed.discard(source)

    def _lose_patience(self, source: str, now: float) -> None:
        """Mark sources as missed for which a datum of this source has waited too long."""
        if now - self._since[source] <= self._patience:
            return
        unlike = self._waiting.keys() - self._largest_with(self._waiting[source][0].stamp).keys()
        if source not in self._missed:
            self._missed |= unlike
        elif all(now - self._heard_at[each] > self._patience for each in self._needed):
            self._missed = unlike

    def _newest_set(self) -> dict[str, D] | None:
        needed = self._needed
        for earliest in sorted({stamp for source in needed for stamp in self._stamps(source)}, reverse=True):
            found = self._from(earliest)
            if needed <= found.keys():
                self._recent.append(earliest)
                return self._taken(found)
        return None

    def _from(self, earliest: float) -> dict[str, int]:
        """Return the first datum of each source from this time on, within the tolerance."""
        found = {}
        for source, waiting in self._waiting.items():
            place = bisect_left(waiting, earliest, key=_stamp)
            if place < len(waiting) and waiting[place].stamp - earliest <= self._tolerance:
                found[source] = place
        return found

    def _largest_with(self, stamp: float) -> dict[str, int]:
        """Return the largest set that a datum of this time can be in."""
        earliest = (each for source in self._waiting for each in self._stamps(source) if each <= stamp)
        return max((self._from(each) for each in earliest if self._fits(stamp, [each])), key=len)

    def _taken(self, found: Mapping[str, int]) -> dict[str, D]:
        taken = {}
        for source, place in found.items():
            chosen = self._waiting[source][place]
            taken[source] = chosen.datum
            self._used[source] = chosen.stamp
            del self._waiting[source][place]
            self._drop(source, place)
            self._since.pop(source, None)
            if self._waiting[source]:
                self._since[source] = min(each.came for each in self._waiting[source])
        return taken

    @property
    def _needed(self) -> set[str]:
        return self._waiting.keys() - self._missed

    def _stamps(self, source: str) -> Iterator[float]:
        return (each.stamp for each in self._waiting[source])

    def _fits(self, stamp: float, others: Iterable[float]) -> bool:
        return any(abs(stamp - other) <= self._tolerance for other in others)

    def _drop(self, source: str, count: int) -> None:
        del self._waiting[source][:count]
        self.dropped += count


def listen_together(
    agent: "Agent",
    keys: Mapping[str, str],
    stamp: Callable[[Any], float],
    hear: Callable[[dict[str, Any]], Awaitable[Any]],
    *,
    tolerance: float,
    patience: float,
) -> Synchronizer[Any]:
    """Call a coroutine function with each complete set of messages on several keys of the bus.

    Args:
        agent: The agent that subscribes.
        keys: Keys of the bus, by the names that the messages have in a set.
        stamp: Returns the stamp of a message, s.
        hear: Called with the messages of a set, by name.
        tolerance: s by which stamps of one set may differ.
        patience: s that a message waits for those of others; after it they are missed.
    """
    synchronizer: Synchronizer[Any] = Synchronizer(keys, tolerance=tolerance, patience=patience)

    def take_from(source: str) -> Callable[[Any], Awaitable[None]]:
        async def take(message: Any) -> None:
            loop = asyncio.get_running_loop()
            if (together := synchronizer.add(source, stamp(message), message, loop.time())) is not None:
                await hear(together)

        return take

    for source, key in keys.items():
        agent.listen(key, take_from(source), keep=KEPT)
    return synchronizer


def _stamp(waiting: _Waiting[Any]) -> float:
    return waiting.stamp

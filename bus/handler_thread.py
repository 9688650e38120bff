"""The thread on which the handlers of one session run.

Queries wait in a queue for each client, and the clients take turns, so that a client that floods delays itself only.
The queues are bounded: a query that does not fit is refused at once. Samples, tokens and replies share one queue in the
order of arrival; samples are dropped, the oldest of their subscription first, where a handler cannot keep up.
"""

import logging
import threading
from collections import Counter, deque
from typing import Any, NamedTuple

import zenoh

from bus.bus import JSON, MOST_WAITING
from bus.declared import HANDLER_GRACE, Listening
from bus.exchange import refusal

MOST_WAITING_IN_ALL = 1024
"""Waiting queries of all clients, at most: a program that pretends to be many clients cannot fill the memory."""
MOST_SAMPLES = 1024
"""Waiting samples of one subscription, at most."""
EVENTS = b""  # the queue of samples, tokens and replies

log = logging.getLogger("bus")


class _Work(NamedTuple):
    listening: Listening
    item: Any
    is_sample: bool = False  # may be dropped


class HandlerThread:
    """Runs handlers one after the other, in a daemon thread, since a handler that hangs must not keep the program."""

    def __init__(self) -> None:
        self._queues: dict[bytes, deque[_Work]] = {}  # by client; a dict keeps whose turn it is
        self._queries = 0
        self._samples: Counter[Listening] = Counter()
        self._late: set[Listening] = set()
        self._changed = threading.Condition()
        self._is_stopped = False
        self._thread = threading.Thread(target=self._run, name="bus", daemon=True)
        self._thread.start()

    def post(self, listening: Listening, item: Any) -> None:
        """Queue an item. Nothing is dropped, so this is only for items whose number is bounded."""
        with self._changed:
            self._put(EVENTS, _Work(listening, item))

    def post_sample(self, listening: Listening, sample: zenoh.Sample) -> None:
        """Queue a sample; drop the oldest of a subscription that is late."""
        with self._changed:
            if self._samples[listening] >= MOST_SAMPLES:
                self._drop_oldest(listening)
            self._samples[listening] += 1
            self._put(EVENTS, _Work(listening, sample, is_sample=True))

    def post_query(self, listening: Listening, query: zenoh.Query) -> None:
        """Queue a query of its client; refuse it if too many wait."""
        attachment = query.attachment
        client = attachment.to_bytes() if attachment else str(query.key_expr).encode()
        with self._changed:
            waiting = len(self._queues.get(client, ()))
            is_full = waiting >= MOST_WAITING or self._queries >= MOST_WAITING_IN_ALL
            if not is_full:
                self._queries += 1
                self._put(client, _Work(listening, query))
        if is_full:
            with query:
                why = f"{self._queries if waiting < MOST_WAITING else waiting} queries wait already; ask less often"
                query.reply_err(refusal(why), encoding=JSON)

    def stop(self) -> None:
        """End after the items in the queues; a handler that hangs is not waited for."""
        with self._changed:
            self._is_stopped = True
            self._changed.notify()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=HANDLER_GRACE)

    def _put(self, queue: bytes, work: _Work) -> None:
        self._queues.setdefault(queue, deque()).append(work)
        self._changed.notify()

    def _drop_oldest(self, listening: Listening) -> None:
        queue = self._queues[EVENTS]
        del queue[next(at for at, work in enumerate(queue) if work.is_sample and work.listening is listening)]
        self._samples[listening] -= 1
        if listening not in self._late:
            self._late.add(listening)
            log.warning("a handler is too slow: of more than %d waiting samples the oldest are dropped", MOST_SAMPLES)

    def _next(self) -> _Work | None:
        """Wait for the next item, and return it; None when all are done and the thread is to end."""
        with self._changed:
            self._changed.wait_for(lambda: self._queues or self._is_stopped)
            if not self._queues:
                return None
            client = next(iter(self._queues))
            queue = self._queues.pop(client)
            work = queue.popleft()
            if queue:
                self._queues[client] = queue  # behind all others
            if client != EVENTS:
                self._queries -= 1
            elif work.is_sample:
                self._samples[work.listening] -= 1
                if not self._samples[work.listening]:
                    del self._samples[work.listening]
                    self._late.discard(work.listening)
            return work

    def _run(self) -> None:
        while (work := self._next()) is not None:
            work.listening.hear(work.item)

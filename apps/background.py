"""Requests of an application to its robots, in threads: a robot that does not answer holds up nothing else."""

from collections.abc import Callable, Hashable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

from agents import Robot, RobotError, Stopped


class BackgroundRequests:
    """At most one request of each kind is under way.

    The loop of the application begins each request, so a loop that hangs begins no more, and its robots soon count as
    unattended and stop. For that, no request may wait long for its answer.
    """

    def __init__(self, most: int, name: str) -> None:
        """most: requests at the same time. name: of the threads."""
        self._pool = ThreadPoolExecutor(most, name)
        self._busy: dict[Hashable, Future[Any]] = {}

    def begin(self, kind: Hashable, function: Callable[..., Any], *arguments: object) -> "Future[Any]":
        """Begin a request, and return it; one of the kind that has not been taken yet is returned instead."""
        if kind not in self._busy:
            self._busy[kind] = self._pool.submit(function, *arguments)
        return self._busy[kind]

    def take(self, kind: Hashable) -> "Future[Any] | None":
        """Return the request of a kind that has ended, so that the next one can begin; None if there is none."""
        request = self._busy.get(kind)
        return self._busy.pop(kind) if request is not None and request.done() else None

    def close(self) -> None:
        """Begin no more requests."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def stop_first(robots: Iterable[Robot]) -> None:
    """Stop robots when an application ends, before it draws what it has recorded.

    A robot that is driven goes on for a second after the last call of a program, and for longer than that while the
    program makes calls for other things.
    """
    for robot in robots:
        with suppress(RobotError, Stopped):  # the application's own reason to end counts for more
            robot.base.stop()

"""Buses that meet, of either kind, and names that no parallel test shares."""

import uuid
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from bus import Bus, MemoryBus, MemoryNetwork, ZenohBus

Until = Callable[..., None]


def _note(seen: list[str], token: str, is_alive: bool) -> None:
    seen.append(token)


def _has(seen: list[str], wanted: int) -> bool:
    return len(seen) == wanted


class Meeting:
    """Makes buses that meet each other."""

    def __init__(self, kind: str, until: Until) -> None:
        self.kind = kind
        self._until = until
        self.buses: list[Bus] = []
        self._network = MemoryNetwork()

    def join(self) -> Bus:
        bus: Bus = MemoryBus(self._network) if self.kind == "memory" else ZenohBus.open()
        self.buses.append(bus)
        return bus

    def let_pass(self, seconds: float) -> None:
        """Let time pass where it does not pass by itself."""
        if self.kind == "memory":
            self._network.let_pass(seconds)

    def settle(self) -> None:
        """Wait until every bus knows what the others have declared so far: a token declared later has come through."""
        key = f"settled-{uuid.uuid4().hex}"
        tokens = [bus.declare_alive(f"{key}/{number}") for number, bus in enumerate(self.buses)]
        for bus in self.buses:
            seen: list[str] = []
            with bus.watch_alive(f"{key}/*", partial(_note, seen)):
                self._until(partial(_has, seen, len(tokens)), "all buses have met")
        for token in tokens:
            token.close()


@pytest.fixture(params=["memory", "zenoh"])
def meeting(request: pytest.FixtureRequest, until: Until) -> Iterator[Meeting]:
    meeting = Meeting(request.param, until)
    yield meeting
    for bus in meeting.buses:
        bus.close()


@pytest.fixture
def zenoh_meeting(until: Until) -> Iterator[Meeting]:
    meeting = Meeting("zenoh", until)
    yield meeting
    for bus in meeting.buses:
        bus.close()

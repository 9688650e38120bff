"""A program that has just joined waits longer for one it has not met yet than for one that is not there."""

from threading import Condition

import pytest

from bus import MemoryBus, ZenohBus
from bus.loopback import LocalBus, Registration
from bus.meeting import wait_for_others


class JustJoined(MemoryBus):
    """Has met all once it was asked this often."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks = looks

    @property
    def has_met_all(self) -> bool:
        self.looks -= 1
        return self.looks < 0


def test_one_that_is_met_late_is_waited_for() -> None:
    bus, changed = JustJoined(5), Condition()
    with changed:
        assert wait_for_others(bus, changed, lambda: bus.looks <= 0 and "there", timeout=0.0) == "there"


def test_one_that_is_not_there_is_not_waited_for_any_longer_once_all_are_met() -> None:
    bus, changed = JustJoined(3), Condition()
    with changed:
        assert not wait_for_others(bus, changed, lambda: False, timeout=0.0)
    assert bus.looks == -1, "it gave up at the first look after all were met"


def test_a_session_has_not_met_all_as_long_as_one_that_is_registered_does_not_answer(
    robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    local = LocalBus(f"test-{robot}")
    with ZenohBus.open(f"local:{local.name}") as alone:
        assert alone.has_met_all
    with Registration(local), ZenohBus.open(f"local:{local.name}") as bus:
        assert not bus.has_met_all
        monkeypatch.setattr("bus.session.LATE_MEETING_TIME", -1.0)
        assert bus.has_met_all, "nobody is waited for for ever"

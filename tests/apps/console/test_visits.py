"""Pages that end with their session or certificate: what they drive is stopped, whatever becomes of the other pages."""

import asyncio
import time
from typing import TYPE_CHECKING

import pytest

from apps.console.program import Console
from apps.console.visits import Visit, Visits
from bus import keys
from tests.apps.console.conftest import PASSWORD

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab


class Room:
    """Visits whose leases are noted when they are given back. slow: names of pages whose leases never are."""

    def __init__(self, *slow: str) -> None:
        self.released: list[str] = []
        self.slow = slow
        self.visits = Visits(self.release)

    async def release(self, visit: Visit, why: str) -> None:
        self.released.append(visit.session or visit.owner)
        if visit.session in self.slow:
            await asyncio.Event().wait()


async def settled() -> None:
    """Let everything that is under way go on."""
    for _ in range(5):
        await asyncio.sleep(0.0)


def test_only_the_pages_of_a_session_end_and_can_command_nothing_then() -> None:
    async def act() -> tuple[Room, Visit, Visit, list[str]]:
        room, told = Room(), list[str]()
        mine, other = room.visits.begin("1.2.3.4", "mine"), room.visits.begin("1.2.3.5", "other")
        mine.on_end = told.append
        motion = asyncio.ensure_future(asyncio.sleep(3600.0))
        mine.motions.add(motion)
        await room.visits.end_session("mine", "its time is over")
        await settled()
        assert motion.cancelled()
        return room, mine, other, told

    room, mine, other, told = asyncio.run(act())
    assert (room.released, told) == (["mine"], ["its time is over"])
    assert (mine.may_command, mine.look_only) == (False, "its time is over")
    assert other.may_command
    assert mine.ticket not in room.visits
    assert other.ticket in room.visits


def test_a_page_ends_when_its_certificate_expires_and_tells_whose_it_was() -> None:
    async def act() -> tuple[Room, list[str]]:
        room, told = Room(), list[str]()
        expired = room.visits.begin("1.2.3.4", owner="operator.anna", expires=time.time() - 1.0)
        room.visits.begin("1.2.3.4", owner="operator.bert", expires=time.time() + 3600.0)
        room.visits.begin("1.2.3.4")
        expired.on_end = told.append
        await room.visits.end_expired()
        await room.visits.end_expired()
        return room, told

    room, told = asyncio.run(act())
    assert room.released == ["operator.anna"]
    (words,) = told
    assert words.startswith("the certificate of operator.anna has expired on ")


def test_neither_an_error_nor_slow_leases_keep_another_page_from_ending() -> None:
    def fail(why: str) -> None:
        raise RuntimeError("its browser is gone")

    async def act() -> Room:
        room = Room("slow")
        for owner in ("slow", "wrong", "third"):
            room.visits.begin("1.2.3.4", owner, expires=0.0)
        room.visits.begin("1.2.3.4", "failing", expires=0.0).on_end = fail
        room.visits.begin("1.2.3.4", "last", expires=0.0)
        ending = asyncio.ensure_future(room.visits.end_expired())
        await settled()
        with pytest.raises(RuntimeError, match="its browser is gone"):
            await ending
        return room

    room = asyncio.run(act())
    assert sorted(room.released) == ["failing", "last", "slow", "third", "wrong"]


@pytest.mark.parametrize("is_stopped", [False, True])
def test_pages_end_in_time_though_the_agent_of_the_console_is_suspended_or_stopped(
    lab: "Lab", console: Console, is_stopped: bool
) -> None:
    assert console.sessions is not None
    session = asyncio.run(console.sessions.begin(PASSWORD))  # which waits for a thread, as virtual time cannot
    anna, bert = console.visits.begin("1.2.3.4", owner="operator.anna"), console.visits.begin("1.2.3.5")
    anna.robot, anna.sockets = "happy", 1
    drive = console.drive_of("happy")
    lab.do(drive.take(anna, ("base",), lab.loop.time()))
    assert drive.token("base")
    if is_stopped:
        lab.do(lab.office.stop(lab.app.name))
    else:
        lab.office.suspend(lab.app.name)
    anna.expires, bert.session = time.time(), session
    lab.run(0.5)
    assert [each.ticket in console.visits for each in (anna, bert)] == [False, False]
    assert anna.look_only.startswith("the certificate of operator.anna has expired")
    assert bert.look_only.endswith("a session lasts no longer")
    assert drive.holder is None
    assert lab.bus.query(keys.LEASE_STATE.key("happy"), {})[0].value["elements"] == {}

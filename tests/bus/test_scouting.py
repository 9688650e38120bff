"""Plain Zenoh programs are asked, and told where a session of ours listens."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from bus import ZenohBus
from bus.scouting import SCOUT, Scouting, hello, is_hello
from tests.plain_zenoh import plain_session

Until = Callable[..., None]
ZID, LOCATOR = "10203", "tcp/127.9.9.9:7"
# By Zenoh's description of its scouting messages, version 9: header, version, flags, identity little-endian, locators.
HELLO = bytes((0x22, 9, 0x21, 0x03, 0x02, 0x01, 1, len(LOCATOR))) + LOCATOR.encode()


@pytest.fixture
def group() -> Iterator[socket.socket]:
    """Somebody who is at the multicast address, as a plain Zenoh program is; bound to a port of its own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as member:
        member.bind(("224.0.0.224", 0))
        request = socket.inet_aton("224.0.0.224") + socket.inet_aton("127.0.0.1")
        member.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)
        member.settimeout(20.0)
        yield member


@pytest.fixture
def scouting(group: socket.socket) -> Iterator[Scouting]:
    with Scouting(group.getsockname(), ZID, LOCATOR) as scouting:
        yield scouting


def test_datagrams_are_those_of_zenohs_protocol() -> None:
    assert bytes((0x01, 9, 0x02)) == SCOUT
    assert hello(ZID, LOCATOR) == HELLO
    assert is_hello(HELLO)
    assert not any(map(is_hello, (b"", SCOUT, HELLO[:2], bytes((0x22, 9, 0x20, 1)))))  # the last is a router's


@pytest.mark.usefixtures("scouting")
def test_whoever_answers_a_scout_is_told_where_the_session_listens(group: socket.socket) -> None:
    datagram, sender = group.recvfrom(100)
    assert datagram == SCOUT
    assert sender[0] == "127.0.0.1"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.settimeout(20.0)
        for nonsense in (b"", b"\xff" * 2000, SCOUT):
            plain.sendto(nonsense, sender)
        plain.sendto(HELLO, sender)
        assert plain.recvfrom(100) == (HELLO, sender)


def test_it_asks_again_and_at_once_when_somebody_was_lost(group: socket.socket, scouting: Scouting) -> None:
    assert group.recv(100) == group.recv(100) == SCOUT
    scouting.hurry()
    assert group.recv(100) == SCOUT


def test_it_ends_when_it_is_closed(scouting: Scouting) -> None:
    scouting.close()
    scouting.close()
    scouting.hurry()  # news of a lost session may come late
    assert "scouting" not in {thread.name for thread in threading.enumerate()}


@pytest.mark.parametrize("first", ["ours", "plain"])
def test_a_plain_program_meets_a_session_of_ours(robot: str, until: Until, first: str) -> None:
    with ExitStack() as stack:
        early = stack.enter_context(plain_session()) if first == "plain" else None
        ours = stack.enter_context(ZenohBus.open())
        plain = early or stack.enter_context(plain_session())
        ours.serve(f"{robot}/q", lambda given: {"ok": True})
        until(lambda: any(reply.ok for reply in plain.get(f"{robot}/q")), "the plain program gets an answer")

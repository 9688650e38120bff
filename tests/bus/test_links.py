"""Links that Zenoh has lost from sight are cut."""

import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import cast

import pytest
import zenoh

import bus.links
from bus.links import Ends, LinkWatch, cut
from bus.timers import Timers
from tests.waiting import wait_until

PUT, DELETE = zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE
FIRST, SECOND = Ends("other", 7447, 40001), Ends("other", 7447, 40002)
THIRD, FOURTH = Ends("third", 7447, 40003), Ends("third", 7447, 40004)
STRANGERS = Ends("stranger", 7447, 40005)


@dataclass
class Link:
    zid: str
    src: str
    dst: str


def link(ends: Ends) -> Link:
    return Link(ends.peer, f"tcp/127.0.0.1:{ends.here}", f"tcp/[::1]:{ends.there}?prio=1-7")


@dataclass
class Event:
    kind: zenoh.SampleKind
    link: Link | None = None
    transport: Link | None = None


@dataclass
class Session:
    """Links that come and go as told, and what has been cut."""

    known: list[Ends] = field(default_factory=list)
    cut: list[Ends] = field(default_factory=list)
    hear_link: Callable[[Event], None] = print
    hear_transport: Callable[[Event], None] = print

    def declare_link_events_listener(self, handler: Callable[[Event], None], history: bool) -> None:
        self.hear_link = handler

    def declare_transport_events_listener(self, handler: Callable[[Event], None]) -> None:
        self.hear_transport = handler

    def links(self) -> list[Link]:
        return [Link("other", "unixpipe/here", "unixpipe/there"), *map(link, self.known)]

    def opens(self, *links: Ends) -> None:
        """A transport is opened with these links."""
        self.hear_transport(Event(PUT, transport=link(links[0])))
        for one in links:
            self.joins(one)

    def joins(self, one: Ends) -> None:
        """A link is added to a transport."""
        self.known.append(one)
        self.hear_link(Event(PUT, link=link(one)))

    def loses(self, one: Ends) -> None:
        """A transport loses a link."""
        self.known.remove(one)
        self.hear_link(Event(DELETE, link=link(one)))

    def closes(self, peer: str) -> None:
        """A transport ends, and whatever is known of the peer with it."""
        self.hear_transport(Event(DELETE, transport=Link(peer, "", "")))
        self.known = [one for one in self.known if one.peer != peer]


@pytest.fixture
def session() -> Session:
    return Session()


@pytest.fixture
def watch(session: Session) -> Iterator[LinkWatch]:
    timers = Timers()
    watch = LinkWatch(cast(zenoh.SessionInfo, session), timers, session.cut.append)
    session.opens(STRANGERS)
    yield watch
    watch.close()
    timers.close()


def test_a_link_that_is_lost_and_opened_anew_is_left_alone(session: Session, watch: LinkWatch) -> None:
    session.opens(FIRST)
    session.loses(FIRST)
    session.closes("other")
    session.opens(SECOND)
    watch.look()
    assert session.cut == []


def test_a_link_that_is_forgotten_as_the_one_before_is_cleared_away_twice_is_cut(
    session: Session, watch: LinkWatch
) -> None:
    session.opens(FIRST)
    session.loses(FIRST)
    session.closes("other")
    session.opens(SECOND)
    session.closes("other")
    watch.look()
    assert session.cut == [SECOND]


def test_a_link_that_has_joined_a_transport_which_then_loses_its_first_is_cut(
    session: Session, watch: LinkWatch
) -> None:
    session.opens(FIRST)
    session.joins(SECOND)
    session.loses(FIRST)
    watch.look()
    assert session.cut == [SECOND]


def test_two_links_that_end_together_leave_nothing_to_cut(session: Session, watch: LinkWatch) -> None:
    session.opens(FIRST, SECOND)
    session.loses(FIRST)
    session.loses(SECOND)
    session.closes("other")
    watch.look()
    assert session.cut == []


def test_it_looks_a_while_after_each_loss(monkeypatch: pytest.MonkeyPatch, session: Session, watch: LinkWatch) -> None:
    monkeypatch.setattr(bus.links, "SETTLED_AFTER", 0.01)
    for lost, left in ((FIRST, SECOND), (THIRD, FOURTH)):
        session.opens(lost, left)
        session.loses(lost)
        wait_until(partial(session.cut.__contains__, left), "what is left is cut")


def test_two_losses_are_each_given_their_time(
    monkeypatch: pytest.MonkeyPatch, session: Session, watch: LinkWatch
) -> None:
    monkeypatch.setattr(bus.links, "SETTLED_AFTER", 0.01)
    session.opens(FIRST, SECOND)
    session.opens(THIRD, FOURTH)
    session.loses(FIRST)
    session.loses(THIRD)
    wait_until(lambda: set(session.cut) == {SECOND, FOURTH}, "both are cut")


def test_nobody_waits_as_long_as_nothing_is_lost_nor_after_the_end(session: Session, watch: LinkWatch) -> None:
    before = threading.active_count()
    session.opens(FIRST, SECOND)
    watch.close()
    session.loses(FIRST)
    session.closes("other")
    assert threading.active_count() == before


def test_a_connection_that_is_cut_ends_for_both_sides() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()) as ours:
        theirs, _ = server.accept()
        with theirs:
            assert cut(Ends("other", ours.getsockname()[1], ours.getpeername()[1]))
            assert ours.recv(1) == theirs.recv(1) == b""


def test_there_is_nothing_to_cut_between_ports_that_are_not_connected() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()) as ours:
        here, there = ours.getsockname()[1], ours.getpeername()[1]
        assert not cut(Ends("other", here, 1))
        theirs, _ = server.accept()
        with theirs:
            ours.send(b"x")
            assert theirs.recv(1) == b"x"
        assert there == server.getsockname()[1]

"""The control socket: one JSON object a line each way, whatever clients do."""

import contextlib
import json
import select
import socket
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from p2os_emu.control import ControlSocket, RequestError
from p2os_emu.links.link import PortError
from p2os_emu.links.poller import Poller
from tests.waiting import Deadline, patience


class Office:
    """A control socket whose desk repeats what it is asked."""

    def __init__(self, path: Path) -> None:
        self.asked: list[Mapping[str, Any]] = []
        self.poller = Poller()
        self.control = ControlSocket(path, self.poller, self.answer)
        self.visitors: list[socket.socket] = []

    def answer(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        self.asked.append(request)
        if request.get("do") == "refuse":
            raise RequestError("not today")
        return {"asked": request}

    def visitor(self) -> socket.socket:
        visitor = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        visitor.connect(str(self.control.path))
        visitor.setblocking(False)
        self.visitors.append(visitor)
        return visitor

    def turn(self) -> None:
        self.poller.poll()
        self.control.serve()

    def until(self, condition: Callable[[], bool]) -> None:
        deadline = Deadline()
        while not condition():
            assert not deadline.has_passed(), deadline.in_words("the office does what the test waits for")
            self.turn()
            select.select([], [], [], 0.001)

    def answers(self, visitor: socket.socket, count: int) -> list[dict[str, Any]]:
        heard = bytearray()

        def complete() -> bool:
            try:
                heard.extend(visitor.recv(65536))
            except BlockingIOError:  # nothing more has come yet
                return False
            return heard.count(b"\n") >= count

        self.until(complete)
        return [json.loads(line) for line in heard.splitlines()]

    def is_shut_out(self, visitor: socket.socket) -> bool:
        try:
            return visitor.recv(65536) == b""
        except BlockingIOError:  # the connection is open
            return False
        except ConnectionResetError:  # it was closed while bytes waited
            return True

    def close(self) -> None:
        for visitor in self.visitors:
            visitor.close()
        self.control.close()
        self.poller.close()


@pytest.fixture
def office(tmp_path: Path) -> Iterator[Office]:
    office = Office(tmp_path / "control")
    yield office
    office.close()


def test_every_line_has_one_answer_in_order(office: Office) -> None:
    visitor = office.visitor()
    visitor.send(b'{"do": "a"}\n{"do": "refuse"}\n\n{"do": "c"}\n')
    assert office.answers(visitor, 3) == [
        {"ok": True, "asked": {"do": "a"}},
        {"ok": False, "error": "not today"},
        {"ok": True, "asked": {"do": "c"}},
    ]


def test_line_may_come_byte_by_byte(office: Office) -> None:
    visitor = office.visitor()
    for byte in b'{"do": "a"}\n':
        visitor.send(bytes([byte]))
        office.turn()
    assert office.answers(visitor, 1) == [{"ok": True, "asked": {"do": "a"}}]


@pytest.mark.parametrize("line", [b"{", b"[]", b"7", b"\xff\xfe", b"[" * 60_000, b"nonsense"])
def test_bad_line_is_answered_and_the_socket_lives_on(office: Office, line: bytes) -> None:
    visitor = office.visitor()
    visitor.send(line + b'\n{"do": "a"}\n')
    refused, met = office.answers(visitor, 2)
    assert not refused["ok"]
    assert refused["error"]
    assert met["ok"]
    assert office.asked == [{"do": "a"}]


def test_two_clients_do_not_hear_each_others_answers(office: Office) -> None:
    first, second = office.visitor(), office.visitor()
    first.send(b'{"do": "first"}\n')
    second.send(b'{"do": "second"}\n')
    assert office.answers(second, 1)[0]["asked"] == {"do": "second"}
    assert office.answers(first, 1)[0]["asked"] == {"do": "first"}


def test_client_that_sends_no_more_is_answered_and_then_closed(office: Office) -> None:
    visitor = office.visitor()
    visitor.send(b'{"do": "a"}\n')
    visitor.shutdown(socket.SHUT_WR)
    assert office.answers(visitor, 1)[0]["ok"]
    office.until(lambda: office.is_shut_out(visitor))


def test_client_that_leaves_without_waiting_is_obeyed(office: Office) -> None:
    visitor = office.visitor()
    visitor.send(b'{"do": "a"}\n')
    visitor.close()
    office.until(lambda: office.asked == [{"do": "a"}])


def test_client_that_never_ends_its_line_is_let_go(office: Office) -> None:
    visitor = office.visitor()
    assert say_until_shut_out(office, visitor, b"x" * 1000) > 65_536


def test_client_that_does_not_read_is_let_go_and_nobody_waits(office: Office) -> None:
    deaf, hearing = office.visitor(), office.visitor()
    assert say_until_shut_out(office, deaf, b'{"do": "' + b"x" * 30_000 + b'"}\n') > 1 << 20
    hearing.send(b'{"do": "a"}\n')
    assert office.answers(hearing, 1)[0]["ok"]


def say_until_shut_out(office: Office, visitor: socket.socket, data: bytes) -> int:
    """How many bytes the office took before it let the visitor go."""
    visitor.settimeout(patience())
    taken = 0
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # the office has let the visitor go
        while taken < 1 << 24:
            taken += visitor.send(data)
            office.turn()
    return taken


def test_flood_of_requests_is_answered_a_few_a_step(office: Office) -> None:
    visitor = office.visitor()
    visitor.send(b'{"do": "a"}\n' * 1000)
    office.turn()
    office.turn()
    assert 0 < len(office.asked) <= 32
    assert len(office.answers(visitor, 1000)) == 1000


def test_socket_is_for_its_user_alone(office: Office) -> None:
    assert office.control.path.stat().st_mode & 0o777 == 0o600


def test_socket_is_gone_after_closing(tmp_path: Path) -> None:
    Office(tmp_path / "control").close()
    assert list(tmp_path.iterdir()) == []


def test_socket_left_by_a_dead_emulator_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "control"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as dead:
        dead.bind(str(path))
        dead.listen()
    office = Office(path)
    visitor = office.visitor()
    visitor.send(b"{}\n")
    assert office.answers(visitor, 1)[0]["ok"]
    office.close()


def test_path_that_is_taken_is_refused(office: Office, tmp_path: Path) -> None:
    (tmp_path / "note").write_text("mine")
    for path, complaint in [
        (office.control.path, "in use by another emulator"),
        (tmp_path / "note", "something else is there"),
        (tmp_path / "no" / "control", "cannot be made: No such file"),
        (tmp_path / ("x" * 120), "too long"),
    ]:
        with pytest.raises(PortError, match=complaint):
            ControlSocket(path, office.poller, office.answer)
    assert (tmp_path / "note").read_text() == "mine"

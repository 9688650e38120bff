import fcntl
import grp
import os
import pty
import select
import socket
import threading
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial.rfc2217

from gateway.errors import ExitCode, GatewayError, NoSuchPort, PortBusy, PortLost
from gateway.serial_port import Port, open_port
from tests.waiting import join


def receive(port: Port, size: int) -> bytes:
    data = b""
    while len(data) < size:
        assert select.select([port], [], [], 5.0)[0], "nothing came"
        data += port.read()
    return data


class Peer:
    """The other end of a port under test."""

    def __init__(self, name: str, descriptor: int, hang_up: list[int]) -> None:
        self.name = name
        self.descriptor = descriptor
        self._held = hang_up

    def read(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            assert select.select([self.descriptor], [], [], 5.0)[0], "nothing came"
            data += os.read(self.descriptor, size - len(data))
        return data

    def hang_up(self) -> None:
        while self._held:
            os.close(self._held.pop())


@pytest.fixture(params=["pty", "socket"])
def ends(request: pytest.FixtureRequest) -> Iterator[tuple[Port, Peer]]:
    if request.param == "pty":
        master, slave = pty.openpty()
        tty.setraw(slave)
        peer = Peer(os.ttyname(slave), master, [slave, master])
        port = open_port(peer.name)
    else:
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}")
            accepted = server.accept()[0].detach()
        peer = Peer(port.name, accepted, [accepted])
    yield port, peer
    port.close()
    peer.hang_up()


class TestAnyPort:
    def test_bytes_pass_both_ways_unchanged(self, ends: tuple[Port, Peer]) -> None:
        port, peer = ends
        every_byte = bytes(range(256))
        port.write(every_byte)
        assert peer.read(256) == every_byte
        os.write(peer.descriptor, every_byte)
        assert receive(port, 256) == every_byte

    def test_rate_can_be_set_any_time(self, ends: tuple[Port, Peer]) -> None:
        port, peer = ends
        for rate in (9600, 115200, 57600):
            port.set_rate(rate)
            port.write(b"x")
            assert peer.read(1) == b"x"

    def test_reading_after_the_peer_hung_up_raises_port_lost(self, ends: tuple[Port, Peer]) -> None:
        port, peer = ends
        peer.hang_up()
        assert select.select([port], [], [], 5.0)[0]
        with pytest.raises(PortLost, match="is gone"):
            port.read()

    def test_line_that_takes_no_more_bytes_is_lost(self, ends: tuple[Port, Peer]) -> None:
        port, _ = ends

        def flood() -> None:
            for _ in range(10_000):
                port.write(bytes(4096))

        with pytest.raises(PortLost):
            flood()


def test_rate_that_the_last_client_left_is_known_after_opening() -> None:
    master, slave = pty.openpty()
    first = open_port(os.ttyname(slave))
    first.set_rate(57600)
    first.close()
    second = open_port(os.ttyname(slave))
    assert second.rate == 57600
    second.close()
    os.close(master)
    os.close(slave)


@pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning")  # pyserial's own, in its RFC 2217 client
def test_rfc2217_server_is_read_through_a_pump() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        serving = threading.Thread(target=serve_rfc2217, args=(server,))
        serving.start()
        port = open_port(f"rfc2217://127.0.0.1:{server.getsockname()[1]}")
        port.write(b"hello")
        assert receive(port, 5) == b"HELLO"
        port.close()
        join(serving)
        assert not serving.is_alive()


def serve_rfc2217(server: socket.socket) -> None:
    """Answer in capitals what a client of RFC 2217 says."""
    connection, _ = server.accept()
    with connection:
        line = serial.serial_for_url("loop://")
        write = type("Sender", (), {"write": staticmethod(connection.sendall)})()
        manager = serial.rfc2217.PortManager(line, write)  # type: ignore[arg-type]  # any port will do, whatever the stub says
        while data := connection.recv(1024):
            said = b"".join(manager.filter(data))
            if said:
                connection.sendall(b"".join(manager.escape(said.upper())))
        line.close()


def refusal(kind: type[GatewayError], name: str, code: ExitCode) -> str:
    with pytest.raises(kind) as caught:
        open_port(name)
    assert caught.value.exit_code == code
    return str(caught.value)


def test_missing_port_a_directory_and_a_file_are_told_apart(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no port")
    assert "plug the robot in" in refusal(NoSuchPort, str(tmp_path / "ttyUSB9"), ExitCode.NO_PORT)
    assert "is a directory" in refusal(GatewayError, str(tmp_path), ExitCode.NOT_A_PORT)
    assert "is no serial port" in refusal(GatewayError, str(tmp_path / "notes.txt"), ExitCode.NOT_A_PORT)
    dangling = tmp_path / "robot"
    dangling.symlink_to("/dev/pts/no-such-one")
    refusal(NoSuchPort, str(dangling), ExitCode.NO_PORT)


def test_port_in_use_says_so() -> None:
    master, slave = pty.openpty()
    fcntl.flock(slave, fcntl.LOCK_EX)
    assert "in use" in refusal(PortBusy, os.ttyname(slave), ExitCode.PORT_IN_USE)
    os.close(master)
    os.close(slave)


def test_forbidden_port_names_the_group_to_join(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    device = tmp_path / "ttyS0"
    device.touch()

    def forbid(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", forbid)  # the tests may run as root, whom nothing is forbidden
    group = grp.getgrgid(device.stat().st_gid).gr_name
    assert f"usermod -aG {group}" in refusal(GatewayError, str(device), ExitCode.NO_PERMISSION)


@pytest.mark.parametrize(
    "url",
    [
        "socket://127.0.0.1:1",
        "socket://127.0.0.1",
        "socket://:99",
        "socket://127.0.0.1:huge",
        "warp://x",
        "rfc2217://127.0.0.1:1",
    ],
)
def test_address_where_nothing_answers_is_no_such_port(url: str) -> None:
    assert url in refusal(NoSuchPort, url, ExitCode.NO_PORT)


def test_a_terminal_in_which_somebody_works_is_no_port(terminal: tuple[str, int]) -> None:
    """A robot's pseudo-terminal may be gone, and its number be that of a person's window."""
    path, pid = terminal
    with pytest.raises(GatewayError, match=rf"{path} is the terminal in which process {pid} .* runs") as caught:
        open_port(path)
    assert caught.value.exit_code is ExitCode.NOT_A_PORT

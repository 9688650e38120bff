"""One conformance suite that every port passes, then what only a pseudo-terminal or only TCP can do."""

import os
import select
import socket
import termios
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from p2os_emu.links.link import Link, PortError
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.poller import Poller
from p2os_emu.links.pty import PtyLink
from p2os_emu.links.tcp import TcpLink
from tests.waiting import Deadline, patience


class Cable(ABC):
    """A link under test and a client of it. Every operation of the client may be repeated after `leave`."""

    link: Link

    def __init__(self) -> None:
        self.poller = Poller()

    @abstractmethod
    def come(self) -> None:
        """The client opens the port."""

    @abstractmethod
    def leave(self) -> None:
        """The client closes the port."""

    @abstractmethod
    def say(self, data: bytes) -> None:
        """The client sends."""

    @abstractmethod
    def listen(self) -> bytes:
        """What the client can read at this moment."""

    def hear(self) -> bytes:
        """What the robot can read at this moment."""
        self.poller.poll()
        return self.link.read()

    def robot_hears(self, count: int) -> bytes:
        return collect(self.hear, count)

    def client_hears(self, count: int) -> bytes:
        return collect(self.listen, count)

    def until(self, condition: Callable[[], bool]) -> None:
        def polled() -> bool:
            self.poller.poll()
            return condition()

        wait_until(polled)

    def close(self) -> None:
        self.leave()
        self.link.close()
        self.poller.close()


class MemoryCable(Cable):
    def __init__(self) -> None:
        super().__init__()
        self.link: MemoryLink = MemoryLink()

    def come(self) -> None:
        pass

    def leave(self) -> None:
        pass

    def say(self, data: bytes) -> None:
        self.link.client_write(data)

    def listen(self) -> bytes:
        return self.link.client_read()


class PtyCable(Cable):
    def __init__(self, path: Path | None = None) -> None:
        super().__init__()
        self.link: PtyLink = PtyLink(self.poller, path)
        self.descriptor: int | None = None

    def come(self) -> None:
        # As ROS p2os and pyserial do: open, then raw. No flush, so that stale bytes would be seen.
        self.descriptor = os.open(self.link.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def leave(self) -> None:
        if self.descriptor is not None:
            os.close(self.descriptor)
            self.descriptor = None

    def say(self, data: bytes) -> None:
        assert self.descriptor is not None
        assert os.write(self.descriptor, data) == len(data)

    def listen(self) -> bytes:
        assert self.descriptor is not None
        try:
            return os.read(self.descriptor, 65536)
        except BlockingIOError:
            return b""

    def set_speed(self, speed: int) -> None:
        assert self.descriptor is not None
        attributes = termios.tcgetattr(self.descriptor)
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(self.descriptor, termios.TCSANOW, attributes)


class TcpCable(Cable):
    def __init__(self) -> None:
        super().__init__()
        self.link: TcpLink = TcpLink(self.poller, 0)
        self.client: socket.socket | None = None

    def come(self) -> None:
        self.client = self.connect()
        self.until(lambda: self.link.attached)

    def connect(self) -> socket.socket:
        host, port = self.link.port.removeprefix("socket://").split(":")
        client = socket.create_connection((host, int(port)), timeout=patience())
        client.setblocking(False)
        return client

    def leave(self) -> None:
        if self.client is not None:
            self.client.close()
            self.client = None

    def say(self, data: bytes) -> None:
        assert self.client is not None
        assert self.client.send(data) == len(data)

    def listen(self) -> bytes:
        assert self.client is not None
        try:
            return self.client.recv(65536)
        except BlockingIOError:
            return b""


def collect(read: Callable[[], bytes], count: int) -> bytes:
    """Read until at least `count` bytes have come."""
    data = bytearray()

    def enough() -> bool:
        data.extend(read())
        return len(data) >= count

    wait_until(enough)
    return bytes(data)


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = Deadline()
    while not condition():
        assert not deadline.has_passed(), deadline.in_words("the link does what the test waits for")
        # Yields the processor to whoever makes the condition true.
        select.select([], [], [], 0.001)


CABLES: dict[str, type[Cable]] = {"memory": MemoryCable, "pty": PtyCable, "tcp": TcpCable}


@pytest.fixture
def cable(request: pytest.FixtureRequest) -> Iterator[Cable]:
    cable = CABLES[request.param]()
    yield cable
    cable.close()


@pytest.fixture
def pty() -> Iterator[PtyCable]:
    cable = PtyCable()
    yield cable
    cable.close()


@pytest.fixture
def tcp() -> Iterator[TcpCable]:
    cable = TcpCable()
    yield cable
    cable.close()


@pytest.mark.parametrize("cable", CABLES, indirect=True)
class TestAnyPort:
    def test_bytes_of_every_value_arrive_in_order_and_unchanged_both_ways(self, cable: Cable) -> None:
        every_byte = bytes(range(256)) * 4
        cable.come()
        cable.say(every_byte)
        assert cable.robot_hears(len(every_byte)) == every_byte
        cable.link.write(every_byte)
        assert cable.client_hears(len(every_byte)) == every_byte

    def test_reading_without_bytes_returns_at_once(self, cable: Cable) -> None:
        cable.come()
        assert cable.hear() == b""

    def test_nothing_the_robot_sends_comes_back_to_it(self, cable: Cable) -> None:
        cable.come()
        cable.say(b"?")
        cable.robot_hears(1)
        cable.link.write(b"no echo")
        cable.client_hears(7)
        assert cable.hear() == b""

    def test_last_words_of_a_client_that_left_are_heard(self, cable: Cable) -> None:
        cable.come()
        cable.say(b"goodbye")
        cable.leave()
        assert cable.robot_hears(7) == b"goodbye"

    def test_writing_to_nobody_is_harmless(self, cable: Cable) -> None:
        for _ in range(2000):
            cable.link.write(bytes(100))

    def test_next_client_is_served_after_the_last_has_left(self, cable: Cable) -> None:
        for greeting in (b"first", b"second", b"third"):
            cable.come()
            cable.say(greeting)
            assert cable.robot_hears(len(greeting)) == greeting
            cable.link.write(b"hello " + greeting)
            assert cable.client_hears(6 + len(greeting)) == b"hello " + greeting
            cable.leave()

    def test_port_serves_again_after_it_was_unplugged(self, cable: Cable) -> None:
        cable.come()
        cable.link.unplug()
        assert not cable.link.attached
        cable.link.write(b"lost")
        assert cable.hear() == b""
        cable.leave()
        cable.link.plug_in()
        cable.come()
        cable.say(b"back")
        assert cable.robot_hears(4) == b"back"
        cable.link.write(b"again")
        assert cable.client_hears(5) == b"again"

    def test_unplugging_twice_and_closing_twice_are_harmless(self, cable: Cable) -> None:
        cable.link.unplug()
        cable.link.unplug()
        cable.link.plug_in()
        cable.link.plug_in()
        cable.link.close()
        cable.link.close()


@pytest.mark.parametrize("cable", ["pty", "tcp"], indirect=True)
class TestPortsOfTheSystem:
    def test_client_is_known_from_its_first_bytes_until_it_leaves(self, cable: Cable) -> None:
        assert not cable.link.attached
        cable.come()
        cable.say(b"here")
        cable.until(lambda: cable.link.attached)
        cable.leave()
        cable.until(lambda: not cable.link.attached)

    def test_new_client_reads_nothing_of_what_was_sent_before_it_came(self, cable: Cable) -> None:
        cable.come()
        cable.say(b"first")
        cable.robot_hears(5)
        for _ in range(20):
            cable.link.write(b"unread by the first")
        cable.leave()
        cable.until(lambda: not cable.link.attached)
        for _ in range(20):
            cable.link.write(b"sent to nobody")
        cable.come()
        assert cable.listen() == b""
        cable.link.write(b"fresh")
        assert cable.client_hears(5) == b"fresh"

    def test_client_that_does_not_read_loses_whole_pieces_and_nothing_stalls(self, cable: Cable) -> None:
        cable.come()
        cable.say(b"?")
        cable.robot_hears(1)
        pieces = [index.to_bytes(4, "big") * 250 for index in range(20_000)]
        for piece in pieces:
            cable.link.write(piece)
            if cable.link.dropped > 10:
                break
        assert cable.link.dropped > 10
        received = bytearray()

        def drained() -> bool:
            received.extend(cable.listen())
            cable.link.write(b"end.")
            return received.endswith(b"end.")

        cable.until(drained)
        whole = bytes(received).rstrip(b"end.")
        assert whole == b"".join(pieces[: len(whole) // 1000])


class TestPty:
    def test_slave_is_raw_before_any_client_has_set_it(self, pty: PtyCable) -> None:
        pty.come()
        assert pty.descriptor is not None
        _, output, _, local, _, speed, _ = termios.tcgetattr(pty.descriptor)
        assert not local & (termios.ECHO | termios.ICANON | termios.ISIG)
        assert not output & termios.OPOST
        assert speed == termios.B9600

    def test_slave_is_raw_again_after_a_client_left_it_with_echo(self, pty: PtyCable) -> None:
        pty.come()
        assert pty.descriptor is not None
        pty.say(b"?")
        pty.robot_hears(1)
        attributes = termios.tcgetattr(pty.descriptor)
        attributes[3] |= termios.ECHO | termios.ICANON
        termios.tcsetattr(pty.descriptor, termios.TCSANOW, attributes)
        pty.leave()
        pty.until(lambda: not pty.link.attached)
        pty.come()
        assert not termios.tcgetattr(pty.descriptor)[3] & (termios.ECHO | termios.ICANON)

    def test_baud_of_the_client_is_seen_from_the_robots_side(self, pty: PtyCable) -> None:
        assert pty.link.client_baud == 9600
        pty.come()
        pty.set_speed(termios.B57600)
        assert pty.link.client_baud == 57600

    def test_client_that_only_listens_hears_a_robot_that_streams(self, pty: PtyCable) -> None:
        pty.link.write(b"before")
        pty.come()
        pty.link.write(b"after")
        assert pty.client_hears(5) == b"after"
        assert pty.link.attached

    def test_client_reads_end_of_file_when_the_port_vanishes(self, pty: PtyCable) -> None:
        pty.come()
        assert pty.descriptor is not None
        os.set_blocking(pty.descriptor, True)
        pty.link.unplug()
        with pytest.raises(OSError, match="Input/output error"):
            os.write(pty.descriptor, b"anyone?")

    def test_symbolic_link_leads_to_the_port_and_goes_with_it(self, tmp_path: Path) -> None:
        path = tmp_path / "robot"
        cable = PtyCable(path)
        assert cable.link.port == str(path)
        cable.come()
        cable.say(b"?")
        assert cable.robot_hears(1) == b"?"
        cable.link.unplug()
        assert list(tmp_path.iterdir()) == []
        cable.link.plug_in()
        assert path.is_symlink()
        cable.close()
        assert list(tmp_path.iterdir()) == []

    def test_leftover_link_to_a_terminal_is_replaced(self, tmp_path: Path) -> None:
        path = tmp_path / "robot"
        path.symlink_to("/dev/pts/987654")
        cable = PtyCable(path)
        assert path.readlink() != Path("/dev/pts/987654")
        cable.close()

    def test_path_that_another_emulator_has_is_refused_until_that_one_ends(self, tmp_path: Path) -> None:
        path = tmp_path / "robot"
        first = PtyCable(path)
        target = path.readlink()
        for same in path, tmp_path / "." / "robot", tmp_path / ".." / tmp_path.name / "robot":
            with pytest.raises(PortError, match=r"robot is in use by another emulator; choose another path"):
                PtyCable(same)
        assert path.readlink() == target
        first.link.unplug()
        with pytest.raises(PortError, match="in use"):
            PtyCable(path)
        first.close()
        PtyCable(path).close()
        assert not path.is_symlink()

    def test_link_that_somebody_has_pointed_elsewhere_is_left_alone(self, tmp_path: Path) -> None:
        path = tmp_path / "robot"
        first = PtyCable(path)
        path.unlink()
        path.symlink_to("/dev/pts/987654")
        first.close()
        assert path.is_symlink()

    def test_anything_else_at_the_path_is_refused_and_kept(self, tmp_path: Path) -> None:
        poller = Poller()
        note = tmp_path / "note"
        note.write_text("mine")
        elsewhere = tmp_path / "elsewhere"
        elsewhere.symlink_to(note)
        for path, complaint in [
            (tmp_path, "is a directory"),
            (note, "is not a link"),
            (elsewhere, "is not a terminal"),
            (tmp_path / "missing" / "robot", "there is no directory"),
        ]:
            with pytest.raises(PortError, match=complaint):
                PtyLink(poller, path)
        assert note.read_text() == "mine"
        assert elsewhere.is_symlink()
        poller.close()

    def test_what_took_the_path_while_the_port_was_away_is_kept(self, tmp_path: Path) -> None:
        path = tmp_path / "robot"
        cable = PtyCable(path)
        cable.link.unplug()
        path.write_text("mine")
        with pytest.raises(PortError, match="is not a link"):
            cable.link.plug_in()
        cable.close()
        assert path.read_text() == "mine"


class TestTcp:
    def test_second_client_is_closed_at_once_and_the_first_served_on(self, tcp: TcpCable) -> None:
        tcp.come()
        second = tcp.connect()
        second.setblocking(True)
        tcp.until(lambda: bool(select.select([second], [], [], 0)[0]))
        assert second.recv(100) == b""
        second.close()
        tcp.say(b"still here")
        assert tcp.robot_hears(10) == b"still here"

    def test_client_that_knocks_while_the_dead_one_is_still_unnoticed_is_let_in(self, tcp: TcpCable) -> None:
        tcp.come()
        tcp.leave()
        tcp.come()
        tcp.say(b"me")
        assert tcp.robot_hears(2) == b"me"

    def test_frames_do_not_wait_for_each_other(self, tcp: TcpCable) -> None:
        tcp.come()
        connection = tcp.link._connection
        assert connection is not None
        assert connection._socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)

    def test_port_in_use_is_refused_by_number(self, tcp: TcpCable) -> None:
        number = int(tcp.link.port.rsplit(":", 1)[1])
        with pytest.raises(PortError, match=rf"TCP port {number} cannot be opened: Address already in use"):
            TcpLink(tcp.poller, number)

    def test_port_beyond_the_numbers_is_refused(self, tcp: TcpCable) -> None:
        with pytest.raises(PortError, match="70000"):
            TcpLink(tcp.poller, 70_000)

    def test_port_is_free_after_closing(self) -> None:
        first = TcpCable()
        number = int(first.link.port.rsplit(":", 1)[1])
        first.close()
        poller = Poller()
        TcpLink(poller, number).close()
        poller.close()

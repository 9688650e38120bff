"""A TCP port on which every client finds a robot of its own, as MobileSim's users know it from `-R`."""

import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from p2os import Command, Frame, FrameDecoder, encode_command
from p2os_emu.emulator import Emulator
from p2os_emu.factory import Factory
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.poller import Poller
from p2os_emu.options import MOBILESIM_PORT, parse
from p2os_emu.ports import Ports
from p2os_emu.team import EmulatedTeam
from tests.p2os_emu.flat_world import FlatWorld


class Hall:
    """A factory, and what moves it."""

    def __init__(self) -> None:
        self.poller = Poller()
        self.emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
        team = EmulatedTeam(self.emulator, Ports(self.poller), "ideal", {}, "")
        self.factory = Factory(self.poller, team, "p3dx", 0)
        self.number = int(self.factory.port.rpartition(":")[2])

    def step(self) -> None:
        self.poller.poll()
        self.factory.tend()
        self.emulator.step()


@pytest.fixture
def hall() -> Iterator[Hall]:
    hall = Hall()
    yield hall
    hall.factory.close()
    hall.emulator.close()
    hall.poller.close()


def answer(hall: Hall, client: socket.socket, until: Callable[[Callable[[], bool]], None]) -> bytes:
    """What the robot at the other end says to SYNC0."""
    client.sendall(encode_command(Command.SYNC0))
    client.setblocking(False)
    decoder = FrameDecoder()
    frames: list[bytes] = []

    def has_answered() -> bool:
        hall.step()
        try:
            data = client.recv(100)
        except BlockingIOError:  # nothing has come yet
            return False
        frames.extend(found.payload for found in decoder.receive(data, 0.0) if isinstance(found, Frame))
        return bool(frames)

    until(has_answered)
    return frames[0]


def test_every_client_finds_a_robot_of_its_own_that_goes_with_it(
    hall: Hall, until: Callable[[Callable[[], bool]], None]
) -> None:
    with socket.create_connection(("127.0.0.1", hall.number)) as one:
        assert answer(hall, one, until) == bytes([Command.SYNC0])
        with socket.create_connection(("127.0.0.1", hall.number)) as other:
            assert answer(hall, other, until) == bytes([Command.SYNC0])
            assert list(hall.emulator.robots) == ["p3dx", "p3dx-2"]

        def is_gone() -> bool:
            hall.step()
            return list(hall.emulator.robots) == ["p3dx"]

        until(is_gone)


def test_short_options_are_those_of_mobilesim() -> None:
    options = parse(["-m", "lab.map", "-r", "p3dx:happy", "-r", "amigo"])
    assert (options.world, options.robots, options.tcp) == ("lab.map", ("p3dx:happy", "amigo"), MOBILESIM_PORT)
    assert parse(["-R", "p3dx", "-p", "9000"]).tcp == 9000
    assert parse(["-r", "p3dx", "--pty", "here"]).pty == Path("here")
    with pytest.raises(SystemExit):
        parse(["-R", "p3dx", "--pty", "here"])

"""A robot, a driver and the cable between them, under one virtual clock."""

import os
import pty
import random
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TypeVar

import pytest

from bus import Bus, ZenohBus
from configs import load
from gateway.driver import Driver
from gateway.events import Event, SipReceived
from gateway.settings import Settings
from p2os import Command, Frame, FrameDecoder, Identity, ReceivedCommand, RobotModel, decode_command
from p2os_emu.microcontroller import Microcontroller
from tests.gateway.virtual_time import VirtualTime
from tests.p2os_emu.microcontroller.bench import STEP, PlainBody

T = TypeVar("T")


def robot_body() -> PlainBody:
    """A body half of whose sonar discs hear an echo."""
    body = PlainBody()
    body.ranges = lambda disc: inf if disc % 2 else 1.0 + disc / 10
    return body


def find_model(identity: Identity) -> RobotModel:
    return load(RobotModel, "robots", identity.subtype)


@dataclass
class Bench(VirtualTime):
    """Driver and firmware on one cable. `now` is the driver's steady time; the robot steps with it.

    sent: every sound frame from the driver, (time, command). events: what the driver reported, likewise with time.
    cut: the cable is pulled. deaf: only the robot's ear of it. loses: whether the line loses a frame to the robot.
    is_frozen: the driver is not called.
    """

    robot: Microcontroller
    driver: Driver
    body: PlainBody = field(default_factory=robot_body)
    now: float = 100.0
    robot_baud: int | None = None
    cut: bool = False
    deaf: bool = False
    loses: Callable[[ReceivedCommand], bool] = lambda command: False
    is_frozen: bool = False
    sent: list[tuple[float, ReceivedCommand]] = field(default_factory=list)
    raw: bytearray = field(default_factory=bytearray)
    events: list[tuple[float, Event]] = field(default_factory=list)
    moments_in_motion: list[float] = field(default_factory=list)
    _ear: FrameDecoder = field(default_factory=FrameDecoder)
    _unread: bytearray = field(default_factory=bytearray)

    def start(self) -> None:
        self.driver.port_opened(self.now)

    def step(self) -> None:
        self.now += STEP
        self.body.step(STEP)
        out = self.robot.step(STEP, self.body)
        if self.body.is_turning():
            self.moments_in_motion.append(self.now)
        if not self.cut:
            self._unread += out if self._same_rate else bytes(each ^ 0x5A for each in out)
        if not self.is_frozen:
            data = bytes(self._unread)
            self._unread.clear()
            self.events += [(self.now, event) for event in self.driver.receive(data, self.now)]
            self.flush()

    def flush(self) -> None:
        """Write what the driver has to say now, in steps of its own pace."""
        while data := self.driver.bytes_due(self.now):
            self.raw += data
            is_lost = self.cut or self.deaf
            for found in self._ear.receive(data, self.now):
                assert isinstance(found, Frame)
                command = decode_command(found.payload)
                self.sent.append((self.now, command))
                is_lost = is_lost or self.loses(command)
            if not is_lost:
                self.robot.receive(data if self._same_rate else bytes(each ^ 0x5A for each in data))

    @property
    def _same_rate(self) -> bool:
        return self.robot_baud is None or self.driver.baud == self.robot_baud

    def commands(self, since: float = 0.0) -> list[Command | None]:
        return [command.command for at, command in self.sent if at > since]

    def of(self, kind: type[T], since: float = 0.0) -> list[T]:
        return [event for at, event in self.events if isinstance(event, kind) and at > since]

    @property
    def sips(self) -> list[SipReceived]:
        return self.of(SipReceived)

    def connect(self) -> float:
        """Start, and run until the motors are on and everything is configured; return the seconds to the first pose."""
        self.start()
        seconds = self.run_until(lambda: self.driver.is_connected)
        self.run_until(lambda: self.robot.board.motors.enabled)
        self.run(0.2)
        return seconds


MakeBench = Callable[..., Bench]


def new_bench(
    model: str = "powerbot-sh",
    rates: Sequence[int] = (9600, 38400, 19200, 115200, 57600),
    settings: Settings | None = None,
    robot_baud: int | None = None,
) -> Bench:
    """Return a robot of a model with a driver that has not begun."""
    robot = Microcontroller(load(RobotModel, "robots", model), "happy")
    driver = Driver(find_model, rates, settings, random.Random(7))
    return Bench(robot, driver, robot_baud=robot_baud)


@pytest.fixture
def make_bench() -> MakeBench:
    return new_bench


@pytest.fixture
def bench(make_bench: MakeBench) -> Bench:
    return make_bench()


@pytest.fixture
def bus() -> Iterator[Bus]:
    """A session of the test's own on this machine's bus."""
    with ZenohBus.open() as session:
        yield session


@pytest.fixture
def name(robot: str) -> str:
    """The robot's name, for tests in which `robot` is the command line that makes one."""
    return robot


@pytest.fixture
def terminal() -> Iterator[tuple[str, int]]:
    """The path of a terminal in which a program runs, as a person's shell does, and the program's number."""
    master, slave = pty.openpty()
    path = os.ttyname(slave)
    # The first terminal that the leader of a session opens becomes its own.
    runs = "import os, sys, time; os.open(sys.argv[1], os.O_RDWR); print(1, flush=True); time.sleep(60)"
    with subprocess.Popen(
        [sys.executable, "-c", runs, path], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield path, process.pid
        process.kill()
    os.close(master)
    os.close(slave)

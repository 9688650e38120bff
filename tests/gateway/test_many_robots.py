"""One gateway process serves several robots, and trouble with one of them is none of the others'."""

import json
import os
import pty
import signal
import subprocess
import sys
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import gateway.__main__ as command
from acromovi.children import EmulatedRobots, emulator, end
from bus import ZenohBus, keys
from gateway.bridge import Bridge
from gateway.driver import Driver
from gateway.errors import LineBlocked
from gateway.robot_service import RobotPlan
from gateway.serial_port import Port
from tests.gateway.conftest import find_model
from tests.gateway.test_end_to_end import Watcher, stands
from tests.waiting import wait_until

ROOT = Path(__file__).resolve().parents[2]
TRIES = 3

BROKEN_PORTS = """
import os, sys, threading
import gateway.robot_service as service
from gateway.__main__ import main
from gateway.serial_port import Port, open_port


class Broken(Port):
    rate = None

    def __init__(self, name):
        self.name = name
        self.reader, self.writer = os.pipe()
        os.write(self.writer, b"something to read")

    def fileno(self):
        return self.reader

    def set_rate(self, rate):
        pass

    def close(self):
        pass

    def write(self, data):
        if self.name == "hangs":
            threading.Event().wait()

    def read(self):
        raise RuntimeError("an error of the program")


service.open_port = lambda name: Broken(name) if name in ("hangs", "raises") else open_port(name)
sys.exit(main())
"""


class Process:
    """A gateway process. said: the JSON lines that it has printed."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.process = process
        self.said: list[dict[str, Any]] = []
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.said.append(json.loads(line))

    def of(self, port: str) -> list[dict[str, Any]]:
        return [said for said in self.said if said["port"] == port]

    def events(self, port: str) -> list[str]:
        return [said["event"] for said in self.of(port)]


@contextmanager
def served(*arguments: str, program: tuple[str, ...] = ("-m", "gateway")) -> Iterator[Process]:
    """A gateway process with these arguments."""
    words = [sys.executable, *program, *arguments, "--json"]
    pipe = subprocess.PIPE
    with subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True, cwd=ROOT) as process:
        running = Process(process)
        try:
            yield running
        finally:
            end(process)
            running.reader.join()


@pytest.fixture
def bus() -> Iterator[ZenohBus]:
    with ZenohBus.open() as bus:
        yield bus


@pytest.fixture
def names(robot: str) -> tuple[str, str]:
    return f"{robot[:16]}-a", f"{robot[:16]}-b"


@pytest.fixture
def robots(names: tuple[str, str]) -> Iterator[EmulatedRobots]:
    first, second = names
    with emulator("--robot", f"p3dx-sh:{first}", "--robot", f"p2dx:{second}", "--world", "empty", "--quiet") as robots:
        yield robots


def ports(robots: EmulatedRobots) -> list[str]:
    return [str(robot["port"]) for robot in robots.robots]


def describe(bus: ZenohBus, name: str) -> dict[str, Any]:
    return bus.query(keys.DESCRIPTION.key(name))[0].value


def test_robots_of_one_process_are_on_the_bus_and_obey_each_its_own_commands(
    robots: EmulatedRobots, names: tuple[str, str], bus: ZenohBus
) -> None:
    first, second = ports(robots)
    with served(first, second, "--name", f"{names[1]}-other") as process:
        one, other = Watcher(bus, names[0]), Watcher(bus, f"{names[1]}-other")
        one.hear()
        other.hear()
        described = [describe(bus, names[0]), describe(bus, f"{names[1]}-other")]
        assert [each["model"] for each in described] == ["p3dx-sh", "p2dx"]
        assert {each["process"] for each in described} == {process.process.pid}
        assert process.events(first)[0] == process.events(second)[0] == "connected"
        one.drive_until_fast(0.3)
        assert stands(robots, names[1], 0.2)
        process.process.terminate()
        assert process.process.wait(20.0) == 0
    assert stands(robots, names[0], 0.5)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_every_robot_of_a_dead_or_frozen_process_stops(
    robots: EmulatedRobots, names: tuple[str, str], bus: ZenohBus, number: signal.Signals
) -> None:
    with served(*ports(robots)) as process:
        watchers = [Watcher(bus, name) for name in names]
        for watcher in watchers:
            watcher.hear()
        for watcher in watchers:
            watcher.drive_until_fast(0.3)
        for watcher in watchers:
            watcher.drive(0.3)
        process.process.send_signal(number)
        for name in names:
            wait_until(partial(stands, robots, name, 0.3), "its watchdog has stopped it")
        process.process.send_signal(signal.SIGCONT)
        if number == signal.SIGSTOP:
            for name in names:
                assert stands(robots, name, 0.7)


def test_a_robot_that_is_not_there_ends_alone(robots: EmulatedRobots, names: tuple[str, str], bus: ZenohBus) -> None:
    first, _ = ports(robots)
    with served(first, "/dev/none") as process:
        Watcher(bus, names[0]).hear()
        assert process.events("/dev/none") == ["ended"]
        (failure,) = process.of("/dev/none")
        assert failure["exit_code"] == 3
        assert "there is no port /dev/none" in failure["reason"]
        Watcher(bus, names[0]).hear()
        assert process.process.poll() is None


def test_all_that_fail_end_the_process_with_the_code_of_the_first() -> None:
    with served("/dev/none", str(ROOT)) as process:
        assert process.process.wait(20.0) in (3, 4)


@contextmanager
def flooded() -> Iterator[str]:
    """A pty that gives noise as fast as it is read, and never reads what it gets."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    is_over = threading.Event()

    def flood() -> None:
        noise = os.urandom(4096)
        os.set_blocking(master, False)
        while not is_over.is_set():
            try:
                os.write(master, noise)
            except BlockingIOError:
                is_over.wait(0.001)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        is_over.set()
        thread.join()
        os.close(master)
        os.close(slave)


def test_noise_and_a_peer_that_does_not_read_keep_no_other_robot(
    robots: EmulatedRobots, names: tuple[str, str], bus: ZenohBus
) -> None:
    first, _ = ports(robots)

    def said_beside_noise() -> list[dict[str, Any]]:
        with flooded() as noise, served(first, noise, "--wait") as process:
            watcher = Watcher(bus, names[0])
            watcher.hear()
            wait_until(lambda: "no robot" in process.events(noise), "the cause was reported")
            watcher.drive_until_fast(0.3)
            bus.query(keys.STOP.key(names[0]))
            wait_until(lambda: watcher.odom.twist.twist.linear.x == 0.0)
            return process.of(first)

    assert_connected_once(said_beside_noise)


def test_a_port_that_hangs_and_an_error_of_the_program_keep_no_other_robot(
    robots: EmulatedRobots, names: tuple[str, str], bus: ZenohBus
) -> None:
    first, _ = ports(robots)

    def said_beside_trouble() -> list[dict[str, Any]]:
        with served("hangs", "raises", first, "--wait", program=("-c", BROKEN_PORTS)) as process:
            watcher = Watcher(bus, names[0])
            watcher.hear()
            watcher.drive_until_fast(0.3)
            bus.query(keys.STOP.key(names[0]))
            wait_until(lambda: watcher.odom.twist.twist.linear.x == 0.0)
            watcher.hear(20)
            process.process.terminate()
            assert process.process.wait(20.0) == 0
            assert process.process.stderr is not None
            said = process.process.stderr.read()
            assert said.count("raises: an unexpected error; the robot is served again") >= 2
            return process.of(first)

    assert_connected_once(said_beside_trouble)


def assert_connected_once(said_of_robot: Callable[[], list[dict[str, Any]]]) -> None:
    """See that a robot is not lost. A busy machine may freeze the gateway, too, but not each time."""
    for _ in range(TRIES):
        said = said_of_robot()
        if [each["event"] for each in said] == ["connected"]:
            return
    pytest.fail(f"the robot was lost {TRIES} times: {said}")


class HangingPort(Port):
    """Its `write` returns when it may."""

    name = "hanging"
    rate = None

    def __init__(self) -> None:
        self._reader, self._writer = os.pipe()
        self.may_write = threading.Event()
        self.may_write.set()
        self.is_writing = threading.Event()

    def fileno(self) -> int:
        return self._reader

    def set_rate(self, rate: int) -> None:
        """There is none."""

    def write(self, data: bytes) -> None:
        self.is_writing.set()
        self.may_write.wait()

    def close(self) -> None:
        os.close(self._reader)
        os.close(self._writer)


def test_commands_for_a_robot_whose_port_hangs_are_refused_until_it_writes_again() -> None:
    port = HangingPort()
    bridge = Bridge(Driver(find_model, (0,)), port, lambda: port)
    port.may_write.clear()
    port.is_writing.clear()
    hanging = threading.Thread(target=lambda: bridge.command(lambda driver, now: port.write(b"")))
    hanging.start()
    port.is_writing.wait()
    called: list[float] = []
    for _ in range(2):
        with pytest.raises(LineBlocked, match="hangs"):
            bridge.command(lambda driver, now: called.append(now))
    assert called == []
    port.may_write.set()
    hanging.join()
    bridge.command(lambda driver, now: called.append(now))
    assert len(called) == 1
    bridge.close()


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[RobotPlan]]:
    """What a command line is understood as."""

    def parse(*arguments: str) -> list[RobotPlan]:
        given: list[RobotPlan] = []
        monkeypatch.setattr(command, "serve_robots", lambda plans, fail: given.extend(plans))
        assert command.main(arguments) in (0, 3)
        return given

    return parse


def test_options_belong_to_the_port_before_them(planned: Callable[..., list[RobotPlan]], tmp_path: Path) -> None:
    config = tmp_path / "b.toml"
    config.write_text('model = "p2dx"')
    words = ("A", "--name", "a", "--laser=L", "B", "--config", str(config), "--bus", "lan", "--radio", "C", "--wait")
    a, b, c = planned(*words)
    assert [plan.options.port for plan in (a, b, c)] == ["A", "B", "C"]
    assert [plan.options.name for plan in (a, b, c)] == ["a", None, None]
    assert [[address for _, address in plan.cables] for plan in (a, b, c)] == [["L"], [], []]
    assert [plan.settings.model for plan in (a, b, c)] == [None, "p2dx", None]
    assert [plan.settings.radio for plan in (a, b, c)] == [False, True, False]
    assert {(plan.options.bus, plan.options.waits, plan.options.is_one_of_many) for plan in (a, b, c)} == {
        ("lan", True, True)
    }


def test_options_of_a_single_robot_may_stand_before_its_port(planned: Callable[..., list[RobotPlan]]) -> None:
    (plan,) = planned("--name", "a", "--quiet", "A")
    assert (plan.options.port, plan.options.name, plan.options.is_quiet) == ("A", "a", True)
    assert not plan.options.is_one_of_many


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--name", "a", "A", "B"), "--name is before the first port"),
        (("A", "B", "A"), "the port A is given for two robots"),
        (("A", "--name", "x", "B", "--name", "x"), "the name x is given for two robots"),
    ],
)
def test_a_command_line_that_is_not_clear_is_refused(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    with pytest.raises(SystemExit):
        command.main(words)
    assert why in capsys.readouterr().err

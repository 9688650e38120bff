"""The programs themselves: an emulated robot on a real port, a gateway process, Zenoh between it and the test."""

import re
import select
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import ExitStack
from math import hypot
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main as acromovi
from acromovi.children import EmulatedRobots, emulator, gateway
from bus import Bus, Sample, keys, messages
from gateway.errors import PortBusy
from gateway.serial_port import open_port
from p2os import Command, encode_command
from tests.waiting import exit_code, patience, wait_until

LIMIT = 15.0


@pytest.fixture(scope="module")
def name() -> str:
    return f"robot-{uuid.uuid4().hex[:12]}"


@pytest.fixture(scope="module")
def plain(name: str) -> Iterator[EmulatedRobots]:
    """A robot on a pseudo-terminal, of all tests that leave it standing and its port free."""
    with emulator("--robot", f"p3dx-sh:{name}", "--world", "empty") as robots:
        yield robots


class Watcher:
    """Hears one robot's odometry, and may drive it."""

    def __init__(self, bus: Bus, name: str) -> None:
        self.count = 0
        self.odom: Any = None
        self._bus = bus
        self._name = name
        bus.subscribe(keys.ODOM.key(name), self._on_odometry)

    def _on_odometry(self, sample: Sample) -> None:
        self.odom = messages.decode(keys.ODOM.type_name, sample.payload)
        self.count += 1

    def hear(self, more: int = 3) -> None:
        """Wait for further poses."""
        enough = self.count + more
        wait_until(lambda: self.count >= enough)

    def drive(self, linear: float) -> None:
        self._bus.put(keys.CMD_VEL.key(self._name), messages.twist(linear, 0.0))

    def drive_until_fast(self, linear: float) -> None:
        def is_fast() -> bool:
            self.drive(linear)
            time.sleep(0.05)
            return self.odom is not None and self.odom.twist.twist.linear.x > 0.9 * linear

        wait_until(is_fast)


def rolled(robots: EmulatedRobots, name: str) -> tuple[float, float]:
    truth = robots.ask("truth", robot=name)
    return truth["x"], truth["y"]


def stands(robots: EmulatedRobots, name: str, seconds: float) -> bool:
    """The robot does not move for a while, as the world sees it."""
    start = rolled(robots, name)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.1)
        now = rolled(robots, name)
        if hypot(now[0] - start[0], now[1] - start[1]) > 0.003:
            return False
    return True


def test_twist_drives_the_robot_and_silence_stops_it(name: str, bus: Bus, plain: EmulatedRobots) -> None:
    drive_and_fall_silent(name, bus, plain)


def test_twist_drives_a_robot_on_tcp_and_silence_stops_it(name: str, bus: Bus) -> None:
    with emulator("--robot", f"p3dx-sh:{name}", "--world", "empty", "--tcp", "0") as robots:
        drive_and_fall_silent(name, bus, robots)


def drive_and_fall_silent(name: str, bus: Bus, robots: EmulatedRobots) -> None:
    with gateway(robots.port, "--quiet") as process:
        watcher = Watcher(bus, name)
        watcher.hear()
        watcher.drive_until_fast(0.3)
        wait_until(lambda: watcher.odom.twist.twist.linear.x == 0.0)
        assert stands(robots, name, 0.5)
        watcher.drive_until_fast(0.3)
        process.terminate()
        assert exit_code(process, LIMIT) == 0
        assert stands(robots, name, 0.5)


def test_robot_behind_radio_modems_is_dialled_driven_and_stopped(name: str, bus: Bus) -> None:
    robot = ("--robot", f"p3dx-sh:{name}", "--world", "empty", "--link", "radio-modem")
    with emulator(*robot) as robots, gateway(robots.port, "--radio", "--quiet"):
        watcher = Watcher(bus, name)
        watcher.hear(20)
        watcher.drive_until_fast(0.3)
        wait_until(lambda: watcher.odom.twist.twist.linear.x == 0.0)
        assert stands(robots, name, 0.5)


def test_gateway_killed_while_driving_and_started_again_never_turns_the_wheels(
    name: str, bus: Bus, plain: EmulatedRobots
) -> None:
    watcher = Watcher(bus, name)
    with gateway(plain.port, "--quiet") as first:
        watcher.hear()
        watcher.drive_until_fast(0.5)
        first.kill()
        first.wait()
    wait_until(lambda: stands(plain, name, 0.3))  # the watchdog
    with gateway(plain.port, "--quiet"):
        watcher.hear()
        assert stands(plain, name, 1.0)
        watcher.drive_until_fast(0.2)


def test_gateway_frozen_while_driving_never_turns_the_wheels_by_itself(
    name: str, bus: Bus, plain: EmulatedRobots
) -> None:
    with gateway(plain.port, "--quiet") as process:
        watcher = Watcher(bus, name)
        watcher.hear()
        watcher.drive_until_fast(0.5)
        process.send_signal(signal.SIGSTOP)
        for _ in range(20):  # commands pile up on the bus while nobody hears
            watcher.drive(0.5)
        wait_until(lambda: stands(plain, name, 0.3))
        process.send_signal(signal.SIGCONT)
        watcher.hear()
        assert stands(plain, name, 1.0)
        watcher.drive_until_fast(0.2)


def test_port_that_vanishes_and_returns_is_taken_up_again(name: str, bus: Bus, tmp_path: Path) -> None:
    cable = tmp_path / "cable"
    robot = ("--robot", f"p3dx-sh:{name}", "--world", "empty", "--pty", str(cable))
    watcher = Watcher(bus, name)
    with ExitStack() as stack:
        first = stack.enter_context(emulator(*robot))
        process = stack.enter_context(gateway(str(cable), "--quiet"))
        watcher.hear()
        cable.unlink()  # the name goes with the adapter; left behind, it would lead to whoever gets the number next
        first.process.kill()
        first.process.wait()
        count = watcher.count
        stack.enter_context(emulator(*robot))
        wait_until(lambda: watcher.count > count + 3)
        assert process.poll() is None


def test_port_that_leads_to_another_robot_for_a_while_is_let_go_and_taken_up_again(
    name: str, bus: Bus, tmp_path: Path
) -> None:
    """Adapters change their numbers: what is behind a name is not the same robot for ever."""
    cable, robot = tmp_path / "cable", ("--robot", f"p3dx-sh:{name}", "--world", "empty")
    watcher = Watcher(bus, name)
    with ExitStack() as stack:
        first, other = stack.enter_context(emulator(*robot)), stack.enter_context(emulator("--robot", "p3dx-sh:other"))
        cable.symlink_to(first.port)
        process = stack.enter_context(gateway(str(cable), "--quiet"))
        watcher.hear()
        cable.unlink()
        cable.symlink_to(other.port)
        first.process.kill()
        first.process.wait()
        wait_until(lambda: stranger_hears(other.port) == b"")  # the gateway looks at it,
        wait_until(lambda: b"other" in stranger_hears(other.port))  # and does not hold it
        count = watcher.count
        cable.unlink()
        cable.symlink_to(stack.enter_context(emulator(*robot)).port)
        wait_until(lambda: watcher.count > count + 3)
        assert process.poll() is None


def stranger_hears(port: str) -> bytes:
    """What a robot says to a client that knows nothing of gateways; empty while another program holds it."""
    try:
        line = open_port(port)
    except PortBusy:
        return b""
    try:
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2):
            line.write(encode_command(command))
            time.sleep(0.05)
        # A terminal that has nothing to read yet looks like one that was closed.
        return line.read() if select.select([line], [], [], patience(1.0))[0] else b"nothing"
    finally:
        line.close()


def test_doctor_finds_everything_in_order_and_leaves_the_robot_as_it_was(name: str) -> None:
    with emulator("--robot", f"powerbot:{name}", "--world", "empty") as robots:
        place = rolled(robots, name)
        assert acromovi(["doctor", robots.port, "--json"]) == 0
        assert rolled(robots, name) == pytest.approx(place, abs=1e-6)


def test_a_gateway_whose_output_nobody_reads_any_more_serves_its_robot_also_after_it_was_lost(
    name: str, bus: Bus
) -> None:
    with emulator("--robot", "p3dx-sh", "--world", "empty") as robots, ExitStack() as ending:
        command = [sys.executable, "-m", "gateway", robots.port, "--name", f"{name}-c"]
        process = ending.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        ending.callback(process.kill)
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.close()
        watcher = Watcher(bus, f"{name}-c")
        watcher.hear()
        robots.ask("fault", fault="line-cut@0+3")
        wait_until(lambda: not is_connected(bus, f"{name}-c"), "the robot is lost")
        wait_until(lambda: is_connected(bus, f"{name}-c"), "it is found again")
        watcher.hear()


def is_connected(bus: Bus, robot: str) -> bool:
    """Whether the gateway of a robot, which must answer, is connected to it."""
    return bool(bus.query(keys.DESCRIPTION.key(robot))[0].value["connected"])


def test_line_on_the_terminal_says_who_is_connected_and_where(name: str, plain: EmulatedRobots) -> None:
    command = [sys.executable, "-m", "gateway", plain.port, "--name", f"{name}-b"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        # On a busy machine the robot may answer too late for the first rate; a pseudo-terminal works with any.
        assert re.fullmatch(rf"connected to {name} \(p3dx-sh\) at \d+ bit/s; keys under {name}-b/\n", line)
        process.terminate()
        assert exit_code(process, LIMIT) == 0

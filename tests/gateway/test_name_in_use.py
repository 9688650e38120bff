"""Two gateways with one name on one bus: the second one refuses, and says who has the name."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from acromovi.children import EmulatedRobots, emulator
from bus import ZenohBus
from tests.waiting import wait_until

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def robots(robot: str) -> Iterator[EmulatedRobots]:
    """Two robots, whose gateways are to be called by one name."""
    with emulator("--robot", f"p3dx:{robot}", "--robot", "p2dx:second", "--world", "empty", "--quiet") as robots:
        yield robots


@contextmanager
def started(robots: EmulatedRobots, index: int, name: str, *options: str) -> Iterator["subprocess.Popen[str]"]:
    """A gateway of one of the robots under a name."""
    command = [sys.executable, "-m", "gateway", robots.robots[index]["port"], "--name", name, "--json", *options]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=ROOT) as process:
        try:
            yield process
        finally:
            process.kill()


def model(bus: ZenohBus, name: str) -> str | None:
    """Of the robot that answers to a name; None for nobody."""
    try:
        (answer,) = bus.query(f"{name}/description")
    except TimeoutError:  # nobody has it
        return None
    return str(answer.value["model"])


def is_model(bus: ZenohBus, name: str, wanted: str) -> bool:
    return model(bus, name) == wanted


@pytest.fixture
def bus() -> Iterator[ZenohBus]:
    with ZenohBus.open() as bus:
        yield bus


def test_a_second_gateway_of_a_name_refuses_and_names_the_first(
    robots: EmulatedRobots, bus: ZenohBus, robot: str
) -> None:
    with started(robots, 0, robot) as first:
        wait_until(partial(is_model, bus, robot, "p3dx"), "the first is on the bus")
        with started(robots, 1, robot) as second:
            assert second.wait(60.0) == 11
            assert second.stderr is not None
            why = second.stderr.read()
        assert f"{robot} is on this bus already, in process {first.pid} on this machine; end that one, or" in why
        assert first.poll() is None
        assert model(bus, robot) == "p3dx"


def test_with_force_it_waits_until_the_first_has_ended(robots: EmulatedRobots, bus: ZenohBus, robot: str) -> None:
    with started(robots, 0, robot) as first:
        wait_until(partial(is_model, bus, robot, "p3dx"), "the first is on the bus")
        with started(robots, 1, robot, "--force") as second:
            assert second.stderr is not None
            assert "waiting until it has ended" in second.stderr.readline()
            assert model(bus, robot) == "p3dx"
            first.send_signal(signal.SIGTERM)
            wait_until(partial(is_model, bus, robot, "p2dx"), "the second has taken over")


def test_a_gateway_that_follows_a_killed_one_is_not_refused(robots: EmulatedRobots, bus: ZenohBus, robot: str) -> None:
    with started(robots, 0, robot) as first:
        wait_until(partial(is_model, bus, robot, "p3dx"), "the first is on the bus")
        first.kill()
        with started(robots, 0, robot):
            wait_until(partial(is_model, bus, robot, "p3dx"), "its successor is on the bus")


def test_of_two_that_start_together_one_stays(robots: EmulatedRobots, robot: str) -> None:
    with started(robots, 0, robot) as one, started(robots, 1, robot) as other:
        both = (one, other)
        wait_until(lambda: any(process.poll() is not None for process in both), "one of them has ended")
        assert sorted(process.poll() or 0 for process in both) == [0, 11]
        stays = next(process for process in both if process.poll() is None)
        assert stays.stdout is not None
        said: dict[str, Any] = json.loads(stays.stdout.readline())
        assert said["event"] == "connected"

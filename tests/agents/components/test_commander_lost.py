"""A robot as programs, in the middle of a long motion: whoever has asked for it, or carries it out, dies or freezes."""

import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from math import dist
from pathlib import Path
from typing import Any

import pytest

from acromovi.children import EmulatedRobots, emulator, end, gateway
from bus import Bus, ZenohBus
from bus.messages import decode_json
from tests.interruptions import TRIES
from tests.waiting import wait_until

DISTANCE = 25.0  # m; more than half a minute
FAR = 6.0  # m: a robot that was not stopped has rolled farther before the test gives up

PROGRAM = """
import sys
from agents import Team

with Team() as team:
    team.robot(sys.argv[1]).base.move(25.0)
"""
PLAIN = """
import sys, time
from bus import ZenohBus
from bus.heartbeat import Heartbeat

with ZenohBus.open() as bus, Heartbeat(bus, f"plain-{sys.argv[1]}/heartbeat") as heartbeat:
    bus.query(f"{sys.argv[1]}/command/move", {"distance": 25.0, "heartbeat": heartbeat.key})
    time.sleep(60.0)
"""


@contextmanager
def program(*words: str, says: bool = False) -> "Iterator[subprocess.Popen[str]]":
    """Run a program until the block ends; wait for its first line if it says one."""
    command = [sys.executable, *words]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert not says or process.stdout.readline()
            yield process
        finally:
            if process.poll() is None:
                os.kill(process.pid, signal.SIGCONT)
            end(process)


class Site:
    """A robot and its gateway, which all tests of this file share, and the container of its agents.

    robot: its name.
    """

    def __init__(self, robots: EmulatedRobots, robot: str, stack: ExitStack) -> None:
        self.robot = robot
        self._robots = robots
        self._stack = stack
        self._container: subprocess.Popen[str] | None = None

    def truth(self) -> dict[str, Any]:
        """The true state of the robot."""
        return dict(self._robots.ask("truth")["robots"][self.robot])

    def place(self) -> tuple[float, float]:
        """Where the robot really is, m."""
        truth = self.truth()
        return truth["x"], truth["y"]

    def container(self) -> "subprocess.Popen[str]":
        """The process of its agents; another one, if the last was lost."""
        if self._container is None:
            command = ("-m", "acromovi", "container", "--robot", self.robot, "--json")
            self._container = self._stack.enter_context(program(*command, says=True))
        return self._container

    def end_container(self) -> None:
        """End a container that was killed or frozen."""
        if self._container is not None:
            if self._container.poll() is None:
                self._container.send_signal(signal.SIGCONT)
            end(self._container)
            self._container = None


@pytest.fixture(scope="module")
def site() -> Iterator[Site]:
    robot = f"robot-{uuid.uuid4().hex[:12]}"
    with ExitStack() as stack:
        robots = stack.enter_context(emulator("--robot", f"p3dx-sh:{robot}", "--world", "empty"))
        stack.enter_context(gateway(robots.port, "--quiet"))
        yield Site(robots, robot, stack)


@pytest.fixture
def bus() -> Iterator[Bus]:
    with ZenohBus.open() as opened:
        yield opened


def commander(robot: str, who: str, folder: Path) -> list[str]:
    """The command line of a program that asks for the motion."""
    match who:
        case "ask":
            return ["-m", "acromovi", "ask", f"base@{robot}", "move", f"distance={DISTANCE}", "--timeout", "60"]
        case "Team":
            file = folder / "tour.py"
            file.write_text(PROGRAM)
            return [str(file), robot]
    return ["-c", PLAIN, robot]


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
@pytest.mark.parametrize(
    ("who", "victim"),
    [("ask", "container"), ("ask", "commander"), ("Team", "commander"), ("plain program", "commander")],
)
def test_a_robot_stops_when_the_commander_of_its_motion_is_lost(
    site: Site, bus: Bus, tmp_path: Path, who: str, victim: str, how: signal.Signals
) -> None:
    robot = site.robot
    ends: list[dict[str, Any]] = []
    bus.subscribe(f"{robot}/command/result/*", lambda sample: ends.append(decode_json(sample.payload)))
    with ExitStack() as stack:
        agents = site.container()
        if victim == "container":
            stack.callback(site.end_container)
        tokens: list[str] = []
        bus.watch_alive(f"{robot}/agents/base/alive", lambda key, is_alive: tokens.append(key))
        wait_until(lambda: tokens, "the agent of the wheels is there")

        def drives_or_has_ended(process: "subprocess.Popen[str]") -> bool:
            return site.truth()["linear"] > 0.2 or bool(ends) or process.poll() is not None

        for _ in range(TRIES):  # a busy machine may interrupt the motion, too
            asking = stack.enter_context(program(*commander(robot, who, tmp_path)))
            wait_until(partial(drives_or_has_ended, asking), "the robot drives")
            if not ends and asking.poll() is None:
                break
            ends.clear()
        (agents if victim == "container" else asking).send_signal(how)
        begin = site.place()
        wait_until(lambda: abs(site.truth()["linear"]) < 0.005, "the robot stands")
        assert dist(site.place(), begin) < FAR
        wait_until(lambda: ends, "the end of the motion is published")
        assert ends[0]["result"] != "reached"

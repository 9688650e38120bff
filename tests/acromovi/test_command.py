"""The command itself, run as people run it."""

import asyncio
import gc
import io
import json
import os
import pty
import select
import signal
import socket
import subprocess
import sys
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from acromovi import topics
from acromovi.__main__ import COMMANDS, main
from acromovi.robot_view import joined
from bus import ZenohBus
from bus.messages import RobotState, decode, header, twist
from configs import find
from tests.waiting import exit_code

ROOT = Path(__file__).resolve().parents[2]
Until = Callable[..., None]


@contextmanager
def acromovi(*arguments: str, **streams: Any) -> Iterator["subprocess.Popen[str]"]:
    """The command in a process of its own, gone at the end of the test."""
    process = subprocess.Popen([sys.executable, "-m", "acromovi", *arguments], cwd=ROOT, text=True, **streams)
    with process:
        try:
            yield process
        finally:
            process.kill()


def test_help_names_every_command_and_is_quick_because_it_loads_nothing() -> None:
    program = (
        "import sys; from acromovi.__main__ import main\ntry: main(['--help'])\nexcept SystemExit: print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert all(command in done.stdout for command in COMMANDS)
    loaded = done.stdout.splitlines()[-1].split()
    assert not {"zenoh", "numpy", "rosbags", "bus"} & set(loaded)


def test_ctrl_c_between_a_coroutine_and_its_loop_prints_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(arguments: object) -> int:
        work = asyncio.sleep(1.0)  # which a program was about to hand over
        raise KeyboardInterrupt(work)

    monkeypatch.setattr("acromovi.topics.COMMAND", replace(topics.COMMAND, run=interrupted))
    assert main(["topics"]) == 128 + signal.SIGINT
    gc.collect()  # a warning that is told now fails this test
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example_and_its_exit_codes(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([command, "--help"])
    shown = capsys.readouterr().out
    assert f"acromovi {command}" in shown.partition("example")[2]
    assert "Exit codes: " in shown


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["ecko"],
        ["echo"],
        ["echo", "a/b", "--count", "0"],
        ["topics", "--seconds", "-1"],
        ["echo", "a", "--timeout", "x"],
    ],
)
def test_wrong_usage_is_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert "usage: acromovi" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["echo", "a//b"], "'a//b' is not a key"),
        (["echo", "a/b", "--bus", "locl"], "local"),
        (["topics", "--bus", "/nowhere.toml"], "/nowhere.toml"),
        (["router", "--listen", "here"], "Endpoints must be of the form"),
        (["teleop", "happy"], "needs a terminal"),
    ],
)
def test_a_users_mistake_is_one_sentence_and_exit_code_1(
    arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"acromovi {arguments[0]}: ")
    assert reason in error
    assert error.count("\n") == 1


def test_a_router_that_is_not_there_is_said_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        address = f"127.0.0.1:{probe.getsockname()[1]}"
    profile = tmp_path / "router.toml"
    profile.write_text(find("bus", "router").read_text().replace("127.0.0.1:7447", address))
    assert main(["ps", "--bus", str(profile)]) == 1
    error = capsys.readouterr().err
    assert address in error
    assert error.endswith("; is there a router? acromovi router starts one\n")


def test_echo_prints_what_another_process_puts(robot: str, until: Until) -> None:
    with (
        ZenohBus.open() as bus,
        acromovi("echo", f"{robot}/*", "--json", "--count", "1", stdout=subprocess.PIPE) as process,
    ):

        def has_ended() -> bool:
            bus.put(f"{robot}/cmd_vel", twist(0.25, 0.0))
            return process.poll() is not None

        until(has_ended)
        assert process.returncode == 0
        assert process.stdout is not None
        shown = json.loads(process.stdout.read())
    assert (shown["key"], shown["message"]["linear"]["x"]) == (f"{robot}/cmd_vel", 0.25)


def test_echo_into_a_pipe_that_closes_ends_quietly(robot: str, until: Until) -> None:
    with (
        ZenohBus.open() as bus,
        acromovi("echo", f"{robot}/x", "--json", stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process,
    ):
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()

        def has_ended() -> bool:
            bus.put(f"{robot}/x", {})
            return process.poll() is not None

        until(has_ended)
        assert (process.returncode, process.stderr.read()) == (0, "")


@pytest.mark.parametrize(
    ("number", "code", "words", "said"),
    [
        (signal.SIGINT, 130, [], "routing on {}; stop with Ctrl-C\n"),
        (signal.SIGTERM, 143, ["--json"], '{{"listen": ["{}"]}}\n'),
    ],
)
def test_a_router_routes_until_it_is_stopped_and_says_nothing_more(
    number: signal.Signals, code: int, words: list[str], said: str
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        address = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    with acromovi("router", "--listen", address, *words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == said.format(address)
        process.send_signal(number)
        assert exit_code(process) == code
        assert process.stderr.read() == ""


class Screen:
    """The far end of a command's terminal."""

    def __init__(self, master: int) -> None:
        self.master = master
        self.text = ""

    def shows(self, text: str) -> bool:
        """Whether the command has printed a text by now."""
        while select.select([self.master], [], [], 0)[0]:
            self.text += os.read(self.master, 4096).decode()
        return text in self.text

    def lines(self) -> list[str]:
        """The lines that a live screen has now, by the last frame that is complete."""
        self.shows("")
        frames = self.text.rpartition("\x1b[J")[0].split("\x1b[H")
        return [line.removesuffix("\x1b[K") for line in frames[-1].split("\r\n")]

    def type(self, keys: bytes) -> None:
        os.write(self.master, keys)


@pytest.fixture
def terminal() -> Iterator[tuple[Screen, int]]:
    master, slave = pty.openpty()
    termios.tcsetwinsize(slave, (24, 200))
    yield Screen(master), slave
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(("leave", "code"), [("q", 0), (signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_teleop_drives_and_puts_the_terminal_back(
    terminal: tuple[Screen, int], robot: str, until: Until, leave: str | signal.Signals, code: int
) -> None:
    screen, slave = terminal
    before = termios.tcgetattr(slave)
    driven: list[float] = []
    with ZenohBus.open() as bus:
        bus.declare_alive(f"{robot}/alive")
        bus.subscribe(
            f"{robot}/cmd_vel",
            lambda sample: driven.append(decode("geometry_msgs/msg/Twist", sample.payload).linear.x),
        )
        bus.serve(f"{robot}/command/enable", lambda arguments: {"accepted": True})
        with acromovi("teleop", robot, "--speed", "0.5", stdin=slave, stdout=slave, stderr=slave) as process:
            until(lambda: screen.shows(robot), "the live line is there")
            screen.type(b"e")
            until(lambda: screen.shows("motors switched on"))
            screen.type(b"\x1b[A")
            until(lambda: driven.count(0.5) >= 2 and driven[-1] == 0.0, "it drove, and stopped when the key ceased")
            screen.type(b"w")
            until(lambda: driven[-1] == 0.5)
            if isinstance(leave, str):
                screen.type(leave.encode())
            else:
                process.send_signal(leave)
            until(lambda: screen.shows("") and process.poll() is not None)
            assert process.returncode == code
            until(lambda: driven[-1] == 0.0, "leaving stopped the robot")
    assert termios.tcgetattr(slave) == before
    assert "Traceback" not in screen.text


def test_teleop_says_in_80_and_40_columns_why_a_key_has_no_effect(
    terminal: tuple[Screen, int], robot: str, until: Until
) -> None:
    screen, slave = terminal
    termios.tcsetwinsize(slave, (24, 80))
    with ZenohBus.open() as bus:
        bus.declare_alive(f"{robot}/alive")
        state = bus.publisher(f"{robot}/state", "acromovi_msgs/msg/RobotState")

        def latch(arguments: dict[str, Any]) -> dict[str, Any]:
            faults = ["the e-stop is latched"] if arguments["on"] else []
            state.put(RobotState(header(0, ""), "connected", motors=False, estop=arguments["on"], faults=faults))
            return {"accepted": True}

        bus.serve(f"{robot}/command/estop", latch)
        with acromovi("teleop", robot, stdin=slave, stdout=slave, stderr=slave) as process:
            until(lambda: screen.lines()[0].startswith(robot))
            screen.type(b"x")
            until(
                lambda: (
                    screen.lines()[:2]
                    == [
                        f"{robot} | E-STOP | connected | motors off",
                        "e-stop latched; press c to release it, then e for the motors",
                    ]
                )
            )
            screen.type(b"\x1b[A")
            until(
                lambda: (
                    screen.lines()[1:3]
                    == [
                        "no effect: the e-stop is latched; press c to release it, then e to switch the",
                        "motors on",
                    ]
                )
            )
            termios.tcsetwinsize(slave, (24, 40))
            state_in_40 = joined([robot, "E-STOP", "connected", "motors off"], 40)
            until(lambda: screen.lines()[: len(state_in_40)] == state_in_40)
            assert max(map(len, screen.lines())) <= 40
            screen.type(b"c")
            until(lambda: "E-STOP" not in screen.lines()[0])
            screen.type(b"q")
            until(lambda: screen.shows("") and process.poll() is not None)
            assert process.returncode == 0


def test_teleop_of_an_unknown_robot_names_the_nearest(terminal: tuple[Screen, int], robot: str, until: Until) -> None:
    screen, slave = terminal
    with ZenohBus.open() as bus:
        bus.declare_alive(f"{robot}/alive")
        with acromovi("teleop", robot + "x", stdin=slave, stdout=slave, stderr=slave) as process:
            until(lambda: screen.shows("") and process.poll() is not None)
    assert process.returncode == 1
    assert screen.shows(f"no robot '{robot}x' is seen; did you mean '{robot}'?")


def test_command_to_a_robot_that_is_not_there_says_which_are(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    with ZenohBus.open() as bus:
        bus.declare_alive(f"{robot}/alive")
        assert main(["command", f"{robot}x", "stop", "--timeout", "1"]) == 1
    assert f"no robot '{robot}x' is seen; did you mean '{robot}'?" in capsys.readouterr().err


def test_command_to_two_robots_of_one_name_tells_both_and_says_so(
    robot: str, capsys: pytest.CaptureFixture[str], until: Callable[[Callable[[], bool]], None]
) -> None:
    """A command is not kept waiting for whom it has not met yet, least of all a stop: so it is given until both are."""

    def tells_both() -> bool:
        capsys.readouterr()
        return main(["command", robot, "stop"]) == 1

    with ZenohBus.open() as one, ZenohBus.open() as other:
        for bus in one, other:
            bus.serve(f"{robot}/command/stop", lambda arguments: {"accepted": True})
        until(tells_both)
    heard = capsys.readouterr()
    assert heard.out == '{"accepted": true}\n' * 2
    assert f"2 robots are called {robot} and all were told" in heard.err

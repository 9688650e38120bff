"""The program itself, started as a person starts it, with a client written by hand on its port."""

import json
import os
import random
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from p2os_emu.__main__ import main
from tests.waiting import Deadline, end_of, exit_code, patience, run, wait_until

SYNCS = [bytes.fromhex(frame) for frame in ("FA FB 03 00 00 00", "FA FB 03 01 00 01", "FA FB 03 02 00 02")]
OPEN = bytes.fromhex("FA FB 03 01 00 01")
PULSE = SYNCS[0]
ENABLE = bytes.fromhex("FA FB 06 04 3B 01 00 05 3B")
VEL_200 = bytes.fromhex("FA FB 06 0B 3B C8 00 D3 3B")
CLOSE = bytes.fromhex("FA FB 03 02 00 02")


class Client:
    """A client of P2OS bytes on a pty or a TCP port."""

    def __init__(self, port: str) -> None:
        self.heard = bytearray()
        self._socket: socket.socket | None = None
        if port.startswith("socket://"):
            host, number = port.removeprefix("socket://").split(":")
            self._socket = socket.create_connection((host, int(number)), timeout=patience())
            self._descriptor = self._socket.fileno()
        else:
            self._descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)

    def say(self, data: bytes) -> None:
        os.write(self._descriptor, data)

    def frame(self) -> bytes:
        """The payload of the next frame."""
        deadline = Deadline()
        while True:
            begin = self.heard.find(b"\xfa\xfb")
            if begin >= 0 and len(self.heard) >= begin + 3 and len(self.heard) >= begin + 3 + self.heard[begin + 2]:
                size = 3 + self.heard[begin + 2]
                payload = bytes(self.heard[begin + 3 : begin + size - 2])
                del self.heard[: begin + size]
                return payload
            assert not deadline.has_passed(), deadline.in_words("a frame comes")
            if select.select([self._descriptor], [], [], 0.1)[0]:
                self.heard += os.read(self._descriptor, 4096)

    def sip(self) -> bytes:
        """The payload of the next standard SIP."""
        while (payload := self.frame())[0] not in (0x32, 0x33):
            continue
        return payload

    def handshake(self) -> list[str]:
        """SYNC0 to SYNC2; the robot's name, type and subtype."""
        for sync in SYNCS:
            self.say(sync)
            while (payload := self.frame())[0] != sync[3]:
                continue
        return payload[1:].decode().split("\0")[:3]

    def drive(self) -> None:
        for command in (OPEN, ENABLE, VEL_200):
            self.say(command)
        self.wait_for_speed(lambda left, right: left > 100 and right > 100, pulse=True)

    def wait_for_speed(self, condition: Callable[[int, int], bool], *, pulse: bool = False) -> None:
        deadline = Deadline()
        while True:
            assert not deadline.has_passed(), deadline.in_words("the wheels do what the test waits for")
            sip = self.sip()
            left, right = (int.from_bytes(sip[at : at + 2], "little", signed=True) for at in (7, 9))
            if condition(left, right):
                return
            if pulse:
                self.say(PULSE)

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        else:
            os.close(self._descriptor)


class Program:
    """A running `p2os-emu --json`."""

    def __init__(self, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "p2os_emu", "--world", "empty", "--json", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, self.process.communicate()[1]
        self.ready: dict[str, Any] = json.loads(line)
        self.ports: list[str] = [robot["port"] for robot in self.ready["robots"]]
        self._control: socket.socket | None = None

    def ask(self, **request: Any) -> dict[str, Any]:
        if self._control is None:
            self._control = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._control.settimeout(patience())
            self._control.connect(self.ready["control"])
        self._control.sendall(json.dumps(request).encode() + b"\n")
        heard = b""
        while not heard.endswith(b"\n"):
            heard += self._control.recv(65536)
        answer: dict[str, Any] = json.loads(heard)
        return answer

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str, str]:
        """Ask for the end; exit code and what was still said."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        out, err = end_of(self.process)
        if self._control is not None:
            self._control.close()
        return self.process.returncode, out, err


@contextmanager
def program(*arguments: str) -> Iterator[Program]:
    running = Program(*arguments)
    try:
        yield running
    finally:
        running.end()


@contextmanager
def client_of(port: str) -> Iterator[Client]:
    client = Client(port)
    try:
        yield client
    finally:
        client.close()


@pytest.mark.parametrize("port", [[], ["--tcp", "0"]], ids=["pty", "tcp"])
class TestOnBothPorts:
    def test_client_connects_drives_falls_silent_and_the_watchdog_stops_the_robot(self, port: list[str]) -> None:
        with program("--robot", "p3dx:happy", *port) as emulator, client_of(emulator.ports[0]) as client:
            assert client.handshake() == ["happy", "Pioneer", "p3dx"]
            client.drive()
            truth = emulator.ask(do="truth", robot="happy")
            assert truth["robots"]["happy"]["linear"] > 0.05
            client.wait_for_speed(lambda left, right: left == right == 0)

    def test_next_client_connects_after_the_first_was_killed_while_driving(self, port: list[str]) -> None:
        with program("--robot", "p3dx", *port) as emulator:
            with client_of(emulator.ports[0]) as first:
                first.handshake()
                first.drive()
            with client_of(emulator.ports[0]) as second:
                second.say(CLOSE)
                assert second.handshake()[2] == "p3dx"
                second.drive()

    def test_random_bytes_do_no_harm(self, port: list[str]) -> None:
        rng = random.Random(2)
        with program("--robot", "p3dx", *port) as emulator:
            with client_of(emulator.ports[0]) as client:
                for _ in range(50):
                    client.say(rng.randbytes(rng.randrange(1, 300)))
                    client.say(b"\xfa\xfb" + rng.randbytes(20))
            with client_of(emulator.ports[0]) as client:
                # A frame begun by the noise ends 100 ms after its last byte, at the latest at the end of a SIP cycle.
                assert emulator.ask(do="pause")["ok"]
                assert emulator.ask(do="step", n=60)["ok"]
                assert emulator.ask(do="pause", on=False)["ok"]
                client.say(CLOSE)
                assert client.handshake()[2] == "p3dx"
            assert emulator.process.poll() is None


def test_ready_line_is_the_only_line_and_has_every_key() -> None:
    running = Program("--robot", "powerbot", "--robot", "powerbot", "--tcp", "0")
    assert [robot["name"] for robot in running.ready["robots"]] == ["powerbot", "powerbot-2"]
    for robot in running.ready["robots"]:
        assert list(robot) == ["name", "model", "port", "link", "laser_port", "arm_port", "camera_url"]
        assert (robot["model"], robot["link"]) == ("powerbot", "ideal")
        assert (robot["laser_port"], robot["arm_port"], robot["camera_url"]) == (None, None, None)
    assert running.end() == (0, "", "")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_signal_ends_it_and_leaves_nothing_behind(tmp_path: Path, number: int) -> None:
    running = Program("--robot", "p3dx", "--pty", str(tmp_path / "robot"))
    assert running.ports == [str(tmp_path / "robot")]
    control = Path(running.ready["control"])
    assert control.is_socket()
    assert running.end(number) == (0, "", "")
    assert list(tmp_path.iterdir()) == []
    assert not control.parent.exists()


def test_quit_over_the_control_socket_is_answered_and_ends_it(tmp_path: Path) -> None:
    running = Program("--robot", "p3dx", "--control", str(tmp_path / "control"))
    assert running.ask(do="quit")["ok"]
    exit_code(running.process)
    assert running.end() == (0, "", "")
    assert list(tmp_path.iterdir()) == []


def test_port_vanishes_and_returns_behind_the_same_path(tmp_path: Path) -> None:
    path = tmp_path / "robot"
    with program("--robot", "p3dx", "--pty", str(path)) as emulator:
        with client_of(str(path)) as client:
            client.handshake()
            client.say(OPEN)
            client.sip()
            assert emulator.ask(do="pause")["ok"]
            assert emulator.ask(do="fault", fault="hang-up@0+1")["ok"]
            assert emulator.ask(do="step", n=2)["ok"]
            assert not path.is_symlink()
        assert emulator.ask(do="step", n=120)["ok"]
        assert emulator.ask(do="pause", on=False)["ok"]
        with client_of(str(path)) as client:
            client.say(CLOSE)
            assert client.handshake()[2] == "p3dx"


def test_fault_of_the_command_line_comes_at_its_time() -> None:
    with program("--robot", "p3dx", "--fault", "stop-pressed@1000") as emulator:
        faults = emulator.ask(do="faults")["faults"]
        assert [(fault["fault"], fault["active"]) for fault in faults] == [("stop-pressed@1000.0", False)]


def test_robot_whose_client_left_is_stopped_if_asked_to() -> None:
    with program("--robot", "p3dx", "--hangup-stops") as emulator:
        with client_of(emulator.ports[0]) as client:
            client.handshake()
            client.drive()
        wait_until(
            lambda: not emulator.ask(do="truth")["robots"]["p3dx"]["connected"],
            "its client is missed",
        )


def test_machine_that_stood_still_for_long_drops_what_is_beyond_a_second() -> None:
    with program("--robot", "p3dx") as emulator:
        assert emulator.ask(do="truth")["ok"], "the loop runs"
        emulator.process.send_signal(signal.SIGSTOP)
        # Not a wait for luck: that much time must pass for the steps of it to be late.
        time.sleep(1.5)
        emulator.process.send_signal(signal.SIGCONT)
        wait_until(lambda: emulator.ask(do="truth")["late_dropped"], "steps are dropped")
        assert "more than a second late" in emulator.end()[2]


def test_the_list_of_robots_has_their_full_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list-robots"]) == 0
    rows = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert rows["p3dx"].startswith("Pioneer 3-DX  ")
    assert rows["p3dx-sh"].startswith("Pioneer 3-DX, SH2  ")
    assert rows["powerbot"].startswith("PowerBot  ")


def test_listing_into_a_closed_pipe_ends_quietly() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    listing = run([sys.executable, "-m", "p2os_emu", "--list-robots"], stdout=writer)
    os.close(writer)
    assert (listing.returncode, listing.stderr) == (0, "")


def test_window_without_a_display_is_one_sentence_and_an_exit_code(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    assert main(["--world", "empty", "--robot", "p3dx", "--gui"]) == 5
    assert "there is no display" in capsys.readouterr().err


def test_duration_ends_it_in_emulated_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--robot", "p3dx", "--world", "empty", "--duration", "3", "--speed", "1000"]) == 0
    said = capsys.readouterr()
    assert "p3dx, a p3dx, is on /dev/pts/" in said.out
    assert "p2os-gateway /dev/pts/" in said.out
    assert "no longer agree" in said.err


@pytest.mark.parametrize("kind", ["robots", "worlds", "links", "faults"])
def test_lists_name_everything(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    expected = {"robots": "powerbot", "worlds": "empty", "links": "rs232", "faults": "line-cut"}[kind]
    assert main([f"--list-{kind}"]) == 0
    assert expected in [line.split(" ")[0] for line in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (["--robot", "powerbott"], 3, "did you mean powerbot"),
        (["--robot", "p3dx", "--world", "offis"], 3, "there is no 'offis' among the worlds"),
        (["--robot", "p3dx", "--link", "rs-232"], 3, "there is no 'rs-232' among the links; did you mean rs232"),
        (["--robot", "p3dx:a", "--robot", "p3dx:a"], 3, "there is a robot 'a' already"),
        (["--robot", "p3dx", "--fault", "line-cutt"], 3, "did you mean line-cut"),
        (["--robot", "p3dx", "--fault", "line-cut:robot=x"], 3, "there is no robot 'x'"),
        (["--robot", "p3dx", "--pty", "/"], 4, "--pty / is a directory"),
        (["--robot", "p3dx", "--control", "/"], 4, "something else is there"),
    ],
)
def test_mistake_is_one_sentence_and_an_exit_code(
    arguments: list[str], code: int, complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--world", "empty", "--duration", "0.1", *arguments]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert complaint in said.err
    assert said.err.startswith("p2os-emu: ")
    assert said.err.count("\n") == 1


def test_tcp_port_in_use_is_one_sentence_and_an_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert main(["--world", "empty", "--robot", "p3dx", "--tcp", str(port)]) == 4
    assert f"TCP port {port} cannot be opened: Address already in use" in capsys.readouterr().err


def test_error_in_a_world_file_names_file_line_and_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    world = tmp_path / "mine.toml"
    world.write_text("about = 'mine'\nwalls = = 3\n")
    assert main(["--robot", "p3dx", "--world", str(world)]) == 3
    said = capsys.readouterr().err
    assert str(world) in said
    assert "line 2" in said


def test_value_of_a_model_that_no_robot_has_is_one_sentence_and_an_exit_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "mine.p"
    model.write_text("Subclass a-pioneer-of-our-workshop\n")
    assert main(["--robot", f"{model}:happy", "--world", "empty", "--duration", "0.1"]) == 3
    said = capsys.readouterr().err
    assert said.startswith(f"p2os-emu: {model}: name must have 1 to 19 characters")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([], "which robot"),
        (["--robot", "p3dx", "--pty", "/tmp/x", "--tcp", "8101"], "--pty or --tcp, not both"),
        (["--robot", "p3dx", "--tcp", "99999"], "not a TCP port"),
        (["--robot", "p3dx", "--speed", "0"], "above zero"),
        (["--robot", "p3dx", "--duration", "nan"], "above zero"),
        (["--robot", "p3dx", "--fault", "line-cut@soon"], "is not START"),
        (["--robot", "p3dx", "--fits", "laser"], "unrecognized arguments: --fit"),
    ],
)
def test_command_line_that_is_wrong_ends_with_code_2(
    arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert complaint in capsys.readouterr().err

"""`acromovi wire`: recordings and live lines, in words."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.wire import Tap
from gateway.serial_port import open_port
from p2os import Command, encode_command, encode_frame
from p2os.wire_log import FrameSource, WireLog, WireLogEntry
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.poller import Poller
from p2os_emu.links.pty import PtyLink
from p2os_emu.recording import read
from tests.p2os.test_wire_log import ANSWER, P3DX, SIP

Until = Callable[..., None]
TAPE = [
    {"t": 0.5, "from": "host", "hex": encode_command(Command.SYNC0).hex()},
    {"t": 0.6, "from": "robot", "hex": ANSWER.hex()},
    {"t": 0.7, "from": "robot", "hex": SIP.hex()[:20]},
]


@pytest.fixture
def tape(tmp_path: Path) -> Path:
    path = tmp_path / "drive.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in TAPE))
    return path


def test_recording_is_shown_frame_by_frame(tape: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["wire", str(tape)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "    0.5000 -> SYNC0",
        "    0.6000 <- SYNC2 name=PowerBot1 robot_type=Pioneer subtype=powerbot-sh",
        "    0.9000 <- damaged (partial, 10 bytes): fa fb 21 32 64 00 00 00 00 00",
    ]


def test_recording_is_shown_as_json(tape: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["wire", str(tape), "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == {"t": 0.5, "from": "host", "name": "SYNC0", "hex": "00"}
    assert lines[1]["fields"]["subtype"] == "powerbot-sh"
    assert lines[2]["problem"] == "partial"


@pytest.mark.parametrize(("model", "x"), [("p3dx-sh", 0.1), ("p2dx", 0.084)])
def test_model_that_is_given_gives_the_scales(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], model: str, x: float
) -> None:
    path = tmp_path / "tape"
    path.write_text("".join(json.dumps(TAPE[1] | {"hex": data.hex()}) + "\n" for data in (ANSWER, SIP)))
    assert main(["wire", str(path), "--json", "--model", model]) == 0
    sip = json.loads(capsys.readouterr().out.splitlines()[1])
    assert sip["fields"]["x"] == pytest.approx(x, abs=1e-4)


def test_what_cannot_be_read_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nonsense = tmp_path / "nonsense"
    nonsense.write_text("nonsense\n")
    assert main(["wire", str(nonsense)]) == 1
    assert "line 1 is no line of a recording" in capsys.readouterr().err
    assert main(["wire", str(tmp_path / "none")]) == 1
    assert "there is no port" in capsys.readouterr().err
    assert main(["wire", str(nonsense), "--model", "p9dx"]) == 1


class Board:
    """A robot's port of its own, opened, and a tap on it that nobody drives but the test."""

    def __init__(self, rate: int | None) -> None:
        self.poller = Poller()
        self.robot = PtyLink(self.poller)
        self.port = open_port(self.robot.port)
        self.client = MemoryLink(client_rate=rate)
        self.heard = b""
        self.shown: list[WireLogEntry] = []
        self.kept: list[tuple[float, str, bytes]] = []
        self.tap = Tap(
            self.port, self.client, WireLog(P3DX), self.shown.extend, lambda *moment: self.kept.append(moment)
        )

    def close(self) -> None:
        self.port.close()
        self.robot.close()
        self.poller.close()


@pytest.fixture
def board() -> Iterator[Board]:
    with closing(Board(38400)) as board:
        yield board


def test_bytes_go_both_ways_untouched_and_are_noted(board: Board, until: Until) -> None:
    board.client.client_write(encode_command(Command.PULSE) + b"noise")
    board.tap.pass_time(1.0)

    def arrived() -> bool:
        board.poller.poll()
        board.heard += board.robot.read()
        return board.heard == encode_command(Command.PULSE) + b"noise"

    until(arrived)
    board.robot.write(SIP)

    def answered() -> bool:
        board.tap.from_robot(2.0)
        return any(entry.source is FrameSource.ROBOT for entry in board.shown)

    until(answered)
    assert board.client.client_read() == SIP
    assert [entry.name for entry in board.shown] == ["SYNC0", "SIP_STOPPED"]
    board.tap.pass_time(3.0)
    assert board.shown[-1].problem == "noise"
    assert b"".join(data for _, source, data in board.kept if source == "robot") == SIP


def test_rate_of_the_client_is_set_on_the_robots_port(board: Board) -> None:
    board.tap.pass_time(1.0)
    assert board.robot.client_baud == 38400
    board.client.client_rate = 115200
    board.tap.pass_time(1.1)
    assert board.robot.client_baud == 115200


def test_live_line_is_shown_and_kept_while_a_client_talks(tmp_path: Path, until: Until) -> None:
    with closing(Poller()) as poller, closing(PtyLink(poller)) as robot:
        command = [sys.executable, "-m", "acromovi", "wire", robot.port, "--listen", str(tmp_path / "tapped")]
        with subprocess.Popen(
            [*command, "--record", str(tmp_path / "tape"), "--json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            try:
                until((tmp_path / "tapped").exists)
                client = os.open(tmp_path / "tapped", os.O_RDWR | os.O_NOCTTY)
                os.write(client, encode_command(Command.SYNC0))
                heard = b""

                def asked() -> bool:
                    nonlocal heard
                    poller.poll()
                    heard += robot.read()
                    return heard == encode_command(Command.SYNC0)

                until(asked)
                robot.write(encode_frame(b"\0"))
                assert os.read(client, 6) == encode_frame(b"\0")
                assert process.stdout is not None
                lines = [json.loads(process.stdout.readline()) for _ in range(2)]
                os.close(client)
            finally:
                process.send_signal(signal.SIGINT)
            assert process.wait() == 130
    assert [(line["from"], line["name"]) for line in lines] == [("host", "SYNC0"), ("robot", "SYNC0")]
    assert [moment.data for moment in read(tmp_path / "tape").moments] == [encode_command(Command.SYNC0)] * 2
    assert not (tmp_path / "tapped").is_symlink()

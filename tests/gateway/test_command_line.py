"""`p2os-gateway` where it cannot work: one sentence that says what to do, and an exit code of its own."""

import fcntl
import os
import pty
import select
import signal
import subprocess
import sys
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from acromovi import doctor
from gateway.__main__ import main
from p2os import Frame, FrameDecoder, Identity, RobotHandshake, encode_frame
from tests.waiting import end_of


@contextmanager
def peer(answer: Callable[[bytes], bytes]) -> Iterator[str]:
    """A pty whose far end answers what it reads; yields its name."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    is_over = threading.Event()

    def serve() -> None:
        while not is_over.is_set():
            if select.select([master], [], [], 0.02)[0]:
                os.write(master, answer(os.read(master, 1024)))

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        is_over.set()
        thread.join()
        os.close(master)
        os.close(slave)


def stranger(data: bytes) -> bytes:
    return b"login: "


def robot_called(subtype: str) -> Callable[[bytes], bytes]:
    handshake = RobotHandshake(Identity("happy", "Pioneer", subtype))
    ear = FrameDecoder()

    def answer(data: bytes) -> bytes:
        answers = [handshake.receive(event.payload) for event in ear.receive(data, 0.0) if isinstance(event, Frame)]
        return b"".join(encode_frame(payload) for payload in answers if payload is not None)

    return answer


@pytest.fixture
def complain(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str]]:
    def run(*arguments: str) -> tuple[int, str]:
        code = main(arguments)
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        return code, said

    return run


Complain = Callable[..., tuple[int, str]]


def test_port_that_is_not_there(complain: Complain, tmp_path: Path) -> None:
    code, said = complain(str(tmp_path / "ttyUSB0"))
    assert code == 3
    assert "there is no port" in said


def test_port_that_is_a_directory(complain: Complain, tmp_path: Path) -> None:
    code, said = complain(str(tmp_path))
    assert code == 4
    assert "is a directory" in said


def test_port_that_another_program_holds(complain: Complain) -> None:
    master, slave = pty.openpty()
    fcntl.flock(slave, fcntl.LOCK_EX)
    code, said = complain(os.ttyname(slave))
    os.close(master)
    os.close(slave)
    assert code == 6
    assert "in use" in said


def test_silent_robot_names_the_rates_that_were_tried(complain: Complain) -> None:
    with peer(lambda data: b"") as port:
        code, said = complain(port)
    assert code == 7
    for rate in (9600, 19200, 38400, 57600, 115200):
        assert str(rate) in said


def test_something_that_is_no_robot(complain: Complain) -> None:
    with peer(stranger) as port:
        code, said = complain(port, "--baud", "9600")
    assert code == 8
    assert "not as a P2OS robot" in said


def test_unknown_model_names_the_nearest(complain: Complain) -> None:
    with peer(robot_called("p3dx-shh")) as port:
        code, said = complain(port)
    assert code == 9
    assert "nearest are p3dx-sh (Pioneer 3-DX, SH2), " in said
    assert "model = 'p3dx-sh'" in said


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("sonar = 3", "sonar must be"),
        ("enable = true", "did you mean enable_motors"),
        ("model = 'p3dz'", "did you mean"),
        ("model = ", "is not TOML"),
        ("[limits]\nlinear_m_s = -0.5", "limits.linear_m_s must be above 0, not -0.5"),
        ("[limits]\nacceleration_m_s2 = 0", "limits.acceleration_m_s2 must be above 0, not 0"),
        ("[calibration]\ngyro = nan", "calibration.gyro must be a number, not nan"),
        ("[camera]\nfield_of_view_rad = 60.0", "camera.field_of_view_rad must be between 0 and pi, not 60.0"),
    ],
)
def test_configuration_of_no_use_names_file_and_key(complain: Complain, tmp_path: Path, text: str, why: str) -> None:
    file = tmp_path / "happy.toml"
    file.write_text(text)
    with peer(robot_called("p3dx-sh")) as port:
        code, said = complain(port, "--config", str(file))
    assert code == 2
    assert why in said


def test_name_that_is_no_key(complain: Complain) -> None:
    with peer(robot_called("p3dx-sh")) as port:
        code, said = complain(port, "--name", "a/b")
    assert code == 2
    assert "cannot name a robot" in said


@pytest.mark.parametrize("baud", ["fast", "1234", "-9600", ""])
def test_rate_that_is_none(capsys: pytest.CaptureFixture[str], baud: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["/dev/ttyS0", f"--baud={baud}"])
    assert ended.value.code == 2
    assert "is no rate" in capsys.readouterr().err


def test_doctor_says_where_the_way_to_the_robot_ends(tmp_path: Path) -> None:
    findings = list(doctor.examine(str(tmp_path / "ttyUSB0"), "local:doctor"))
    assert [finding.check for finding in findings if not finding.is_ok] == ["port"]
    with peer(lambda data: b"") as port:
        findings = list(doctor.examine(port, "local:doctor"))
    assert [finding.check for finding in findings if not finding.is_ok] == ["robot"]
    assert "no robot answers" in findings[-1].found
    (bus,) = (finding.found for finding in findings if finding.check == "bus")
    assert "profile local:doctor opens; 0 programs are on it, plain Zenoh programs join it at 224.0.0.224:" in bus


def test_radio_modem_takes_no_other_rate(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["/dev/null", "--radio", "--baud", "38400"])
    assert end.value.code == 2
    assert "9600 bit/s only" in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_the_wait_for_a_port_quietly(tmp_path: Path, number: int) -> None:
    command = [sys.executable, "-m", "gateway", str(tmp_path / "ttyUSB0"), "--wait"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"waiting for {tmp_path / 'ttyUSB0'}\n"
        process.send_signal(number)
        said, complaints = end_of(process)
    assert (process.returncode, said, complaints) == (0, "", "")

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from acromovi import doctor
from gateway import local_ports
from gateway.local_ports import candidates, holders, user_of_terminal

HOLD = "import os, sys, time; os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY); print(1, flush=True); time.sleep(60)"
LOCK = "import fcntl, os, sys, time; fcntl.flock(os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY), fcntl.LOCK_EX); "


def test_program_that_holds_a_port_is_named_by_its_process_and_command() -> None:
    master, slave = pty.openpty()
    port = os.ttyname(slave)
    os.close(slave)
    with subprocess.Popen([sys.executable, "-c", HOLD, port], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        [holder] = holders(port)
        process.kill()
    os.close(master)
    assert holder.pid == process.pid
    assert port in holder.command or "import os" in holder.command


def test_free_port_has_no_holder_and_neither_has_a_missing_one(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    assert holders(os.ttyname(slave)) == []  # this process does not count
    assert holders(str(tmp_path)) == []
    assert holders(str(tmp_path / "ttyUSB0")) == []
    os.close(master)
    os.close(slave)


def test_terminal_in_which_somebody_works_is_told_from_the_port_of_an_emulated_robot(
    terminal: tuple[str, int],
) -> None:
    path, pid = terminal
    user = user_of_terminal(path)
    assert user is not None
    assert user.pid == pid
    master, slave = pty.openpty()
    assert user_of_terminal(os.ttyname(slave)) is None
    os.close(master)
    os.close(slave)
    assert user_of_terminal("/dev/null") is None
    assert user_of_terminal("/dev/ttyUSB99") is None


def test_doctor_names_the_process_that_holds_a_busy_port() -> None:
    master, slave = pty.openpty()
    port = os.ttyname(slave)
    command = LOCK + "print(1, flush=True); time.sleep(60)"
    with subprocess.Popen([sys.executable, "-c", command, port], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        [finding] = [each for each in doctor.examine(port, "local") if each.check == "port"]
        process.kill()
    os.close(master)
    os.close(slave)
    assert not finding.is_ok
    assert f"process {process.pid} (" in finding.advice


def test_candidates_are_adapters_serial_ports_with_a_chip_and_links_of_emulators(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    dev, proc, sys_type = tmp_path / "dev", tmp_path / "proc", tmp_path / "sys-{}"
    (dev / "serial" / "by-id").mkdir(parents=True)
    for name in ("ttyUSB0", "ttyUSB1", "ttyACM0", "ttyS0", "ttyS1", "tty1"):
        (dev / name).touch()
    (dev / "serial" / "by-id" / "usb-FTDI").symlink_to("../../ttyUSB1")
    Path(str(sys_type).format("ttyS0")).write_text("4\n")
    Path(str(sys_type).format("ttyS1")).write_text("0\n")
    process = proc / "17"
    process.mkdir(parents=True)
    process.joinpath("cmdline").write_bytes(b"python\0/bin/p2os-emu\0--robot\0p3dx\0--pty\0happy\0")
    process.joinpath("cwd").symlink_to(tmp_path)
    for name in ("happy", "happy-max"):
        (tmp_path / name).symlink_to("/dev/pts/99")
    monkeypatch.setattr(local_ports, "DEV", dev)
    monkeypatch.setattr(local_ports, "PROC", proc)
    monkeypatch.setattr(local_ports, "UART_TYPE", str(sys_type))
    assert candidates() == [
        f"{dev}/serial/by-id/usb-FTDI ({dev}/ttyUSB1)",
        f"{dev}/ttyUSB0",
        f"{dev}/ttyACM0",
        f"{dev}/ttyS0",
        f"{tmp_path}/happy",
        f"{tmp_path}/happy-max",
    ]


def test_doctor_lists_the_ports_of_this_computer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(doctor, "candidates", lambda: ["/dev/ttyUSB7"])
    missing = [each for each in doctor.examine(str(tmp_path / "ttyUSB0"), "local") if each.check == "port"]
    assert "/dev/ttyUSB7" in missing[0].advice
    assert "/dev/ttyUSB7" in next(each for each in doctor.examine(None, "local") if each.check == "ports").found

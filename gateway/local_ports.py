"""Which ports of this computer may lead to a robot, and which programs hold one."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

PROC = Path("/proc")
DEV = Path("/dev")
SERIAL_BY_ID = Path("serial/by-id")
ADAPTERS = ("ttyUSB*", "ttyACM*", "rfcomm*")
"""USB adapters and Bluetooth."""
UART_TYPE = "/sys/class/tty/{}/type"
NO_UART = "0"
"""Of a /dev/ttyS* behind which there is no chip; Linux makes some of these on every computer."""
EMULATOR_COMMANDS = ("p2os-emu", "p2os_emu")
PTY_OPTION = "--pty"
PTY_MAJORS = range(136, 144)
"""Of the device numbers of pseudo-terminals."""
TERMINAL_FIELD = 4
"""Of /proc/PID/stat after the name of the program: the number of its controlling terminal."""
LONGEST_COMMAND = 80
"""Characters of a command line that are shown."""


class _Holder(NamedTuple):
    """A program that has a port open."""

    pid: int
    command: str

    def __str__(self) -> str:
        return f"process {self.pid} ({self.command})"


def holders(path: str) -> list[_Holder]:
    """Return the programs that have the device at this path open, without this one.

    Programs of other users are found only by root.
    """
    try:
        device = Path(path).stat()
    except OSError:
        return []
    if not stat.S_ISCHR(device.st_mode):
        return []
    own = os.getpid()
    return [_Holder(pid, _command(pid)) for pid in _processes() if pid != own and device.st_rdev in _open_devices(pid)]


def user_of_terminal(path: str) -> _Holder | None:
    """Return a program that runs in the pseudo-terminal at this path; None where nobody works in it.

    The numbers of pseudo-terminals are used again: where an emulated robot was, a person's window may be now.
    """
    try:
        number = Path(path).stat().st_rdev
    except OSError:  # there is none; who opens the port says so
        return None
    if os.major(number) not in PTY_MAJORS:
        return None
    return next((_Holder(pid, _command(pid)) for pid in _processes() if _terminal(pid) == number), None)


def candidates() -> list[str]:
    """Return the ports that may lead to a robot: adapters, serial ports with a chip, links of running emulators."""
    by_id = sorted(each for each in (DEV / SERIAL_BY_ID).glob("*") if each.exists())
    behind = {each.resolve() for each in by_id}
    adapters = (each for pattern in ADAPTERS for each in sorted(DEV.glob(pattern)) if each not in behind)
    on_board = (each for each in sorted(DEV.glob("ttyS*")) if _has_uart(each.name))
    others = map(str, (*adapters, *on_board, *_emulated()))
    return [*(f"{each} ({each.resolve()})" for each in by_id), *dict.fromkeys(others)]


def _processes() -> Iterator[int]:
    try:
        yield from sorted(int(entry.name) for entry in PROC.iterdir() if entry.name.isdecimal())
    except OSError:  # not Linux
        return


def _open_devices(pid: int) -> set[int]:
    """Return the numbers of the character devices that a process has open; empty without permission."""
    found: set[int] = set()
    try:
        for entry in (PROC / str(pid) / "fd").iterdir():
            try:
                file = entry.stat()
            except OSError:  # just closed
                continue
            if stat.S_ISCHR(file.st_mode):
                found.add(file.st_rdev)
    except OSError:  # another user's, or it has just ended
        pass
    return found


def _terminal(pid: int) -> int | None:
    """Return the device number of the controlling terminal of a process; None without one."""
    try:
        told = (PROC / str(pid) / "stat").read_text(encoding="utf-8", errors="replace")  # its name is any bytes
    except OSError:  # it has just ended
        return None
    return int(told.rpartition(")")[2].split()[TERMINAL_FIELD]) or None  # numbered as `stat` does


def _arguments(pid: int) -> list[str]:
    try:
        return (PROC / str(pid) / "cmdline").read_bytes().decode("utf-8", "replace").rstrip("\0").split("\0")
    except OSError:  # it has just ended
        return []


def _command(pid: int) -> str:
    return " ".join(_arguments(pid))[:LONGEST_COMMAND] or "unknown command"


def _has_uart(name: str) -> bool:
    try:
        return Path(UART_TYPE.format(name)).read_text().strip() != NO_UART
    except OSError:  # some drivers do not say
        return True


def _emulated() -> Iterator[Path]:
    """Return the links that running emulators make: PATH, or PATH-NAME for each of several robots."""
    for pid in _processes():
        arguments = _arguments(pid)
        if not any(name in argument for name in EMULATOR_COMMANDS for argument in arguments[:3]):
            continue
        for index, argument in enumerate(arguments):
            if not argument.startswith(PTY_OPTION):
                continue
            option, is_joined, value = argument.partition("=")
            given = value if is_joined else arguments[index + 1] if index + 1 < len(arguments) else ""
            if option == PTY_OPTION and given:
                yield from _links(pid, given)


def _links(pid: int, given: str) -> Iterator[Path]:
    try:
        path = (PROC / str(pid) / "cwd").readlink() / given
    except OSError:  # another user's
        path = Path(given)
    yield from (each for each in (path, *sorted(path.parent.glob(f"{path.name}-*"))) if each.is_symlink())

"""Starts the project's programs for one worker of the tests, as copies of a process that has loaded their modules.

The tests start hundreds of programs, and each would load its modules for half a second of processor time. A copy is a
process like any other: with a number, a memory, descriptors and signals of its own. It becomes a child of the worker,
which waits for it as for every process.

Standard input is a socket. Each message there is the JSON of an `Order`, with the descriptors that the program gets;
the reply is the number of the process.
"""

import io
import json
import os
import pkgutil
import runpy
import signal
import socket
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from acromovi.team.fork_server import show_command
from configs.startup import uncollected

LARGEST = 1 << 17  # bytes of a message
MOST = 64  # descriptors of one program
PACKAGES = {
    "acromovi": ("acromovi", "agents", "bus"),
    "gateway": ("gateway",),
    "p2os_emu": ("p2os_emu",),
}
"""Programs that are started as copies, and what is loaded for them."""
OF_APPLICATIONS = ("console", "promote", "remote-vision", "run")
"""Commands of `acromovi` that load applications."""


def main() -> None:
    """Serve until the socket is closed, which it is when the worker ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    loaded: set[str] = set()
    with socket.socket(fileno=os.dup(sys.stdin.fileno())) as link:
        while True:
            message, descriptors, _, _ = socket.recv_fds(link, LARGEST, MOST)
            if not message:
                return
            order = json.loads(message)
            program, command = (*order["words"], "")[:2]
            wanted = {*PACKAGES[program], *(("apps",) if command in OF_APPLICATIONS else ())}
            for package in sorted(wanted - loaded):
                _load(package)
                loaded.add(package)
            link.send(str(_start(order, descriptors, link)).encode())
            for each in descriptors:
                os.close(each)


def _load(package: str) -> None:
    """Load all modules of a package, so that a copy need not."""
    with uncollected():
        for module in pkgutil.walk_packages(import_module(package).__path__, f"{package}."):
            if not module.name.endswith("__main__"):  # that is run, and must not have been loaded before
                import_module(module.name)


def _start(order: dict[str, Any], descriptors: list[int], link: socket.socket) -> int:
    """Start a copy whose parent ends at once, so that it becomes a child of the worker; return its number."""
    number, told = os.pipe()
    may_begin, begin = os.pipe()
    parent = os.fork()
    if parent == 0:
        copy = os.fork()
        if copy == 0:
            os.close(begin)
            os.read(may_begin, 1)  # nothing comes: the pipe is closed when the worker is the parent
            link.close()
            for each in (number, told, may_begin):
                os.close(each)
            _become(order, descriptors)
        os.write(told, str(copy).encode())
        os._exit(0)
    os.waitpid(parent, 0)
    pid = int(os.read(number, 32))
    for each in (number, told, may_begin, begin):
        os.close(each)
    return pid


def _become(order: dict[str, Any], descriptors: list[int]) -> NoReturn:
    """Run a module as `python -m` does, in a copy of this process."""
    if order["session"]:
        os.setsid()
    elif order["group"] >= 0:
        os.setpgid(0, order["group"])
    _take(descriptors, order["numbers"])
    if order["folder"]:
        os.chdir(order["folder"])
    os.environ.clear()
    os.environ.update(order["environment"])
    signal.signal(signal.SIGINT, signal.SIG_IGN if order["deaf"] else signal.default_int_handler)
    for name, number, mode in (("stdin", 0, "r"), ("stdout", 1, "w"), ("stderr", 2, "w")):
        setattr(sys, name, _stream(number, mode))
    module, *arguments = order["words"]
    sys.argv = [module, *arguments]
    sys.path[0] = str(Path.cwd())
    sys.path[1:1] = [each for each in order["environment"].get("PYTHONPATH", "").split(os.pathsep) if each]
    show_command((sys.executable, "-m", *order["words"]))
    runpy.run_module(module, run_name="__main__", alter_sys=True)
    sys.exit()


def _take(descriptors: list[int], numbers: list[int]) -> None:
    """Give descriptors the numbers that the program expects."""
    above = max((*numbers, *descriptors)) + 1
    for offset, each in enumerate(descriptors):  # first out of the way, so that none is overwritten
        os.dup2(each, above + offset)
        os.close(each)
    for offset, number in enumerate(numbers):
        os.dup2(above + offset, number)
        os.close(above + offset)


def _stream(number: int, mode: str) -> io.TextIOWrapper | None:
    """Make a standard stream as the interpreter does; None where there is none."""
    with suppress(OSError):  # the program was started without this stream, as a daemon is
        errors = "backslashreplace" if number == 2 else "strict"
        by_line = number == 2 or os.isatty(number)
        at_once = mode == "w" and bool(os.environ.get("PYTHONUNBUFFERED"))
        file: Any = open(number, mode + "b", 0 if at_once else -1, closefd=False)  # noqa: SIM115  # for all its life
        return io.TextIOWrapper(file, errors=errors, line_buffering=by_line, write_through=at_once)
    return None


if __name__ == "__main__":
    main()

"""Starts containers and gateways of a team as copies of a process that has loaded their modules.

Loading them takes half a second of processor time for each process, and 20 MB that copies share. The server is a
process of its own, since a program with threads cannot be copied. A copy is a process like any other: when one fails,
the others go on, and when the server fails, its copies go on and others are started without it.

Its standard input is a socket. Each message there is the JSON of a command line, `[MODULE, ARGUMENT, ...]`, with two
descriptors, for standard output and standard error. It sends `{"started": PID}`, in the order of the messages, and
`{"ended": PID, "code": CODE}` when a copy has ended.
"""

import ctypes
import json
import os
import select
import signal
import socket
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NoReturn

from bus import JSON
from bus.keys import TOPICS
from configs.startup import uncollected

MODULES = (
    "acromovi.container",
    "agents.components.robot_agents",
    "agents.services.all_services",
    "bus.session",
    "gateway.__main__",
)
LARGEST = 1 << 17  # bytes of a message
ROOM = 1000
"""Characters of its own command line that are kept free for those of its copies."""


def main() -> None:
    """Serve until the socket is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all end in order
    reader, writer = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)  # the byte in the pipe is enough
    with uncollected():  # no copy writes to what it shares
        from bus.messages import prepare  # not at the top: who starts this server needs no messages

        for module in MODULES:
            import_module(module)
        for type_name in sorted({topic.type_name for topic in TOPICS} - {JSON, ""}):
            prepare(type_name)
    with socket.socket(fileno=sys.stdin.fileno()) as link, suppress(BrokenPipeError):  # then the team has ended
        waited: list[socket.socket | int] = [link, reader]
        while True:
            ready, _, _ = select.select(waited, [], [])
            if reader in ready:
                os.read(reader, 4096)
                _tell_of_ended(link)
            if link in ready:
                message, descriptors, _, _ = socket.recv_fds(link, LARGEST, 2)
                if not message:
                    return
                pid = os.fork()
                if pid == 0:
                    link.detach()
                    _become(json.loads(message), descriptors)
                for each in descriptors:
                    os.close(each)
                link.send(json.dumps({"started": pid}).encode())


def _tell_of_ended(link: socket.socket) -> None:
    while True:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return  # there are no more
        if pid == 0:
            return
        link.send(json.dumps({"ended": pid, "code": os.waitstatus_to_exitcode(status)}).encode())


def _become(words: Sequence[str], descriptors: Sequence[int]) -> NoReturn:
    """Run a module as `python -m` does, in a copy of this process."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    nothing = os.open(os.devnull, os.O_RDONLY)
    for number, descriptor in enumerate((nothing, *descriptors)):
        os.dup2(descriptor, number)
        os.close(descriptor)
    module, *arguments = words
    sys.argv = [module, *arguments]
    show_command((sys.executable, "-m", *words))
    sys.exit(import_module(f"{module}.__main__").main(arguments))


def show_command(words: Sequence[str]) -> None:
    """Overwrite this process's command line, which people and programs look for, as far as there is room."""
    fields = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    begin, end = int(fields[45]), int(fields[46])  # proc(5): arg_start and arg_end, 48 and 49 of all
    if 0 < begin < end:
        text = "\0".join(words).encode()[: end - begin - 1]
        ctypes.memmove(begin, text.ljust(end - begin, b"\0"), end - begin)


if __name__ == "__main__":
    main()

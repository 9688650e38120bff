"""Lets the tests' Python programs begin as copies of a server that has loaded them.

`subprocess` starts `python -m gateway` and the like by it, whoever calls it: the tests, `asyncio`, or product code that
runs within a test. With `--no-forks` each of them begins with an interpreter of its own, as it does for users; so does
all that is started by its script, with `python -c`, or by another program.
"""

import ctypes
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from threading import Lock
from typing import Any

import pytest

from tests.fork_server import LARGEST, MOST, PACKAGES

ROOM = 2000  # characters of its own command line that the server keeps free for those of its copies
SUBREAPER = 36  # prctl(2): PR_SET_CHILD_SUBREAPER


class Forks:
    """Starts programs of this process. It is put in the place of `subprocess._fork_exec`, with the same arguments.

    server: number of the process that is copied; 0 before the first program has begun.
    """

    def __init__(self, fork_exec: Any) -> None:
        """Take the function that starts all other programs."""
        self.fork_exec = fork_exec
        self._lock = Lock()
        self._owner = os.getpid()
        self._link: socket.socket | None = None
        self.server = 0

    def __call__(self, *arguments: Any) -> int:
        """Start a program; return its number."""
        order = _order(*arguments)
        if order is None or os.getpid() != self._owner:
            return int(self.fork_exec(*arguments))
        stdin, stdout, stderr, told = (arguments[index] for index in (6, 9, 11, 13))
        given = {number: end if end >= 0 else number for number, end in enumerate((stdin, stdout, stderr))}
        given |= {number: number for number in arguments[3] if number > 2 and number != told}
        message = json.dumps(order | {"numbers": list(given)}).encode()
        if len(message) > LARGEST or len(given) > MOST:
            return int(self.fork_exec(*arguments))
        with self._lock:
            pid = self._start(message, list(given.values()))
        return pid or int(self.fork_exec(*arguments))

    def close(self) -> None:
        """End the server; its copies go on."""
        if self._link is not None and os.getpid() == self._owner:
            self._link.close()
            self._link = None
            os.waitpid(self.server, 0)

    def _start(self, message: bytes, descriptors: list[int]) -> int:
        """Return the number of a copy; 0 if the server has ended, of which another one takes the place next time."""
        link = self._link = self._link or self._open()
        _adopt(True)
        try:
            socket.send_fds(link, [message], descriptors)
            reply = link.recv(LARGEST)
        except OSError:
            reply = b""
        finally:
            _adopt(False)
        if not reply:
            self.close()
        return int(reply or 0)

    def _open(self) -> socket.socket:
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with its:
            command = [sys.executable, "-m", "tests.fork_server", " " * ROOM]
            environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # a process with threads cannot be copied
            taking = [(os.POSIX_SPAWN_DUP2, its.fileno(), 0)]
            self.server = os.posix_spawn(sys.executable, command, environment, file_actions=taking)
        return ours


def _order(*arguments: Any) -> dict[str, Any] | None:
    """What the server is told; None for what it does not start."""
    args, _, close_fds, _, cwd, variables = arguments[:6]
    session, group, *others = arguments[15:22]  # user, groups, mask of files, and a function to be called
    words = [os.fsdecode(each) for each in args]
    environment = dict(os.environ)
    if variables is not None:
        environment = dict(os.fsdecode(each).split("=", 1) for each in variables)
    folder = os.fsdecode(cwd or Path.cwd())
    if (
        words[:2] != [sys.executable, "-m"]
        or words[2] not in PACKAGES
        or not close_fds
        or others != [None, None, None, -1, None]
        or _of_interpreter(environment) != _of_interpreter(os.environ)
        or not Path(folder).is_dir()  # `subprocess` says what is wrong with it
    ):
        return None
    return {
        "words": words[2:],
        "folder": folder,
        "environment": environment,
        "session": bool(session),
        "group": group,
        "deaf": signal.getsignal(signal.SIGINT) is signal.SIG_IGN,
    }


def _of_interpreter(environment: Mapping[str, str]) -> dict[str, str]:
    """Variables that an interpreter reads when it begins, which is too late for a copy."""
    return {
        name: value
        for name, value in environment.items()
        if name.startswith(("PYTHON", "LANG", "LC_")) and name != "PYTHONPATH"
    }


def _adopt(on: bool) -> None:
    """Become the parent of descendants whose own parent ends, or no more.

    Only for the moment of a start: what programs under test leave behind is a child of process 1, as it is for users.
    """
    if ctypes.CDLL(None, use_errno=True).prctl(SUBREAPER, int(on), 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_CHILD_SUBREAPER)")


def pytest_addoption(parser: pytest.Parser) -> None:
    """What may be given on the command line."""
    group = parser.getgroup("acromovi")
    group.addoption("--no-forks", action="store_true", help="start each program with an interpreter of its own")


def pytest_configure(config: pytest.Config) -> None:
    """Start programs as copies until the tests have ended."""
    original = getattr(subprocess, "_fork_exec", None)
    if sys.platform == "linux" and original is not None and not config.getoption("--no-forks"):
        forks, patch = Forks(original), pytest.MonkeyPatch()
        config.add_cleanup(forks.close)
        config.add_cleanup(patch.undo)  # what is added last is done first
        patch.setattr(subprocess, "_fork_exec", forks)
        # The other way to start a program, which Python 3.13 prefers; its documentation says to switch it off so.
        patch.setattr(subprocess, "_USE_POSIX_SPAWN", False)

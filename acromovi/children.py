"""Emulator and gateway as child processes, ended with the block that started them."""

import json
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

ENDING_TIMEOUT_S = 5.0


class ChildFailed(RuntimeError):
    """A program that was started ended before it was ready; the message holds what it said."""


@dataclass(frozen=True, slots=True)
class EmulatedRobots:
    """A running `p2os-emu`: its process, its robots as it announced them, and its control socket."""

    process: subprocess.Popen[str]
    robots: tuple[dict[str, Any], ...]
    control: str

    @property
    def port(self) -> str:
        """The first robot's port."""
        return str(self.robots[0]["port"])

    def ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Put one request to the control socket.

        Raises:
            ChildFailed: The emulator refused, or is gone.
        """
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as control, control.makefile("rw") as stream:
                control.settimeout(ENDING_TIMEOUT_S)
                control.connect(self.control)
                stream.write(json.dumps({"do": do, **arguments}) + "\n")
                stream.flush()
                answer = json.loads(stream.readline())
        except (OSError, ValueError) as error:
            raise ChildFailed(f"the emulator does not answer '{do}' any more: {error}") from error
        if not answer.get("ok"):
            raise ChildFailed(f"the emulator refused '{do}': {answer.get('error')}")
        return dict(answer)


@contextmanager
def emulator(*arguments: str) -> Iterator[EmulatedRobots]:
    """Run `p2os-emu` with these arguments until the block ends; yields once every robot is ready."""
    with (
        tempfile.TemporaryDirectory(prefix="p2os-emu-") as folder,  # ours, so that it goes also after a kill
        _child("p2os_emu", ["--json", "--control", f"{folder}/control", *arguments], subprocess.PIPE) as process,
    ):
        assert process.stdout is not None
        line = process.stdout.readline()
        if not line:
            process.wait(ENDING_TIMEOUT_S)
            raise ChildFailed(f"p2os-emu ended with exit code {process.returncode} before its robots were ready")
        announced = json.loads(line)
        yield EmulatedRobots(process, tuple(announced["robots"]), announced["control"])


@contextmanager
def gateway(port: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run `p2os-gateway` on this port until the block ends; yields at once, while it connects."""
    with _child("gateway", [port, *arguments], stdout=subprocess.DEVNULL) as process:
        yield process


@contextmanager
def _child(module: str, arguments: Sequence[str], stdout: int) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", module, *arguments]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, text=True) as process:
        try:
            yield process
        finally:
            end(process)


def end(process: subprocess.Popen[str]) -> None:
    """Ask a process to end, and make it end when it does not listen."""
    process.terminate()
    try:
        process.wait(ENDING_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()

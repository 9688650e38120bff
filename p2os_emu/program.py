"""`p2os-emu` as a child process, for tests and programs that need a robot for a while.

It loads neither physics nor numbers into the program that uses it. The child ends with the block that started it, and
by itself when the program that started it is gone, however that ended.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from p2os_emu.control_client import ControlRefused, ask_emulator
from p2os_emu.private_folder import sweep

ENDING_TIMEOUT_S = 5.0
_SPEAKER = "p2os-emu: "


class ChildFailed(RuntimeError):
    """The emulator ended before it was ready, refused a request or no longer answers; the message quotes it."""


@dataclass(frozen=True, slots=True)
class EmulatedRobots:
    """A running `p2os-emu`.

    process: the child. robots: for each robot its name, model and ports, as in the output of `--json`. control: path of
    the control socket; empty without one.
    """

    process: subprocess.Popen[str]
    robots: tuple[dict[str, Any], ...]
    control: str

    @property
    def port(self) -> str:
        """Port of the first robot."""
        return str(self.robots[0]["port"])

    def ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send one request to the control socket and return the reply.

        Raises:
            ChildFailed: The emulator refused, or is gone.
        """
        __tracebackhide__ = True  # pytest shows the test's line, and not this one
        try:
            return ask_emulator(self.control, {"do": do, **arguments})
        except ControlRefused as error:
            raise ChildFailed(f"the emulator refused '{do}': {error}") from error
        except (OSError, ValueError) as error:
            raise ChildFailed(f"the emulator does not answer '{do}' any more: {error}") from error


@contextmanager
def emulator(*arguments: str) -> Iterator[EmulatedRobots]:
    """Run `p2os-emu` with these arguments until the block ends; yields once every robot is ready.

    Raises:
        ChildFailed: It could not start; the message is its own.
    """
    command = [sys.executable, "-m", "p2os_emu", "--json", *arguments, "--until-stdin-closes"]
    # Standard input is held open and never written to: its end tells the child that this program is gone.
    with (
        tempfile.TemporaryFile("w+") as said,
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, text=True) as process,
    ):
        robots = None
        try:
            robots = _announced(process, said)
            yield robots
        finally:
            end(process)
            if robots is not None:
                sweep(Path(robots.control).parent)
            said.seek(0)
            print(said.read(), end="", file=sys.stderr)


def end(process: subprocess.Popen[str]) -> None:
    """Ask a process to end, and make it end when it does not listen."""
    process.terminate()
    try:
        process.wait(ENDING_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _announced(process: subprocess.Popen[str], said: IO[str]) -> EmulatedRobots:
    assert process.stdout is not None
    line = process.stdout.readline()
    if line:
        announced = json.loads(line)
        return EmulatedRobots(process, tuple(announced["robots"]), announced["control"] or "")
    process.wait(ENDING_TIMEOUT_S)
    said.seek(0)
    complaint = said.read().strip().rpartition(_SPEAKER)[2]
    said.truncate(0)  # it is told with the error
    raise ChildFailed(complaint or f"p2os-emu ended with exit code {process.returncode} before its robots were ready")

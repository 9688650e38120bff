"""`p2os-gateway` as a child process, for tests and programs that need a robot on the bus for a while.

It loads neither Zenoh nor a driver into the program that uses it.
"""

import json
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import IO

from gateway.errors import GatewayError

ENDING_TIMEOUT_S = 5.0
_PREFIX = "p2os-gateway: "


@dataclass(frozen=True, slots=True)
class RunningGateway:
    """A running `p2os-gateway` that has connected to its robot.

    process: the child. robot: the robot's name on the bus. model: of the robot, as in `configs/robots/`.
    """

    process: "subprocess.Popen[str]"
    robot: str
    model: str


@contextmanager
def start(
    port: str,
    *,
    name: str | None = None,
    bus: str | None = None,
    config: str | Path | None = None,
    options: Iterable[str] = (),
) -> Iterator[RunningGateway]:
    """Run `p2os-gateway` on a port until the block ends.

    The block begins when the gateway has connected to the robot; the robot's keys appear on the bus within a second.
    At the end of the block the robot stops and the gateway ends. If the program that called this is killed, the gateway
    continues to run.

    Args:
        port: Device, pseudo-terminal, `socket://HOST:PORT` or `rfc2217://HOST:PORT`.
        name: The robot's name on the bus; None for the name that the robot reports.
        bus: Bus profile or file, as `--bus`; None for the default profile.
        config: TOML file with the settings of the robot, as `--config`; None for the defaults.
        options: Further options of `p2os-gateway`. With `--wait` the block begins only when there is a robot.
    Raises:
        GatewayError: The gateway ended before it was connected; the message is its own.
        TypeError: An argument is not of the type above.
    """
    command = [sys.executable, "-m", "gateway", _text("port", port), "--json"]
    for option, value in ("name", name), ("bus", bus), ("config", config):
        if value is not None:
            command += [f"--{option}", str(value) if isinstance(value, Path) else _text(option, value)]
    if isinstance(options, str):
        raise TypeError(f"options is a list of texts, as [{options!r}], not one text")
    command += options
    with (
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, text=True
        ) as process,
    ):
        assert process.stdout is not None
        # What the gateway prints later is read and dropped, so that its pipe never fills.
        drain = Thread(target=deque, args=(process.stdout, 0), name="gateway output", daemon=True)
        try:
            running = _connected(process, errors)
            drain.start()
            yield running
        finally:
            process.terminate()
            try:
                process.wait(ENDING_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                process.kill()
            if drain.is_alive():
                drain.join()
            errors.seek(0)
            print(errors.read(), end="", file=sys.stderr)


def _connected(process: "subprocess.Popen[str]", errors: IO[str]) -> RunningGateway:
    """Wait until the gateway reports that it is connected."""
    assert process.stdout is not None
    for line in process.stdout:
        event = json.loads(line)
        if event["event"] == "connected":
            return RunningGateway(process, event["robot"], event["model"])
    code = process.wait(ENDING_TIMEOUT_S)
    errors.seek(0)
    message = errors.read().strip().rpartition(_PREFIX)[2]
    errors.seek(0)
    errors.truncate()  # the exception holds it
    raise GatewayError(message or f"p2os-gateway ended with exit code {code} before it was connected")


def _text(argument: str, value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{argument} is a text, not {value!r}")
    return value

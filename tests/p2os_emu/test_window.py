"""The window, on a display of this test's own."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.waiting import run


@pytest.fixture
def display() -> Iterator[str]:
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("a window needs a display, and Xvfb, which would make one, is not installed")
    reader, writer = os.pipe()
    command = [server, "-displayfd", str(writer), "-screen", "0", "800x600x24", "-nolisten", "tcp"]
    # The server complains of keyboards that nobody has.
    with subprocess.Popen(command, pass_fds=[writer], stderr=subprocess.DEVNULL) as process:
        os.close(writer)
        try:
            with os.fdopen(reader) as answer:
                yield f":{answer.readline().strip()}"
        finally:
            process.terminate()


def test_window_opens_and_leaves_standard_output_to_the_one_line_of_json(display: str) -> None:
    command = [sys.executable, "-m", "p2os_emu", "--robot", "powerbot", "--gui", "--json", "--duration", "0.5"]
    environment = {**os.environ, "DISPLAY": display}
    done = run(command, env=environment)
    assert done.returncode == 0, done.stderr
    (line,) = done.stdout.splitlines()
    assert json.loads(line)["robots"][0]["model"] == "powerbot"

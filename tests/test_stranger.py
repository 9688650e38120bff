"""A stranger's script drives `p2os-emu --robot powerbot --json` as it would a real robot: the promise of the README."""

import ast
import json
import select
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.waiting import exit_code, patience, run

SCRIPT = Path(__file__).with_name("stranger.py")
COMMAND = Path(sysconfig.get_path("scripts")) / "p2os-emu"


@pytest.fixture
def port() -> Iterator[str]:
    with subprocess.Popen([COMMAND, "--robot", "powerbot", "--json"], stdout=subprocess.PIPE, text=True) as emulator:
        try:
            assert emulator.stdout is not None
            assert select.select([emulator.stdout], [], [], patience())[0], "not ready in time"
            ready = json.loads(emulator.stdout.readline())
            (robot,) = ready["robots"]
            assert robot["model"] == "powerbot"
            assert Path(ready["control"]).is_socket()
            yield robot["port"]
        finally:
            emulator.terminate()
            assert exit_code(emulator) == 0


def test_the_script_uses_nothing_but_the_standard_library() -> None:
    tree = ast.parse(SCRIPT.read_text(encoding="utf-8"))
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module).partition(".")[0] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert imported <= sys.stdlib_module_names


def test_a_stranger_connects_hears_28_discs_drives_turns_and_sees_the_watchdog(port: str) -> None:
    done = run([sys.executable, "-I", str(SCRIPT), port], 60.0)  # what it does takes 8 s
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert seen["syncs"] == [0, 1, 2]
    assert seen["identity"][1:] == ["Pioneer", "powerbot", ""]
    assert seen["sonar"] == [*range(7), *range(8, 15), *range(16, 23), *range(24, 31)]
    assert seen["speed"] == pytest.approx([200, 200], abs=20)
    assert seen["rest"] == pytest.approx([0, 0], abs=10)
    assert abs(seen["turned"]) < 12  # 1 degree
    assert seen["halted"] == pytest.approx([0, 0], abs=10)
    assert 1.5 < seen["silence"] < 4.0  # the watchdog's 2 s, and the way to a stop

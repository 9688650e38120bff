"""Scripts as students write them, which catch nothing and close nothing: what they read is a sentence."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.waiting import run

BEGIN = """\
import os, signal, threading
from agents import RobotError, Team
from bus import MemoryBus

team = Team(MemoryBus())
"""
CTRL_C = "threading.Timer(0.2, os.kill, [os.getpid(), signal.SIGINT]).start()\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scripts")


def run_script(folder: Path, text: str) -> "subprocess.CompletedProcess[str]":
    """Run a script to its end."""
    (folder / "drive.py").write_text(BEGIN + text)
    command = [sys.executable, str(folder / "drive.py")]
    return run(command, cwd=folder)


@pytest.mark.parametrize(
    ("text", "told", "code"),
    [
        ("def go():\n    team.robot('a robot')\ngo()\n", r"drive.py, line 7: 'a robot' cannot name a robot.*", 1),
        (CTRL_C + "team.sleep(60.0)\n", r"drive.py, line 7: stopped by Ctrl-C", -2),
        ("with team:\n    " + CTRL_C + "    team.sleep(60.0)\n", r"drive.py, line 8: stopped by Ctrl-C", -2),
        (
            "def go():\n    team.ask('nobody', 'read')\nthread = threading.Thread(target=go)\n"
            "thread.start()\nthread.join()\n",
            r"drive.py, line 7: 'nobody' names no agent.*",
            0,
        ),
        (
            "for beat in team.every(0):\n    pass\n",
            r"drive.py, line 6: every takes a period of more than 0 s, not 0",
            1,
        ),
        ("raise SystemExit('enough')\n", "enough", 1),
    ],
)
def test_what_a_script_does_not_catch_is_one_sentence(folder: Path, text: str, told: str, code: int) -> None:
    ended = run_script(folder, text)
    assert re.fullmatch(f"{told}\n", ended.stderr), ended.stderr
    assert ended.returncode == code


def test_a_mistake_that_has_nothing_to_do_with_robots_is_told_as_python_does(folder: Path) -> None:
    ended = run_script(folder, "print(1 / 0)\n")
    assert ended.stderr.startswith("Traceback (most recent call last):\n")
    assert ended.stderr.endswith("ZeroDivisionError: division by zero\n")


def test_a_script_that_closes_nothing_ends_in_silence(folder: Path) -> None:
    ended = run_script(folder, "print(team.robots())\n")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "[]\n", "")


def test_who_tells_errors_in_his_own_way_goes_on_to(folder: Path) -> None:
    first = "import sys\nsys.excepthook = lambda *error: print('mine')\n"
    (folder / "drive.py").write_text(first + BEGIN + "team.robot('a robot')\n")
    ended = run([sys.executable, "drive.py"], cwd=folder)
    assert (ended.stdout, ended.stderr) == ("mine\n", "")

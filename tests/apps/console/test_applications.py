"""Applications that the console starts: which there are, what they take, their output and their end."""

import asyncio
from pathlib import Path

import pytest

from apps.console.applications import ApplicationRun, ApplicationRuns

OWN = '''\
"""A file."""
import time

def main(team, robot: str = "", laps: int = 3, quick=False):
    """Go round and round.

    More.
    """
    print("round", laps, flush=True)
    time.sleep(100)
'''


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "laps.py").write_text(OWN)
    (tmp_path / "broken.py").write_text("def main(")
    (tmp_path / "tool.py").write_text("def helper(): pass")
    return tmp_path


def test_applications_are_found_with_their_arguments_and_none_is_imported(folder: Path) -> None:
    known = {app.name: app for app in ApplicationRuns("local", ".", [folder]).known()}
    assert {"wander", "optical_flow", "formation", "laps"} <= known.keys()
    assert not {"broken", "tool", "console", "remote_vision", "web"} & known.keys()
    assert known["laps"].parameters == {"robot": "", "laps": "3", "quick": "false"}
    assert known["laps"].about == "Go round and round."
    assert known["wander"].parameters["speed"] == "0.2"


def test_what_is_not_known_or_not_taken_is_not_started(folder: Path) -> None:
    runs = ApplicationRuns("local", ".", [folder])
    for name, arguments in (("../laps", {}), ("laps", {"--bus": "x"})):
        with pytest.raises(ValueError, match=r"there is no application|does not take"):
            asyncio.run(runs.start(name, arguments))
    assert runs.runs == []


def test_output_is_kept_within_limits() -> None:
    run = ApplicationRun(1, "talker", [])
    for number in range(2000):
        run.add(f"{number} " + "x" * 5000)
    assert len(run.lines) == 500
    assert len(run.lines[-1]) == 1000
    assert run.line_count == 2000

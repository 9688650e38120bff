"""`acromovi navigate up` with real processes, on a bus of its own."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from acromovi.navigation.components import RunningNavigation
from bus import NoAnswer, ZenohBus
from tests.acromovi.team.private_bus import private_bus
from tests.acromovi.team.running import ROOT, alive, run
from tests.waiting import exit_code, wait_until


@dataclass
class Up:
    """A navigation that is up. announced: the line of `--json`. folder: where all that it makes lies."""

    process: "subprocess.Popen[str]"
    profile: str
    folder: Path
    announced: dict[str, object]
    bus: ZenohBus

    def pid(self, container: str) -> int:
        """The process of a container; 0 while nobody answers for it."""
        try:
            (answer,) = self.bus.query(f"happy/containers/{container}/description", {"do": "list"}, 1.0)
        except NoAnswer:
            return 0
        return int(answer.value["process"])

    def components(self) -> set[str]:
        return {str(each["name"]) for each in RunningNavigation(self.bus, "happy").descriptions()}


@pytest.fixture(scope="module")
def up() -> Iterator[Up]:
    folder = Path(tempfile.mkdtemp(prefix="navigate-"))
    made = folder / "made"
    made.mkdir()
    profile = private_bus()
    process = subprocess.Popen(
        [sys.executable, "-m", "acromovi", "navigate", "up", "happy", "--json", "--bus", profile],
        cwd=ROOT,
        env={**os.environ, "TMPDIR": str(made)},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        with process, ZenohBus.open(profile) as bus:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line, "the navigation has not come up"
            yield Up(process, profile, made, json.loads(line), bus)
            process.terminate()
    finally:
        for pid in alive(process.pid):
            os.kill(pid, signal.SIGKILL)
        shutil.rmtree(folder)


def test_its_processes_are_those_of_the_wiring(up: Up) -> None:
    processes = up.announced["processes"]
    assert isinstance(processes, dict)
    assert processes["hardware"] == ["robot_base_server", "laser_server"]
    wanted = {f"{local}@happy" for names in processes.values() for local in names}
    wait_until(lambda: up.components() == wanted, "all components are in the directory")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_process_that_is_killed_or_frozen_is_back_by_itself(up: Up, number: signal.Signals) -> None:
    before = up.pid("happy-hardware")
    assert before
    os.kill(before, number)
    wait_until(lambda: up.pid("happy-hardware") not in (0, before), "there is another process")
    wait_until(lambda: "laser_server@happy" in up.components(), "its components are back")


def test_what_is_up_is_not_started_a_second_time(up: Up) -> None:
    done = run("navigate", "up", "happy", "--bus", up.profile)
    assert done.returncode == 1
    assert "@happy is on this bus already; stop it first" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_wiring_is_drawn_from_what_runs(up: Up, tmp_path: Path) -> None:
    file = tmp_path / "wiring.svg"
    done = run("navigate", "wiring", "happy", str(file), "--bus", up.profile)
    assert done.returncode == 0, done.stderr
    assert "happy-hardware" in file.read_text()
    done = run("navigate", "wiring", "grumpy", str(file), "--bus", up.profile)
    assert done.returncode == 1
    assert done.stderr == "acromovi navigate: nobody navigates grumpy; start it with: acromovi navigate up grumpy\n"


def test_ctrl_c_ends_all_and_nothing_is_left(up: Up) -> None:
    up.process.send_signal(signal.SIGINT)
    assert exit_code(up.process) == 130
    wait_until(lambda: not alive(up.process.pid), "no process is left")
    assert list(up.folder.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--process", "hardwear"], "has no process 'hardwear'; choose one of hardware"),
        (["--set", "components.goto.nmbers=1"], "unknown key"),
        (["--wiring", "nowhere.toml"], "nowhere.toml cannot be read"),
        (["--bus", "locl"], "did you mean local"),
    ],
)
def test_a_mistake_is_one_sentence(arguments: list[str], why: str) -> None:
    done = run("navigate", "up", "happy", *arguments)
    assert done.returncode == 1
    assert why in done.stderr
    assert done.stderr.count("\n") == 1

"""Programs that begin as copies of a loaded process: whoever starts them sees no difference."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.acromovi.team.private_bus import private_bus
from tests.fork_server import PACKAGES
from tests.forks import Forks
from tests.waiting import end_of, exit_code, run, wait_until

LISTING = [sys.executable, "-m", "p2os_emu", "--list-robots"]
EMULATOR = [sys.executable, "-m", "p2os_emu", "--robot", "p3dx", "--world", "empty", "--json"]


@pytest.fixture(autouse=True)
def forks(request: pytest.FixtureRequest) -> Forks:
    if request.config.getoption("--no-forks"):
        pytest.skip("programs do not begin as copies with --no-forks")
    forks = getattr(subprocess, "_fork_exec", None)
    assert isinstance(forks, Forks)
    return forks


def test_a_copy_prints_and_ends_as_a_program_with_an_interpreter_of_its_own(
    forks: Forks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = [sys.executable, "-m", "gateway", "--nonsense"]
    copies = [run(command, cwd=tmp_path) for command in (LISTING, wrong)]
    with monkeypatch.context() as without:
        without.setattr(subprocess, "_fork_exec", forks.fork_exec)
        others = [run(command, cwd=tmp_path) for command in (LISTING, wrong)]
    assert [(each.returncode, each.stdout, each.stderr) for each in copies] == [
        (each.returncode, each.stdout, each.stderr) for each in others
    ]


def test_a_copy_is_a_child_with_the_folder_environment_and_command_line_that_it_was_given(tmp_path: Path) -> None:
    environment = {**os.environ, "OWN": "value", "P2OS_BUS": private_bus()}
    with subprocess.Popen(
        EMULATOR, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        assert process.stdout is not None
        assert json.loads(process.stdout.readline())["robots"]
        place = Path(f"/proc/{process.pid}")
        fields = (place / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        parent, group, session = map(int, fields[1:4])  # proc(5)
        assert (parent, group, session) == (os.getpid(), process.pid, process.pid)
        assert (place / "cwd").readlink() == tmp_path
        words = (place / "cmdline").read_text(encoding="utf-8").rstrip("\0").split("\0")
        assert words == EMULATOR
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 0


def test_a_copy_prints_at_once_where_the_environment_asks_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    monkeypatch.setenv("P2OS_BUS", private_bus())
    (tmp_path / "say.py").write_text("def main(team):\n    print('here')\n    team.sleep(60.0)\n", encoding="utf-8")
    saying = [sys.executable, "-m", "acromovi", "run", "say.py"]
    with subprocess.Popen(saying, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert next(line for line in process.stdout if "here" in line)
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130


def test_a_copy_that_is_killed_is_seen_to_be_killed() -> None:
    with subprocess.Popen(EMULATOR, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.kill()
        end_of(process)
    assert process.returncode == -signal.SIGKILL


def test_programs_begin_without_the_server_when_it_has_died_and_with_another_one_afterwards(forks: Forks) -> None:
    run(LISTING)
    first = forks.server
    os.kill(first, signal.SIGKILL)
    assert run(LISTING).returncode == 0
    assert run(LISTING).returncode == 0
    assert forks.server != first


def test_what_a_program_leaves_behind_is_not_adopted() -> None:
    # What is left behind holds none of the pipes to which its parent prints, or nobody would see the parent end.
    leaving = (
        "import subprocess, sys; nothing = subprocess.DEVNULL; "
        "print(subprocess.Popen([sys.executable, '-c', 'input()'], stdin=0, stdout=nothing, stderr=nothing).pid)"
    )
    reader, writer = os.pipe()
    run(LISTING)  # by the server, whose copies are adopted
    left = int(run([sys.executable, "-c", leaving], stdin=reader).stdout)
    os.close(reader)

    def parent() -> int:
        return int(Path(f"/proc/{left}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[1])

    wait_until(lambda: parent() != os.getpid())
    os.close(writer)


def test_a_folder_that_is_not_there_is_told_as_ever(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        subprocess.run(LISTING, cwd=tmp_path / "nowhere", check=False)  # it does not begin


def test_programs_that_begin_as_copies_are_those_of_the_distribution() -> None:
    assert set(PACKAGES) == {"acromovi", "gateway", "p2os_emu"}

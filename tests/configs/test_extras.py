"""Which extras are installed, and the command that installs them from where this installation came."""

import importlib.metadata
import json
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from acromovi.doctor import examine
from configs.extras import EXTRAS, ExtraMissing, install_command, missing, require
from tests.waiting import run

ROOT = Path(__file__).resolve().parents[2]
MAIN = """
import sys

sys.modules[{module!r}] = None
from {program}.__main__ import main

sys.exit(main({arguments!r}))
"""


@pytest.fixture
def comes_from(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Sets where pip says that this distribution came from; nothing for an index."""

    class Found:
        def __init__(self, origin: object) -> None:
            self.read_text = lambda name: None if origin is None else json.dumps(origin)

    def set_origin(origin: object) -> None:
        monkeypatch.setattr(importlib.metadata, "distribution", lambda name: Found(origin))

    return set_origin


@pytest.mark.parametrize(
    ("origin", "given"),
    [
        ({"url": "file:///home/ann/my%20robots", "dir_info": {"editable": True}}, "-e '/home/ann/my robots[emu]'"),
        ({"url": "file:///home/ann/acromovi", "dir_info": {}}, "'/home/ann/acromovi[emu]'"),
        ({"url": "file:///tmp/a.whl", "archive_info": {"hash": "sha256=0"}}, "'acromovi[emu] @ file:///tmp/a.whl'"),
        (
            {"url": "https://example.org/a.git", "vcs_info": {"vcs": "git", "commit_id": "abc"}},
            "'acromovi[emu] @ git+https://example.org/a.git@abc'",
        ),
        (None, "'acromovi[emu]'"),
    ],
)
def test_an_extra_is_installed_from_where_the_distribution_came(
    comes_from: Callable[..., None], origin: object, given: str
) -> None:
    comes_from(origin)
    assert install_command("emu") == f"{sys.executable} -m pip install {given}"


def test_a_checkout_that_is_not_installed_is_what_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    def not_found(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "distribution", not_found)
    assert install_command("emu", "plots").endswith(f"pip install -e '{ROOT}[emu,plots]'")


def test_extras_of_the_table_are_those_of_the_distribution() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert EXTRAS.keys() == declared.keys() - {"all"}


def test_an_extra_is_missing_when_one_of_its_modules_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    assert missing("emu", "plots") == ["emu"]
    require("a picture", "plots")
    with pytest.raises(ExtraMissing, match=r"^a demo needs the extra emu, not installed here; install with: .*emu\]'$"):
        require("a demo", "emu", "plots")


@pytest.mark.parametrize(
    ("module", "program", "line", "says"),
    [
        ("pybullet", "p2os_emu", "--robot powerbot", "p2os-emu: the emulator needs the extra emu"),
        ("pybullet", "p2os_emu", "--check nothing.jsonl", "p2os-emu: the emulator needs the extra emu"),
        ("pybullet", "acromovi", "up acromovi", "acromovi up: a team with emulated robots needs the extra emu"),
        ("pybullet", "acromovi", "demo", "acromovi demo: the demo needs the extra emu"),
        ("matplotlib", "acromovi", "demo", "acromovi demo: the demo needs the extra plots"),
        ("pybullet", "acromovi", "try gripper", "acromovi try: a scene needs the extra emu"),
        ("pybullet", "acromovi", "missions --smoke", "acromovi: the emulator needs the extra emu"),
        ("matplotlib", "acromovi", "missions --all", "acromovi missions: a picture of missions needs the extra plots"),
        ("mcap", "acromovi", "record", "acromovi record: recording needs the extra recorder"),
        ("mcap", "acromovi", "replay drive.mcap", "acromovi replay: replaying needs the extra recorder"),
        ("cryptography", "acromovi", "keys list", "acromovi keys: making keys needs the extra security"),
    ],
)
def test_a_command_without_its_extra_says_in_one_sentence_what_to_install(
    module: str, program: str, line: str, says: str, tmp_path: Path
) -> None:
    text = MAIN.format(module=module, program=program, arguments=line.split())
    environment = {"PYTHONPATH": str(ROOT), "HOME": str(tmp_path)}
    done = run([sys.executable, "-c", text], 60.0, cwd=tmp_path, env=environment)
    assert done.returncode in (1, 5)
    assert done.stderr.startswith(f"{says}, not installed here; install with: {sys.executable} -m pip install ")
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""


def test_doctor_notes_extras_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    found = {finding.check: finding for finding in examine(None, "local") if finding.check.startswith("extra ")}
    assert found.keys() == {f"extra {extra}" for extra in EXTRAS}
    assert found["extra plots"].label == "OK"
    assert found["extra emu"].label == "NOTE"
    assert found["extra emu"].found == "not installed, needed for the emulator"
    assert found["extra emu"].advice == f"install with {install_command('emu')}"

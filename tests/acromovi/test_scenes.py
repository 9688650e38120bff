"""Every scene of `acromovi try`, played as a person would; and the page that points to them."""

import re
import shlex
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.scenes.all_scenes import SCENES
from p2os_emu.options import parse

PAGE = (Path(__file__).parents[2] / "docs" / "accessories.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", SCENES)
def test_scene_shows_what_it_promises(
    name: str, capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # for what a scene leaves behind
    code = main(["try", name])
    heard = capfd.readouterr()
    assert code == 0, heard.err
    assert heard.out.startswith(f"-- {name}: ")
    assert len(heard.out.splitlines()) > 2, "it says nothing of what happens"


def test_scenes_are_listed_and_a_wrong_name_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["try"]) == 0
    assert set(SCENES) == {line.split()[0] for line in capsys.readouterr().out.splitlines()}
    assert main(["try", "griper"]) == 2
    assert "gripper" in capsys.readouterr().err


def test_page_of_accessories_shows_every_scene_and_none_that_is_not_there() -> None:
    assert set(re.findall(r"`acromovi try ([\w-]+)`", PAGE)) - {"NAME"} == set(SCENES)


def test_emulator_lines_of_the_page_are_understood() -> None:
    lines = re.findall(r"`p2os-emu ((?:-m office )?-[rR-][^`]*p3[^`]*|--robot power[^`]*)`", PAGE)
    assert len(lines) > 20
    for line in lines:
        parse(shlex.split(line))

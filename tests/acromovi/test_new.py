"""A new application: written once, and sound as it is."""

from pathlib import Path

import pytest

from acromovi.__main__ import main
from agents.client.program import RunningApplication


def test_a_new_application_is_one_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "patrol"]) == 0
    assert capsys.readouterr().out == "wrote patrol.py; run it with: acromovi run patrol.py\n"
    text = Path("patrol.py").read_text()
    assert "acromovi run patrol.py robot=happy" in text
    assert "acromovi ask patrol@apps turns" in text
    program = RunningApplication.find("patrol.py")
    program.check({"robot": "happy", "speed": 0.3})
    assert program.services == ("patrol",)


def test_what_is_there_is_not_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("patrol.py").write_text("mine")
    assert main(["new", "patrol.py"]) == 1
    assert "there is such a file already; choose another name" in capsys.readouterr().err
    assert Path("patrol.py").read_text() == "mine"


def test_what_cannot_name_an_application_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["new", "my patrol"])
    assert caught.value.code == 2
    assert "'my patrol' is no name for an application" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["class", "queue", "queue.py"])
def test_words_of_python_name_no_application(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        main(["new", name])
    assert f"'{name}' is a word of Python's own; choose another name" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())

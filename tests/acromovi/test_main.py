"""What all commands of `acromovi` have in common."""

import subprocess
import sys

import pytest

from acromovi.__main__ import COMMANDS, main


@pytest.mark.parametrize("command", ["ps", "topics", "directory", "router"])
def test_what_a_command_does_not_take_is_told_in_its_name(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main([command, "--nonsense"])
    assert caught.value.code == 2
    told = f"acromovi {command}: error: unrecognized arguments: --nonsense; acromovi {command} --help lists all\n"
    assert capsys.readouterr().err == told


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["leases", "--audit", "x"], "x is not a positive whole number"),
        (["leases", "--audit", "0"], "0 is not a positive whole number"),
        (["sniff", "--seconds", "x"], "x is not a positive number of seconds"),
        (["sniff", "--seconds", "nan"], "nan is not a positive number of seconds"),
    ],
)
def test_what_is_no_number_is_told(words: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == 2
    assert why in capsys.readouterr().err


def test_a_reader_that_has_gone_is_no_error() -> None:
    listing = [sys.executable, "-m", "acromovi", "ps"]
    with subprocess.Popen(listing, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as shown:
        assert shown.stdout is not None
        assert shown.stderr is not None
        shown.stdout.close()
        assert shown.stderr.read() == ""
    assert shown.returncode == 0


def test_every_command_has_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    for command in COMMANDS:
        with pytest.raises(SystemExit) as caught:
            main([command, "--help"])
        assert caught.value.code == 0
        assert capsys.readouterr().out.startswith(f"usage: acromovi {command} ")

"""What all commands of `acromovi` have in common."""

import argparse
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.metadata import version

import pytest

from acromovi.__main__ import COMMANDS, main
from gateway.__main__ import main as gateway
from p2os_emu.__main__ import main as emulator


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


@pytest.mark.parametrize(("name", "program"), [("acromovi", main), ("p2os-gateway", gateway), ("p2os-emu", emulator)])
def test_every_program_has_its_version(
    name: str, program: Callable[[list[str]], int], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        program(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out == f"{name} {version('acromovi')}\n"


@pytest.mark.parametrize(
    "line",
    [
        "ask base@happy move --timeout 3 distance=1",
        "ask --timeout 3 base@happy --json move distance=1 --bus local speed=0.2",
        "command happy --timeout 3 move distance=1",
        "agent start follow@happy follow:Follow --in workshop robot=happy",
        "agent start --json follow@happy follow:Follow robot=happy --in workshop speed=1",
        "run wander --bus local robot=happy",
        "promote wander --name a --bus local robot=happy",
        "sniff base@happy --json sonar@happy",
    ],
)
def test_options_stand_before_and_after_key_value_arguments(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    words = line.split()
    taken: list[argparse.Namespace] = []

    def run(arguments: argparse.Namespace) -> int:
        taken.append(arguments)
        return 0

    module = import_module(COMMANDS[words[0]][0])
    monkeypatch.setattr(module, "COMMAND", replace(module.COMMAND, run=run))
    assert main(words) == 0
    assert len(taken) == 1

"""Shells complete the commands, options and values that the parsers have."""

import shutil
import subprocess
from pathlib import Path

import pytest

from acromovi.__main__ import COMMANDS, main
from acromovi.completion import SHELLS, words_of
from acromovi.subcommand import add_subcommands
from configs.command_line import CommandParser

CASES = [
    ("acromovi re", {"record", "remote-vision", "replay"}),
    ("acromovi record --sp", {"--split-size", "--split-time"}),
    ("acromovi keys make --role ", {"admin", "operator", "robot", "router", "viewer"}),
    ("acromovi world do", {"door", "doors"}),
    ("acromovi completion ", {"bash", "fish", "zsh"}),
]
ASK = {
    "bash": 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _acromovi; '
    'printf "%s\\n" "${COMPREPLY[@]}"',
    "zsh": "compdef() { }; _files() { }; _describe() { for each in ${(P)2}; do [[ $each == $words[CURRENT]* ]] && "
    'print -r -- ${each%%:*}; done }; source "$1"; shift; words=("$@"); CURRENT=$#; _acromovi',
    "fish": 'source $argv[1]; complete -C "$argv[2..]" | string replace -r "\\t.*" ""; true',
}


@pytest.fixture(scope="module")
def parser() -> CommandParser:
    made = CommandParser(prog="acromovi", allow_abbrev=False)
    add_subcommands(made, "command", COMMANDS)
    return made


@pytest.fixture(scope="module")
def scripts(parser: CommandParser, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scripts")
    found = list(words_of(parser))
    for shell, script in SHELLS.items():
        (folder / shell).write_text(script(found))
    return folder


def test_every_command_has_its_options(parser: CommandParser) -> None:
    found = {each.path: each for each in words_of(parser)}
    assert found["acromovi"].commands.keys() == COMMANDS.keys()
    assert {f"acromovi {name}" for name in COMMANDS} <= found.keys()
    assert "--bus" in found["acromovi echo"].options
    assert found["acromovi missions"].values["--case"] == ["room", "corridor", "rooms"]


def test_it_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bash"]) == 0
    assert capsys.readouterr().out.startswith("# Completion of acromovi for bash")


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(("line", "expected"), CASES)
def test_a_shell_completes(shell: str, line: str, expected: set[str], scripts: Path) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    words = [line] if shell == "fish" else line.split(" ")
    extra = ["-"] if shell == "bash" else ["zsh"] if shell == "zsh" else []
    command = [shell, "-c", ASK[shell], *extra, str(scripts / shell), *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = {each for each in done.stdout.split() if not each.startswith("-") or "--" in line}
    assert found == expected

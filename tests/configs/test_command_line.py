"""The parser of all programs."""

from importlib.metadata import version

import pytest

from configs.command_line import CommandParser


def parser() -> CommandParser:
    """`tool [--speed S] {ask [--timeout S] NAME [WORD ...], list [--json]}`."""
    made = CommandParser(prog="tool", allow_abbrev=False)
    made.add_version()
    commands = made.add_subparsers(dest="command", required=True)
    ask = commands.add_parser("ask", allow_abbrev=False)
    ask.add_argument("name")
    ask.add_argument("words", nargs="*", default=())
    ask.add_argument("--timeout", type=float, default=1.0)
    ask.add_argument("--json", action="store_true")
    commands.add_parser("list", allow_abbrev=False).add_argument("--json", action="store_true")
    return made


@pytest.mark.parametrize(
    "line",
    [
        "--timeout 3 --json happy a=1 b=2",
        "happy --timeout 3 a=1 --json b=2",
        "happy a=1 --timeout 3 b=2 --json",
        "happy a=1 b=2 --timeout 3 --json",
        "happy --json a=1 b=2 --timeout=3",
    ],
)
def test_options_are_accepted_anywhere(line: str) -> None:
    given = parser().parse_args(["ask", *line.split()])
    assert (given.command, given.name, list(given.words)) == ("ask", "happy", ["a=1", "b=2"])
    assert (given.timeout, given.json) == (3.0, True)


def test_repeated_arguments_may_be_left_out() -> None:
    given = parser().parse_args(["ask", "--json", "happy"])
    assert (given.name, list(given.words), given.timeout, given.json) == ("happy", [], 1.0, True)


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("ask happy --tiemout 3", "unrecognized arguments: --tiemout 3; did you mean --timeout?"),
        ("list --jsn", "unrecognized arguments: --jsn; did you mean --json?"),
        ("list --tiemout=3", "did you mean --timeout?"),  # of another command: better than nothing
        ("list --qwxyz", "unrecognized arguments: --qwxyz\n"),
        ("lits", "invalid choice: 'lits' (choose from 'ask', 'list'); did you mean list?"),
        ("ask", "the following arguments are required: name"),
    ],
)
def test_what_is_misspelt_is_told_with_a_suggestion(line: str, error: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        parser().parse_args(line.split())
    assert caught.value.code == 2
    assert error in capsys.readouterr().err


def test_the_version_is_that_of_the_distribution(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        parser().parse_args(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out == f"tool {version('acromovi')}\n"

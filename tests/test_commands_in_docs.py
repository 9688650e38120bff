"""Every command line in the documentation has options that its program takes; every file and link in it is valid."""

import ast
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from acromovi import __main__ as acromovi
from gateway import __main__ as gateway
from p2os_emu.options import parse as parse_emulator
from tests.live_team import ROOT
from tests.reader import blocks

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
LINKING = [*PAGES, *sorted(ROOT.glob("[AGP]*.md")), ROOT / "pty_tests/README.md", *(ROOT / "examples").glob("*/*.md")]
PARSERS: dict[str, Callable[[list[str]], object]] = {
    "acromovi": lambda given: acromovi._parser().parse_args(given),
    "p2os-emu": parse_emulator,
    "p2os-gateway": lambda given: gateway.parse_arguments(given),
}
NO_COMMAND_LINE = re.compile(r"\b(?!SIM_)[A-Z]{3,}\b|\.\.\.|…|--help$|^acromovi (agent|navigate) \w+$")
"""What has placeholders such as LASERPORT, ends before it does anything, or is the name of a command."""
FENCED = re.MULTILINE | re.DOTALL
BLOCKS = [(page.name, language, text) for page in PAGES for language, text in blocks(page.read_text(encoding="utf-8"))]


def command_lines() -> list[tuple[str, str]]:
    """Return page and command line, without prompt, folder and comment."""
    lines = [(page, line) for page, language, text in BLOCKS if not language for line in text.splitlines()]
    bare = [(page, re.split(r"\s{3,}| #", re.sub(r"^(\$ )?(\.venv/bin/)?", "", line))[0]) for page, line in lines]
    is_error = re.compile(r"\S+ \w+: ")  # what a program prints, not what is typed
    return [
        (page, line)
        for page, line in [*bare, *in_sentences()]
        if line.split(" ")[0] in PARSERS and not is_error.match(line)
    ]


def in_sentences() -> list[tuple[str, str]]:
    """Return page and command line of the code in sentences and tables, without names of commands and placeholders."""
    prose = [(page.name, re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=FENCED)) for page in PAGES]
    code = [(page, code) for page, text in prose for code in re.findall(r"`([^`\n]+)`", text)]
    return [(page, line) for page, line in code if line.count(" ") > 1 and not NO_COMMAND_LINE.search(line)]


def test_there_are_command_lines_of_every_program() -> None:
    assert {line.split()[0] for _, line in command_lines()} == PARSERS.keys()


@pytest.mark.parametrize(("page", "line"), command_lines())
def test_a_command_line_has_arguments_that_its_program_takes(page: str, line: str) -> None:
    program, *arguments = shlex.split(line)
    PARSERS[program](arguments)  # exits, with a message, where it does not


@pytest.mark.parametrize(("page", "language", "text"), [block for block in BLOCKS if block[1] in ("toml", "python")])
def test_a_file_is_valid(page: str, language: str, text: str) -> None:
    if language == "toml":
        tomllib.loads(text)
    else:
        compile(text, page, "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)  # some show what stands in a method


@pytest.mark.parametrize("page", LINKING, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings_that_are_there(page: Path) -> None:
    for target, heading in re.findall(r"\]\((?!http)([^)#]*)(?:#([^)]*))?\)", page.read_text(encoding="utf-8")):
        file = page.parent / target if target else page
        assert file.exists(), target
        assert not heading or heading in headings(file), f"{target}#{heading}"


def headings(page: Path) -> set[str]:
    """Return the headings of a page as links name them."""
    titles = re.findall(r"^#+ (.*)", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}

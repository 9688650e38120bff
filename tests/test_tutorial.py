"""The tutorial, done as it says: each of its files written, each command typed and each output compared, in order.

A block in TOML or Python is a file, whose first line tells its name; one without a language is what is typed; one of
text is what the terminal shows then, where `...` stands for anything, and a line of it for any lines.
"""

import re
import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import pytest

from agents.face.element import Element
from agents.face.picture import Picture
from agents.face.robot import ELEMENTS
from tests.live_team import LIMIT, ROOT, LiveTeam, environment, own_bus

TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```", TUTORIAL, re.MULTILINE | re.DOTALL)
LEFT_OPEN = ("up", "promote")  # in terminals of their own
ENDED_BY_HAND = ("run",)  # with Ctrl-C, as soon as they show what they are to


class Reader:
    """Someone who does what the page says. open: what still runs, by the command's name."""

    def __init__(self, desk: LiveTeam) -> None:
        self.open: dict[str, subprocess.Popen[bytes]] = {}
        self._desk = desk
        self._latest: subprocess.Popen[bytes] | None = None

    def write(self, text: str) -> None:
        """Save a file."""
        name = text.partition("\n")[0].removeprefix("# ")
        (self._desk.folder / name).write_text(text, encoding="utf-8")

    def type(self, lines: str) -> None:
        """Type commands, each when the one before has ended."""
        self._shown = self._desk.folder / f"shown-{time.monotonic_ns()}"
        for line in lines.splitlines():
            _, what, *_ = words = line.split()
            self.open[what] = self._latest = self._begin(words)
            if what not in (*LEFT_OPEN, *ENDED_BY_HAND):
                self.open.pop(what).wait(LIMIT)

    def see(self, expected: str) -> None:
        """Wait until the terminal shows this."""
        assert self._latest is not None, "nothing has been typed"
        deadline, goes_on = time.monotonic() + LIMIT, True
        while not looks_like(expected, shown := self._shown.read_text(encoding="utf-8")):
            assert goes_on, f"expected:\n{expected}\nshown:\n{shown}"
            goes_on = self._latest.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        for what in ENDED_BY_HAND:
            if what in self.open:
                assert self.end(what) == 130, self._shown.read_text()

    def end(self, what: str) -> int:
        """Press Ctrl-C; returns the exit code."""
        process = self.open.pop(what)
        process.send_signal(signal.SIGINT)
        try:
            return process.wait(LIMIT)
        finally:
            process.kill()

    def _begin(self, words: list[str]) -> "subprocess.Popen[bytes]":
        with self._shown.open("ab") as shown:
            return subprocess.Popen(
                self._desk.command(words),
                cwd=self._desk.folder,
                env={**environment(), "PYTHONUNBUFFERED": "1"},
                stdout=shown,
                stderr=subprocess.STDOUT,
            )


def looks_like(expected: str, shown: str) -> bool:
    """Whether a terminal shows what the page says."""
    pattern = ""
    for line in expected.splitlines():
        words = [re.escape(part) for part in line.split("...")]
        pattern += r"(?:.*\n)*" if line == "..." else ".*".join(words) + r"\n"
    return re.fullmatch(pattern, shown) is not None


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[Reader]:
    reader = Reader(own_bus(tmp_path))
    yield reader
    for what in reversed(list(reader.open)):
        reader.end(what)


def test_the_tutorial_can_be_followed(reader: Reader) -> None:
    do = {"toml": reader.write, "python": reader.write, "": reader.type, "text": reader.see}
    for language, text in BLOCKS:
        do[language](text)
    assert reader.open.pop("promote").wait(LIMIT) == 0  # the page has stopped it
    assert reader.end("up") == 130


@pytest.mark.parametrize(
    ("expected", "shown", "is_alike"),
    [
        ("x is ... m\n", "x is 1.5 m\n", True),
        ("x is ... m\n", "x is 1.5\ny is 2 m\n", False),
        ("...\nend\n", "end\n", True),
        ("...\nend\n", "a\nb\nend\n", True),
        ("...\nend\n", "end\nmore\n", False),
        ("f(x)\n", "fx\n", False),
    ],
)
def test_outputs_are_compared_line_by_line(expected: str, shown: str, is_alike: bool) -> None:
    assert looks_like(expected, shown) is is_alike


@pytest.mark.parametrize("part", ELEMENTS)
def test_the_table_lists_all_that_a_part_tells_and_does(part: str) -> None:
    kind = ELEMENTS[part]
    told = [each.name for each in fields(kind.reading)] + _public(kind.reading)
    done = [name for cls in kind.__mro__ if cls not in Element.__mro__ for name in _public(cls)]
    (row,) = re.findall(rf"^\| `{part}` \|.*", TUTORIAL, re.MULTILINE)
    _, _, has, does, _ = row.split("|")
    assert set(re.findall(r"`(\w+)`", has)) == set(told) - {"of", "stamp", "result"}
    assert set(re.findall(r"`(\w+)`", does)) - set(_public(Picture)) == set(done) - {"reading"}


@pytest.mark.parametrize("target", re.findall(r"\]\((?!http)([^)]+)\)", TUTORIAL))
def test_links_lead_somewhere(target: str) -> None:
    assert (ROOT / "docs" / target).exists()


def _public(cls: type) -> list[str]:
    return [name for name in vars(cls) if not name.startswith("_")]

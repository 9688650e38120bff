"""A reader who follows a page of the documentation: writes its files, types its commands and compares the outputs.

A block in TOML or Python is a file, whose first line is its name; one without a language is what is typed; one of text
is what the terminal shows then, where `...` stands for anything, and a line of it for any lines.
"""

import re
import shlex
import signal
import subprocess
import time
from pathlib import Path

from tests.live_team import LIMIT, LiveTeam, environment
from tests.waiting import Deadline, exit_code

LEFT_OPEN = ("up", "promote", "container")  # in terminals of their own
ENDED_BY_HAND = ("run",)  # with Ctrl-C, as soon as they show the expected output


class Reader:
    """Does what a page says, block by block.

    open: the programs that still run, by their command lines.
    """

    def __init__(self, place: LiveTeam) -> None:
        self.open: dict[str, subprocess.Popen[bytes]] = {}
        self._screens: dict[str, Path] = {}  # what each of them shows
        self._place = place
        self._latest: subprocess.Popen[bytes] | None = None

    def follow(self, page: str) -> None:
        """Do all blocks of a page, in order."""
        do = {"toml": self.write, "python": self.write, "": self.type, "text": self.see}
        for language, text in blocks(page):
            do[language](text)

    def write(self, text: str) -> None:
        """Save a file."""
        name = text.partition("\n")[0].removeprefix("# ")
        (self._place.folder / name).write_text(text, encoding="utf-8")

    def type(self, lines: str) -> None:
        """Type commands, each when the one before has ended."""
        self._shown = self._place.folder / f"shown-{time.monotonic_ns()}"
        for line in lines.splitlines():
            self._screens[line] = self._shown
            self.open[line] = self._latest = self._begin(shlex.split(line))
            if line.split()[1] not in (*LEFT_OPEN, *ENDED_BY_HAND):
                exit_code(self.open.pop(line), LIMIT)

    def see(self, expected: str) -> None:
        """Wait until the terminal shows this."""
        assert self._latest is not None, "nothing has been typed"
        deadline, goes_on = Deadline(LIMIT), True
        while not looks_like(expected, shown := self._shown.read_text(encoding="utf-8")):
            assert goes_on, f"expected:\n{expected}\nshown:\n{shown}\n{self._others()}"
            goes_on = self._latest.poll() is None and not deadline.has_passed()
            time.sleep(0.05)
        for line in [line for line in self.open if line.split()[1] in ENDED_BY_HAND]:
            assert self.end(line) == 130, self._shown.read_text()

    def end(self, line: str) -> int:
        """Press Ctrl-C in the terminal of this command; return the exit code."""
        process = self.open.pop(line)
        process.send_signal(signal.SIGINT)
        try:
            return exit_code(process, LIMIT)
        finally:
            process.kill()

    def leave(self) -> None:
        """Press Ctrl-C in all terminals, the last opened first."""
        for line in reversed(list(self.open)):
            self.end(line)

    def _others(self) -> str:
        """What the other terminals show; a program that is not there may have said why it ended."""
        screens = {line: self._screens[line] for line in self.open if self._screens[line] != self._shown}
        return "\n".join(f"{line}:\n{screen.read_text(encoding='utf-8')}" for line, screen in screens.items())

    def _begin(self, words: list[str]) -> "subprocess.Popen[bytes]":
        with self._shown.open("ab") as shown:
            return subprocess.Popen(
                self._place.command(words),
                cwd=self._place.folder,
                env={**environment(), "PYTHONUNBUFFERED": "1"},
                stdout=shown,
                stderr=subprocess.STDOUT,
            )


def blocks(page: str) -> list[tuple[str, str]]:
    """Return the code blocks of a page: language and text."""
    return re.findall(r"^```(\w*)\n(.*?)^```", page, re.MULTILINE | re.DOTALL)


def links(page: Path) -> list[Path]:
    """Return the files to which a page links."""
    targets = re.findall(r"\]\((?!http)([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    return [page.parent / target for target in targets]


def looks_like(expected: str, shown: str) -> bool:
    """Return whether a terminal shows what the page says."""
    pattern = ""
    for line in expected.splitlines():
        words = [re.escape(part) for part in line.split("...")]
        pattern += r"(?:.*\n)*" if line == "..." else ".*".join(words) + r"\n"
    return re.fullmatch(pattern, shown) is not None

"""Applications that the console can start: which there are, what they take, and those that run."""

import ast
import asyncio
import json
import os
import sys
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import apps
from agents.wrappers.program import die_with

_MOST_LINES = 500  # of the output of one run
_MOST_RUNS = 20  # that are remembered, and all that have not ended
_LONGEST_LINE = 1000  # characters
_ENDING = 30.0  # s that an application has to end; its robots stand at once, and then it may draw what it has recorded
_CLOSING = 5.0  # s likewise when the console itself ends


@dataclass(frozen=True, slots=True)
class KnownApplication:
    """An application that can be started.

    name: as `acromovi run` takes it. about: the first line of its `main`. parameters: of `main` beside the team, with
    their usual values as they are written.
    """

    name: str
    about: str
    parameters: Mapping[str, str]


@dataclass(slots=True, eq=False)
class ApplicationRun:
    """One run.

    number: counts the runs. name, words: what was started. lines: the newest ones of its output. line_count: of all.
    process: None before it has begun. is_stopping: whether it was told to end. code: its exit code; None while it runs.
    """

    number: int
    name: str
    words: Sequence[str]
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=_MOST_LINES))
    line_count: int = 0
    process: asyncio.subprocess.Process | None = None
    is_stopping: bool = False
    code: int | None = None

    @property
    def is_running(self) -> bool:
        """Whether it has not ended."""
        return self.code is None

    def add(self, line: str) -> None:
        """Add a line of its output."""
        self.lines.append(line[:_LONGEST_LINE])
        self.line_count += 1


class ApplicationRuns:
    """The applications that were started from the console; they end with it. runs: the newest last."""

    def __init__(self, bus: str, folder: str, folders: Sequence[Path]) -> None:
        """Begin without a run.

        Args:
            bus: Profile of the bus.
            folder: Where they write.
            folders: With applications, beside those of the product.
        """
        self.runs: list[ApplicationRun] = []
        self._bus, self._folder, self._folders = bus, folder, folders
        self._count = 0
        self._reading: set[asyncio.Task[None]] = set()

    def known(self) -> list[KnownApplication]:
        """Return the applications that can be started, by name; nothing is imported."""
        found = {app.name: app for app in _in_folder(Path(apps.__path__[0]), is_package=True)}
        for folder in self._folders:
            found |= {app.name: app for app in _in_folder(folder, is_package=False)}
        return [found[name] for name in sorted(found)]

    async def start(self, name: str, arguments: Mapping[str, str]) -> ApplicationRun:
        """Start an application.

        Args:
            name: One of `known`.
            arguments: Of `main`, as text; JSON, or text where it is no JSON.
        Raises:
            ValueError: There is no such application, or it does not take these arguments.
        """
        app = next((each for each in self.known() if each.name == name), None)
        if app is None:
            raise ValueError(f"there is no application {name!r}")
        if strange := sorted(arguments.keys() - app.parameters.keys()):
            raise ValueError(f"{name} does not take {', '.join(strange)}")
        words = [f"{key}={value}" for key, value in arguments.items()]
        self._count += 1
        run = ApplicationRun(self._count, name, words)
        options = [word for folder in self._folders for word in ("--apps", str(folder))]
        run.process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-u", "-m", "acromovi", "run", name, *words, *options, "--bus", self._bus),
            cwd=self._folder,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            preexec_fn=partial(die_with, os.getpid()) if sys.platform == "linux" else None,
        )
        ended = [each for each in self.runs if not each.is_running]
        forgotten = ended[: max(0, len(self.runs) + 1 - _MOST_RUNS)]
        self.runs = [*(each for each in self.runs if each not in forgotten), run]
        reading = asyncio.ensure_future(_read(run, run.process))
        self._reading.add(reading)
        reading.add_done_callback(self._reading.discard)
        return run

    async def stop(self, run: ApplicationRun, within: float = _ENDING) -> None:
        """Stop an application as Ctrl-C does: its robots stop, and it ends; within: s, after which it is killed."""
        process = run.process
        if process is None or process.returncode is not None:
            return
        if not run.is_stopping:
            run.is_stopping = True
            process.terminate()
        try:
            async with asyncio.timeout(within):
                await process.wait()
        except TimeoutError:
            run.add(f"it has not ended within {within:g} s and was killed")
            self.kill(run)
            await process.wait()

    def kill(self, run: ApplicationRun) -> None:
        """End an application at once, for somebody who does not want to wait; what it has not written yet is lost."""
        if run.process is not None and run.process.returncode is None:
            run.process.kill()

    async def close(self) -> None:
        """Stop all of them."""
        await asyncio.gather(*(self.stop(run, _CLOSING) for run in self.runs))
        await asyncio.gather(*self._reading, return_exceptions=True)  # the programs have ended, and so do their pipes


async def _read(run: ApplicationRun, process: asyncio.subprocess.Process) -> None:
    """Read the output of a run until it has ended."""
    assert process.stdout is not None
    rest = b""
    while data := await process.stdout.read(1 << 14):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            run.add(line.decode(errors="replace"))  # what a program prints may be anything
        rest = rest[-4 * _LONGEST_LINE :]
    if rest:
        run.add(rest.decode(errors="replace"))  # likewise
    run.code = await process.wait()


def _in_folder(folder: Path, *, is_package: bool) -> Iterator[KnownApplication]:
    """Find files with a function `main(team)`, and in the package of the product folders with one as well."""
    for path in sorted(folder.iterdir()):
        file = path if path.suffix == ".py" else path / "application.py"
        is_found = file.is_file() and path.stem.isidentifier() and (is_package or file is path)
        if is_found and (main := _main_of(file)) is not None:
            yield _described(path.stem, main)


def _main_of(file: Path) -> ast.FunctionDef | None:
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, OSError):
        return None  # it cannot be started either
    found = (node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "main")
    return next((node for node in found if node.args.args), None)


def _described(name: str, main: ast.FunctionDef) -> KnownApplication:
    names = [argument.arg for argument in (*main.args.args, *main.args.kwonlyargs)][1:]
    values: list[ast.expr | None] = [*main.args.defaults, *main.args.kw_defaults]
    usual = dict(zip(reversed(names), reversed(values), strict=False))
    parameters = {each: _as_argument(usual.get(each)) for each in names}
    return KnownApplication(name, (ast.get_docstring(main) or "").partition("\n")[0], parameters)


def _as_argument(value: ast.expr | None) -> str:
    """Return a usual value as a person would write it: text as it is, everything else in JSON."""
    try:
        found: Any = ast.literal_eval(value) if value is not None else ""
    except ValueError:  # not a constant
        return ""
    if isinstance(found, str):
        return found
    try:
        return "" if found is None else json.dumps(found)
    except TypeError:
        return ""

"""Make `.venv`, or complete it: `python3 tools/make_venv.py demo|all`. Called by make; uses the standard library only.

`demo` is what `make demo` needs, `all` adds the other extras and the development tools. It prints what is installed,
how large that is and how far it has come: in a terminal on one line, elsewhere a line for each large package.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OLDEST, NEWEST = (3, 11), (3, 13)
MB = 1e6  # bytes
LARGE = 5.0  # MB of a download from which on it gets a line of its own where there is no terminal
UNUSED = ("pybullet_data", "pybullet_envs", "pybullet_examples", "pybullet_robots", "pybullet_utils")
"""Example models and programs in the wheel of PyBullet, 150 MB, which Acromovi never opens."""
PARTS_UNUSED = (
    "numpy/**/tests",
    "matplotlib/tests",
    "apsw/tests",
    "nicegui/elements/plotly/dist",
    "nicegui/elements/mermaid/dist",
)
"""Parts of packages, 40 MB: their own tests, and scripts of elements that no page has."""
UNITS = {"bytes": 1e-6, "kB": 1e-3, "MB": 1.0, "GB": 1e3}
DOWNLOADING = re.compile(r"\s*Downloading (\S+?)-\d\S*(?: \(([\d.]+) (bytes|kB|MB|GB)\))?")


@dataclass(frozen=True)
class Install:
    """What one call of pip installs.

    what: for people. arguments: of pip. download, disk: MB, measured with the versions in constraints.txt.
    """

    what: str
    arguments: tuple[str, ...]
    download: int
    disk: int


INSTALLS = {
    "demo": Install("the emulator, the gateway, the agents and the console", ("-e", ".[emu,plots,console]"), 185, 490),
    "all": Install("all extras and the development tools", ("--group", "dev", "-e", ".[all]"), 360, 1050),
}


@dataclass
class Progress:
    """What pip has done so far, read from its output.

    packages: that were found. done: MB of the downloads that have ended. part: MB of the current one.
    """

    packages: int = 0
    done: float = 0.0
    part: float = 0.0
    current: str = ""
    step: str = "looking for packages"
    _size: float = field(default=0.0, repr=False)

    def read(self, line: str) -> str | None:
        """Take a line of pip's output; return a sentence if it begins something worth a line of its own."""
        if line.startswith("Collecting "):
            self.packages += 1
        elif line.startswith("Progress "):
            self.part = int(line.split()[1]) / MB
        elif found := DOWNLOADING.match(line):
            self._end_download()
            name, size, unit = found.groups()
            self._size = float(size) * UNITS[unit] if size else 0.0
            self.current = name.replace("_", "-")
            self.step = f"downloading {self.current}"
            return f"downloading {self.current}, {self._size:.0f} MB" if self._size >= LARGE else None
        elif line.startswith("Installing collected packages: "):
            self._end_download()
            count = line.count(",") + 1
            self.step = f"writing {count} packages"
            return f"writing {count} packages"
        return None

    def line(self, expected: int) -> str:
        """Return how far it is, in one line; expected: MB of all downloads together."""
        return f"{self.done + self.part:.0f} of about {expected} MB, {self.packages} packages: {self.step}"

    def _end_download(self) -> None:
        self.done += self._size
        self.part = self._size = 0.0


def main(arguments: Sequence[str]) -> int:
    """Make or complete the environment; return pip's exit code."""
    (which,) = arguments
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        print("Acromovi needs Python 3.11, 3.12 or 3.13; name one with: make PYTHON=python3.12", file=sys.stderr)
        return 1
    venv = Path(os.environ.get("VENV", ROOT / ".venv")).absolute()
    stamps = {"demo": venv / ".demo", "all": venv / ".ready"}
    current = [name for name, stamp in stamps.items() if is_current(stamp)]
    if "all" not in current and which not in current:
        install, python = INSTALLS[which], venv / "bin" / "python"
        there = INSTALLS["demo"] if "demo" in current else Install("", (), 0, 0)
        download, disk = install.download - there.download, install.disk - there.disk
        print(f"installing {install.what} into {shown(venv)}", flush=True)
        print(f"about {download} MB to download, {disk} MB more on disk", flush=True)
        if not current:
            subprocess.run([sys.executable, "-m", "venv", "--clear", venv], check=True)
            if code := pip(python, ["--quiet", "pip>=25.1"], None):
                return code
        if code := pip(python, install.arguments, download):
            return code
        remove_unused(venv)
        print(f"installed: {size(venv):.0f} MB in {shown(venv)}", flush=True)
    stamps["demo"].touch()
    if which == "all":
        stamps["all"].touch()
    return 0


def is_current(stamp: Path) -> bool:
    """Return whether an environment was made since the lists of packages were changed."""
    lists = (ROOT / "pyproject.toml", ROOT / "constraints.txt")
    return stamp.exists() and all(path.stat().st_mtime <= stamp.stat().st_mtime for path in lists)


def pip(python: Path, arguments: Sequence[str], expected: int | None) -> int:
    """Run `pip install`; show its progress if it is known how many MB are expected. Returns its exit code."""
    command = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "-c", "constraints.txt"]
    command += [*(["--progress-bar", "raw"] if expected else []), *arguments]
    # The build backend warns of parts of its own; errors are still shown. No cache: it would double the space on disk.
    environment = {**os.environ, "PYTHONWARNINGS": "ignore", "PIP_NO_CACHE_DIR": "1"}
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in show(process.stdout, expected or 0, is_live=sys.stdout.isatty()):
            print(line, end="", flush=True)
    return process.returncode


def show(output: Iterator[str], expected: int, *, is_live: bool) -> Iterator[str]:
    """Return what is printed while pip works: on one line of a terminal, or as lines where there is none."""
    progress, before = Progress(), ""
    for line in output:
        sentence, now = progress.read(line), progress.line(expected)
        if is_live and now != before:
            columns = shutil.get_terminal_size().columns
            yield f"\r{now[: columns - 1]}\x1b[K"
            before = now
        elif sentence and not is_live:
            yield f"{progress.done:.0f} of about {expected} MB: {sentence}\n"
    if is_live:
        yield "\r\x1b[K"


def remove_unused(venv: Path) -> None:
    """Remove parts of packages that Acromovi never opens."""
    for folder in venv.glob("lib/python3.*/site-packages"):
        for name in UNUSED:
            shutil.rmtree(folder / name, ignore_errors=True)  # it may be gone already
        for pattern in PARTS_UNUSED:
            for path in list(folder.glob(pattern)):
                shutil.rmtree(path, ignore_errors=True)  # it may be a part of one that is gone already


def size(folder: Path) -> float:
    """Return the space that a folder takes on disk, MB."""
    inodes = {path.lstat().st_ino: path.lstat().st_blocks * 512 for path in folder.rglob("*")}
    return sum(inodes.values()) / MB


def shown(path: Path) -> str:
    """Return a path as people type it here."""
    return os.path.relpath(path)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:  # pip has got the signal too, and ends by itself
        print("\ninterrupted; the same command begins again", file=sys.stderr)
        sys.exit(130)

"""Chromium, driven by Playwright, programs that serve pages, and a page that is open."""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Locator, Page, sync_playwright
from playwright.sync_api import TimeoutError as NotFound

from tests.waiting import patience, wait_until

ROOT = Path(__file__).parents[3]
CHROMIUM = shutil.which("chromium") or ""
needs_chromium = pytest.mark.skipif(not CHROMIUM, reason="chromium is not installed; .ci/run installs it with apt")
CHEAPLY = ("--no-sandbox", "--disable-gpu", "--disable-software-rasterizer", "--force-prefers-reduced-motion")
"""Options of Chromium; without a graphics process, drawing costs less where the processor draws in any case."""
SHOWN = 0.5
"""Time to find and press what may not be there, s, on an idle machine."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without a window."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=CHEAPLY)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def serving(*words: str, folder: Path = ROOT) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """Run `acromovi WORDS` in a folder, which serves pages; gives the process and their address."""
    command = [sys.executable, "-m", "acromovi", *words]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            address = re.search(r"https?://\S+", line)
            assert address, f"no page is served: {line}"
            yield process, address[0]
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()


class OpenPage:
    """A page in a browser. requested: the addresses of all that it has asked for. errors: of its scripts."""

    def __init__(self, context: BrowserContext) -> None:
        self.page: Page = context.new_page()
        self.page.set_default_timeout(patience() * 1e3)
        self.requested: list[str] = []
        self.errors: list[str] = []
        self.page.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: self.requested.append(socket.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))

    def sees(self, words: str) -> None:
        """Wait until words are shown."""
        self.page.get_by_text(words).first.wait_for()

    def press(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def press_if_shown(self, button: Locator) -> None:
        """Press a button that may be drawn anew, or change its name, at any moment."""
        with suppress(NotFound):  # the next look of whoever waits finds it
            button.first.click(timeout=patience(SHOWN) * 1e3)

    def choose(self, label: str, option: str) -> None:
        """Choose an option of a list; again, if a page that is drawn anew has closed the list."""
        wanted = self.page.get_by_role("option", name=option, exact=True)

        def is_chosen() -> bool:
            try:
                if not wanted.count():
                    self.page.get_by_label(label).first.click()
                wanted.click(timeout=patience(SHOWN) * 1e3)
            except NotFound:  # it was drawn anew; the next look finds it
                return False
            return True

        self.wait(is_chosen, f"{option} is chosen as {label}")

    def wait(self, condition: Callable[[], object], what: str) -> None:
        """Wait for a condition; the browser goes on meanwhile."""

        def holds() -> object:
            self.page.wait_for_timeout(50)  # ms, in which Playwright takes what has happened
            return condition()

        try:
            wait_until(holds, what)
        except AssertionError as error:
            error.add_note(f"the page says:\n{self.page.inner_text('body')}")
            raise


def children(word: str, of: int | None = None) -> list[int]:
    """The processes below this one, or another, that have a word in their command line."""
    return [pid for pid in _descendants(of or os.getpid()) if word.encode() in _command(pid)]


@contextmanager
def frozen(*pids: int) -> Iterator[None]:
    """Freeze processes during a block."""
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGCONT)


def _descendants(pid: int) -> Iterator[int]:
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, task.read_text(encoding="ascii").split()):
            yield child
            yield from _descendants(child)


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:  # it has just ended
        return b""

"""Chromium, driven by Playwright, and the page in it."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from playwright.sync_api import TimeoutError as NotFound

from tests.waiting import patience, wait_until

ROOT = Path(__file__).parents[3]
CHROMIUM = shutil.which("chromium") or ""
needs_chromium = pytest.mark.skipif(not CHROMIUM, reason="chromium is not installed; .ci/run installs it with apt")
WATCH = """() => {
    window.drawn = [];
    for (const viewer of document.querySelectorAll(".rv-viewer")) {
        viewer.addEventListener("drawn", (event) => {
            window.drawn.push({ place: viewer.getAttribute("aria-label"), ...event.detail });
        });
    }
}"""
"""Notes each image that is drawn: its place, number, stamp, and when it was drawn, s since 1970."""
SMALL = {"width": 760, "height": 560}
"""Of the window, px: what is drawn is drawn by the processor."""
CHEAPLY = ("--no-sandbox", "--disable-gpu", "--disable-software-rasterizer", "--force-prefers-reduced-motion")
"""Options of Chromium; without a graphics process, drawing costs less where the processor draws in any case."""
SHOWN = 0.5
"""Time to press a button that may no longer be there, s."""
ENOUGH = "([since, place, count]) => window.drawn.slice(since).filter((each) => each.place === place).length >= count"


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
def remote_vision(robot: str, bus: str, *options: str) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """Run the command on any free port; gives the process and the address of the page."""
    command = [sys.executable, "-m", "acromovi", "remote-vision", robot, "--port", "0", "--bus", bus, *options]
    with subprocess.Popen(
        command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert "http://" in line, "the page is not served"
            yield process, line.split()[4]
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()


class Viewer:
    """A page that has been opened. requested: the addresses of all that it has asked for."""

    def __init__(self, browser: Browser, address: str, **options: Any) -> None:
        self.context = browser.new_context(**{"viewport": SMALL, **options})
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(patience() * 1e3)
        self.requested: list[str] = []
        self.page.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: self.requested.append(socket.url))
        self.page.goto(address)
        self._watch()

    def reload(self) -> None:
        """Load the page anew."""
        self.page.reload()
        self._watch()

    def _watch(self) -> None:
        self.page.wait_for_selector(".rv-viewer")
        self.page.evaluate(WATCH)

    def until_drawn(self, place: str = "happy", count: int = 3) -> list[dict[str, Any]]:
        """Wait until further images are drawn in a place, and return them."""
        since = self.page.evaluate("window.drawn.length")
        self.page.wait_for_function(ENOUGH, arg=[since, place, count], polling=50)
        drawn: list[dict[str, Any]] = self.page.evaluate("since => window.drawn.slice(since)", since)
        return [each for each in drawn if each["place"] == place]

    def sees(self, words: str) -> None:
        """Wait until words are shown."""
        self.page.get_by_text(words).first.wait_for()

    def press(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def take_control(self) -> None:
        """Take control of the head, unless this page has it; again, while another page is about to release it."""

        def steers() -> bool:
            if self.page.get_by_text("You steer.").count():
                return True
            self._press_if_shown("Take control")
            return False

        self.wait(steers, "the page steers")

    def release_control(self) -> None:
        """Release control of the head, unless this page has lost it."""

        def does_not_steer() -> bool:
            self._press_if_shown("Release control")
            return not self.page.get_by_text("You steer.").count()

        self.wait(does_not_steer, "the page does not steer")

    def _press_if_shown(self, name: str) -> None:
        """Press a button whose name may change at any moment."""
        with suppress(NotFound):
            self.page.get_by_role("button", name=name, exact=True).click(timeout=SHOWN * 1e3)

    def key(self, name: str) -> None:
        """Press a key on the image."""
        self.page.locator(".rv-viewer").first.focus()
        self.page.keyboard.press(name)

    def choose(self, label: str, option: str) -> None:
        """Choose an option of a list."""
        self.page.get_by_label(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def place(self, across: float, down: float) -> tuple[float, float]:
        """A point of the image of the camera on the page; parts of its width and height."""
        canvas = self.page.locator("canvas").first
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        assert box is not None
        return box["x"] + across * box["width"], box["y"] + down * box["height"]

    def wait(self, condition: Callable[[], object], what: str) -> None:
        """Wait for a condition; the browser goes on meanwhile."""

        def holds() -> object:
            self.page.wait_for_timeout(50)  # ms, in which Playwright takes what has happened
            return condition()

        wait_until(holds, what)

    def close(self) -> None:
        """Close it, as a person does."""
        self.context.close()


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

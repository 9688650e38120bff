"""The console in Chromium."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from playwright.sync_api import Browser, Page
from playwright.sync_api import TimeoutError as NotFound

from tests.apps.remote_vision.browser import ROOT
from tests.waiting import patience, wait_until

SMALL = {"width": 1000, "height": 640}  # px
SHOWN = 0.5  # s, to press a button that may no longer be there


@contextmanager
def console(bus: str, *options: str) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """Run the command on any free port; gives the process and the address of the pages."""
    command = [sys.executable, "-m", "acromovi", "console", "--port", "0", "--bus", bus, *options]
    with subprocess.Popen(
        command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert "http://" in line, "the console is not served"
            yield process, line.split()[1]
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()


class ConsoleTab:
    """A tab of the browser. requested: the addresses of all that it has asked for. errors: of its scripts."""

    def __init__(self, browser: Browser, address: str, path: str = "/", **options: Any) -> None:
        self.address = address.rstrip("/")
        self.context = browser.new_context(**{"viewport": SMALL, **options})
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(patience() * 1e3)
        self.requested: list[str] = []
        self.errors: list[str] = []
        self.page.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: self.requested.append(socket.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.go(path)

    def go(self, path: str) -> None:
        """Open another page."""
        self.page.goto(self.address + path)

    def sees(self, words: str) -> None:
        """Wait until words are shown."""
        self.page.get_by_text(words).first.wait_for()

    def press(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def take_control(self) -> None:
        """Take control of the robot, unless this tab has it; again, while another one is about to release it."""

        def drives() -> bool:
            if self.page.get_by_role("button", name="Release control").count():
                return True
            with suppress(NotFound):  # it is drawn anew just now; the next look finds it
                self.page.get_by_role("button", name="Take control").first.click(timeout=SHOWN * 1e3)
            return False

        self.wait(drives, "this tab drives")

    def hold(self, key: str) -> None:
        """Press a key down."""
        self.page.keyboard.down(key)

    def release(self, key: str) -> None:
        """Let a key go."""
        self.page.keyboard.up(key)

    def wait(self, condition: Callable[[], object], what: str) -> None:
        """Wait for a condition; the browser goes on meanwhile."""

        def holds() -> object:
            self.page.wait_for_timeout(50)  # ms, in which Playwright takes what has happened
            return condition()

        wait_until(holds, what)

    def close(self) -> None:
        """Close it, as a person does."""
        self.context.close()


def moving(speed: Callable[[], float]) -> bool:
    """Whether a robot moves."""
    time.sleep(0.05)
    return abs(speed()) > 0.02

"""The console in Chromium."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from playwright.sync_api import BrowserContext, Page
from playwright.sync_api import TimeoutError as NotFound

from bus import keys
from tests.acromovi.team.running import RunningTeam
from tests.apps.remote_vision.browser import ROOT
from tests.waiting import patience, wait_until

STANDS = 0.01  # m/s and rad/s
PAUSE = 0.1  # s between two looks at a robot
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

    def __init__(self, context: BrowserContext, address: str, path: str = "/") -> None:
        self.address = address.rstrip("/")
        self.page: Page = context.new_page()
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

    def rest(self) -> None:
        """Show nothing, which costs nothing."""
        self.page.goto("about:blank")

    def close(self) -> None:
        """Close it, as a person does."""
        self.page.close()


class WatchedTeam:
    """A team, and what its robots really do. running: its processes. address: of its console."""

    def __init__(self, running: RunningTeam) -> None:
        self.running = running
        self.address = str(running.announced["console"])

    def speed(self, robot: str = "happy") -> float:
        """How fast a robot really is: m/s ahead or rad/s, whichever is more."""
        time.sleep(PAUSE)
        row = self.running.emulator().ask("truth", robot=robot)["robots"][robot]
        return max(abs(float(row["linear"])), abs(float(row["angular"])))

    def stands(self, robot: str = "happy") -> None:
        """Wait until a robot stands."""
        wait_until(lambda: self.speed(robot) < STANDS, f"{robot} stands")

    def holder(self, robot: str = "happy") -> str:
        """Who has the lease on the base; empty for nobody."""
        time.sleep(PAUSE)
        lease = self.running.bus.query(keys.LEASE_STATE.key(robot), {})[0].value
        return str((lease["elements"].get("base") or {}).get("holder") or "")


def drive(team: WatchedTeam, tab: ConsoleTab, key: str = "ArrowLeft") -> None:
    """Have a tab turn happy, and keep the key down; again, if a busy machine has stopped it."""
    if not tab.page.url.endswith("/robot/happy"):
        tab.go("/robot/happy")

    def turns() -> bool:
        tab.take_control()
        tab.release(key)
        tab.page.wait_for_timeout(150)  # ms: a command that says that everything was let go
        tab.hold(key)
        tab.page.wait_for_timeout(600)
        return team.speed() > 0.1

    tab.wait(turns, "happy turns")


def choose(tab: ConsoleTab, agent: str) -> None:
    """Choose an agent in the tree, and wait for its form."""
    tab.page.locator(".a-agent", has_text=agent).first.click()
    tab.page.locator(".a-title", has_text=agent).wait_for()


def ask(tab: ConsoleTab, request: str, **fields: str) -> None:
    """Fill in the form of a request or a query, and send it."""
    tab.page.get_by_role("tab", name="Ask").click()
    tab.page.get_by_label("Ask it to").click()
    tab.page.get_by_role("option", name=request, exact=True).click()
    for name, text in fields.items():
        tab.page.get_by_label(name, exact=True).fill(text)
    tab.press("Ask")

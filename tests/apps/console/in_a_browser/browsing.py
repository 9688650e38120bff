"""The console in Chromium."""

import time

from playwright.sync_api import BrowserContext

from bus import keys
from tests.acromovi.team.running import RunningTeam
from tests.apps.web.browsing import OpenPage
from tests.waiting import wait_until

STANDS = 0.01  # m/s and rad/s
PAUSE = 0.1  # s between two looks at a robot


class PageEnded(Exception):
    """A page that was to drive has ended, with its session or its certificate."""


class ConsoleTab(OpenPage):
    """A tab of the browser."""

    def __init__(self, context: BrowserContext, address: str, path: str = "/") -> None:
        super().__init__(context)
        self.address = address.rstrip("/")
        self.go(path)

    def go(self, path: str) -> None:
        """Open another page."""
        self.page.goto(self.address + path)

    def take_control(self) -> None:
        """Take control of the robot, unless this tab has it; again, while another one is about to release it.

        Raises:
            PageEnded: It shows that it has ended, or the page for the password.
        """

        def drives() -> bool:
            if self.page.get_by_text("This page has ended").count() or "/login" in self.page.url:
                raise PageEnded(self.page.url)
            if self.page.get_by_role("button", name="Release control").count():
                return True
            self.press_if_shown(self.page.get_by_role("button", name="Take control"))
            return False

        self.wait(drives, "this tab drives")

    def release_control(self) -> None:
        """Release control of the robot, if this tab has it; again, while the button is drawn anew."""

        def has_let_go() -> bool:
            button = self.page.get_by_role("button", name="Release control")
            if button.count():
                self.press_if_shown(button)
            return not button.count()

        self.wait(has_let_go, "this tab has let go")

    def hold(self, key: str) -> None:
        """Press a key down."""
        self.page.keyboard.down(key)

    def release(self, key: str) -> None:
        """Let a key go."""
        self.page.keyboard.up(key)

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


def drive(team: WatchedTeam, tab: ConsoleTab, key: str = "ArrowLeft", robot: str = "happy") -> None:
    """Have a tab turn a robot, and keep the key down; again, if a busy machine has stopped it."""
    if not tab.page.url.endswith(f"/robot/{robot}"):
        tab.go(f"/robot/{robot}")

    def turns() -> bool:
        tab.take_control()
        tab.release(key)
        tab.page.wait_for_timeout(150)  # ms: a command that says that everything was let go
        tab.hold(key)
        tab.page.wait_for_timeout(600)
        return team.speed(robot) > 0.1

    tab.wait(turns, f"{robot} turns")


def choose(tab: ConsoleTab, agent: str) -> None:
    """Choose an agent in the tree, and wait for its form."""
    if not tab.page.url.endswith("/agents"):
        tab.go("/agents")
    tab.page.locator(".a-agent", has_text=agent).first.click()
    tab.page.locator(".a-title", has_text=agent).wait_for()


def ask(tab: ConsoleTab, request: str, **fields: str) -> None:
    """Fill in the form of a request or a query, and send it."""
    tab.page.get_by_role("tab", name="Ask").click()
    tab.choose("Ask it to", request)
    for name, text in fields.items():
        tab.page.get_by_label(name, exact=True).fill(text)
    tab.press("Ask")


def click(tab: ConsoleTab, x: float, y: float) -> None:
    """Click a place of the map, m."""
    tab.page.mouse.click(*tab.page.evaluate("([x, y]) => document.querySelector('.c-map').toScreen(x, y)", [x, y]))


def drag(tab: ConsoleTab, start: tuple[float, float], to: tuple[float, float]) -> None:
    """Drag from one place of the map to another, m."""
    place = "([x, y]) => document.querySelector('.c-map').toScreen(x, y)"
    tab.page.mouse.move(*tab.page.evaluate(place, start))
    tab.page.mouse.down()
    tab.page.mouse.move(*tab.page.evaluate(place, to), steps=4)
    tab.page.mouse.up()

"""Who comes in, and what the role of a certificate permits: a console with a viewer's, behind a password."""

import asyncio
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext

from apps.web.access import PasswordHash
from apps.web.agent import page_agent
from bus import NoAnswer, ZenohBus, keys
from bus.acromovi_msgs import RobotState
from bus.messages import NS_PER_S, header
from tests.apps.console.in_a_browser.browsing import ConsoleTab
from tests.apps.web.browsing import needs_chromium, serving
from tests.bus.secure_site import MEMBERS, Site
from tests.waiting import wait_until

pytestmark = needs_chromium
HOST = "127.0.0.2"  # of this computer, but not the address for which no password is asked
PASSWORD = "correct horse"
ELEMENTS = ("base", "arm", "gripper", "sonar", "sound", "power")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(Path(tmp_path_factory.mktemp("site")))
    for owner in (*MEMBERS, "router.lab"):
        site.make(owner)
    with site.routed():
        yield site


@pytest.fixture(scope="module")
def address(site: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    file = tmp_path_factory.mktemp("access") / "password"
    PasswordHash.of(PASSWORD).write(file)
    profile = site.profile("viewer.vera")
    command = "console", "--port", "0", "--bus", profile, "--host", HOST, "--password-file", str(file)
    with serving(*command) as (_, address):
        yield address


@contextmanager
def robot(site: Site) -> Iterator[list[object]]:
    """Have happy on the bus during a block; gives the emergency stops that it hears."""
    heard: list[object] = []

    def stop(arguments: object) -> dict[str, object]:
        heard.append(arguments)
        return {}

    with ExitStack() as stack:
        bus: ZenohBus = stack.enter_context(site.open("robot.happy"))
        rows = [{"name": name, "outputs": ["laser"]} for name in ELEMENTS]
        bus.serve(keys.DESCRIPTION.key("happy"), lambda arguments: {"elements": rows})
        bus.serve(keys.LEASE_STATE.key("happy"), lambda arguments: {"elements": {}})
        bus.serve(keys.ESTOP.key("happy"), stop)
        bus.declare_alive(keys.ALIVE.key("happy"))
        stamp = header(int(time.time() * NS_PER_S), "")
        bus.put(keys.STATE.key("happy"), RobotState(stamp, "connected", True, False, False, 0, []))
        yield heard


def log_in(tab: ConsoleTab, password: str) -> None:
    tab.page.get_by_label("Password of the console").fill(password)
    tab.press("Log in")


def test_nobody_comes_in_without_the_password_and_a_session_that_ends_ends_its_pages(
    context: BrowserContext, address: str
) -> None:
    tab = ConsoleTab(context, address, "/robot")
    log_in(tab, "wrong horse")
    tab.sees("This is not the password.")
    log_in(tab, PASSWORD)
    tab.sees("no robot is on the bus yet")
    other = context.new_page()
    other.goto(address)
    other.get_by_text("No robot is on the bus yet;").first.wait_for()
    other.evaluate("window.socket.disconnect()")  # as one that sleeps, or is without its network
    tab.press("Log out")
    for page in (tab.page, other):  # Chromium may hang when a page is closed that is just being left
        page.get_by_label("Password of the console").wait_for()
    other.close()
    tab.close()


def test_a_viewer_sees_a_robot_and_can_neither_drive_nor_stop_nor_switch_it(
    site: Site, context: BrowserContext, address: str
) -> None:
    with robot(site) as heard:
        tab = ConsoleTab(context, address)
        log_in(tab, PASSWORD)
        tab.page.locator(".c-chip", has_text="happy").click()
        tab.sees("The role of this certificate permits looking only.")
        for panel in ("Arm", "Gripper", "Sonar", "Sound", "Power outputs"):
            tab.page.get_by_role("heading", name=panel, exact=True).wait_for()
        buttons = tab.page.locator("#content button:not([disabled]), #content .q-slider:not(.disabled)")
        tab.wait(lambda: not buttons.count(), f"nothing is enabled: {buttons.all_text_contents()}")
        tab.press("Stop all robots")
        tab.sees("NOT STOPPED: happy: a viewer may read everything")
        tab.go("/applications")
        assert tab.page.get_by_role("button", name="Start", exact=True).is_disabled()
        assert heard == []
    tab.page.locator(".c-chip", has_text="away").wait_for()
    tab.press("Stop all robots")
    tab.sees("NOT STOPPED: no robot is on the bus; not reached, since away from the bus: happy")
    assert tab.errors == []
    tab.close()


def test_an_operator_may_command_and_a_viewer_may_not(site: Site) -> None:
    async def may_command(owner: str) -> bool:
        with site.open(owner) as bus:
            async with page_agent(bus, "console") as (_, may):
                return may

    with ThreadPoolExecutor() as threads:  # the loop of this thread is Playwright's
        operator, viewer = threads.map(lambda owner: asyncio.run(may_command(owner)), ("operator.anna", "viewer.vera"))
    assert operator
    assert not viewer
    with robot(site) as heard, site.open("operator.anna") as bus:

        def is_stopped() -> bool:
            try:
                bus.query(keys.ESTOP.key("happy"), {"on": True})
            except NoAnswer:  # the operator's session does not know it yet
                return False
            return True

        wait_until(is_stopped, "happy hears it")
        assert heard == [{"on": True}]

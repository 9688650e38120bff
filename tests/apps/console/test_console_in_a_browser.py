"""The console in Chromium, on an emulated team: what is drawn, who drives, and what happens when something dies."""

import os
import re
import signal
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser

from bus import keys
from tests.acromovi.team.running import RunningTeam, running
from tests.apps.console.browsing import ConsoleTab
from tests.apps.remote_vision.browser import children, chromium, frozen, needs_chromium
from tests.waiting import wait_until

pytestmark = needs_chromium
TEAM = """\
world = "office"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["gripper", "laser"]
at_m = [2.0, 6.1]

[[robots]]
name = "max"
model = "p3dx-sh"
at_m = [9.0, 6.1]
"""
DRIVES = re.compile(r"page \d+ .* drives")
STANDS = 0.01  # m/s
PAUSE = 0.1  # s between two looks at a robot


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "team.toml"
    file.write_text(TEAM)
    with running(str(file), "--console", "0") as team:
        yield team


@pytest.fixture(scope="module")
def address(team: RunningTeam) -> str:
    return str(team.announced["console"])


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def tab(browser: Browser, address: str) -> Iterator[ConsoleTab]:
    tab = ConsoleTab(browser, address)
    yield tab
    tab.close()
    assert tab.errors == []


def speed(team: RunningTeam, robot: str = "happy") -> float:
    """How fast a robot really is: m/s ahead, and rad/s."""
    time.sleep(PAUSE)
    row = team.emulator().ask("truth", robot=robot)["robots"][robot]
    return max(abs(float(row["linear"])), abs(float(row["angular"])))


def holder(team: RunningTeam, robot: str = "happy") -> str:
    """Who has the lease on the base; empty for nobody."""
    time.sleep(PAUSE)
    lease = team.bus.query(keys.LEASE_STATE.key(robot), {})[0].value
    return str((lease["elements"].get("base") or {}).get("holder") or "")


def drive(team: RunningTeam, tab: ConsoleTab, key: str = "ArrowLeft") -> None:
    """Have a tab turn happy, and keep the key down; again, if a busy machine has stopped it."""
    if not tab.page.url.endswith("/robot/happy"):
        tab.go("/robot/happy")

    def turns() -> bool:
        tab.take_control()
        tab.release(key)
        tab.page.wait_for_timeout(150)  # ms: a command that says that everything was let go
        tab.hold(key)
        tab.page.wait_for_timeout(600)
        return speed(team) > 0.1

    tab.wait(turns, "happy turns")


def stands(team: RunningTeam, robot: str = "happy") -> None:
    wait_until(lambda: speed(team, robot) < STANDS, f"{robot} stands")


def test_the_map_is_drawn_live_and_nothing_is_loaded_from_elsewhere(tab: ConsoleTab) -> None:
    tab.sees("Robots are placed where the emulator says that they began.")
    tab.page.evaluate("document.querySelector('.c-map').addEventListener('drawn', (e) => (window.last = e.detail))")
    tab.page.wait_for_function("window.last && window.last.stamps.happy && window.last.stamps.max")
    first = tab.page.evaluate("window.last.stamps.happy")
    tab.page.wait_for_function("first => window.last.stamps.happy > first", arg=first)
    own = urlsplit(tab.page.url).netloc
    assert {urlsplit(url).netloc for url in tab.requested if not url.startswith(("data:", "blob:"))} == {own}


def test_a_robot_is_chosen_on_the_map_by_key(tab: ConsoleTab) -> None:
    tab.page.locator(".c-map").focus()
    tab.page.keyboard.press("n")
    tab.sees("nobody navigates happy")


def test_a_robot_turns_while_a_key_is_held(team: RunningTeam, tab: ConsoleTab) -> None:
    drive(team, tab)
    tab.release("ArrowLeft")
    stands(team)


def test_a_second_driver_sees_who_drives_and_can_stop_without_a_lease(
    team: RunningTeam, tab: ConsoleTab, browser: Browser, address: str
) -> None:
    other = ConsoleTab(browser, address, "/robot/happy")

    def is_seen() -> bool:
        drive(team, tab)  # again: a browser that a busy machine held up for 3 s has lost control
        take = other.page.get_by_role("button", name="Take control", exact=True).first
        return bool(other.page.get_by_text(DRIVES).count()) and take.is_disabled()

    tab.wait(is_seen, "the other tab shows who drives")
    other.go("/timeline")
    other.press("Stop all robots")
    other.sees("all 2 robots stopped")
    stands(team)
    tab.sees("The e-stop holds the robot")
    tab.release("ArrowLeft")
    other.press("Release the stop")
    other.press("Release")
    other.page.locator(".c-chip.c-alarm").first.wait_for(state="hidden")
    other.close()


def test_a_browser_that_freezes_or_is_closed_stops_the_robot(
    team: RunningTeam, tab: ConsoleTab, browser: Browser, address: str
) -> None:
    drive(team, tab)
    with frozen(*children("--type=renderer")):
        stands(team)
        wait_until(lambda: not holder(team), "the lease is released")
    tab.release("ArrowLeft")
    second = ConsoleTab(browser, address)
    drive(team, second, "ArrowRight")
    second.close()
    stands(team)
    wait_until(lambda: not holder(team), "the lease is released")


def test_a_fault_is_injected_and_cleared(team: RunningTeam, tab: ConsoleTab) -> None:
    tab.go("/faults")
    tab.page.get_by_label("Fault").first.click()
    tab.page.get_by_role("option", name="low-battery", exact=True).click()
    tab.press("Inject")
    tab.sees("low-battery is injected")
    assert [row["fault"] for row in team.emulator().ask("faults")["faults"]] == ["low-battery:robot=happy"]
    tab.press("Clear all")
    tab.sees("all faults are cleared")
    assert team.emulator().ask("faults")["faults"] == []
    tab.go("/timeline")
    tab.sees("low-battery was injected")


def test_a_console_that_freezes_or_is_killed_stops_the_robot(team: RunningTeam, tab: ConsoleTab) -> None:
    (process,) = children("acromovi\0console", team.process.pid)
    drive(team, tab)
    with frozen(process):
        stands(team)
    tab.release("ArrowLeft")
    drive(team, tab)
    os.kill(process, signal.SIGKILL)
    stands(team)
    wait_until(lambda: children("acromovi\0console", team.process.pid) not in ([], [process]), "it is started again")

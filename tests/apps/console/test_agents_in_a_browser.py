"""The page Agents in Chromium, on an emulated team."""

import signal
import subprocess
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.console.browsing import ConsoleTab, console
from tests.apps.remote_vision.browser import children, chromium, frozen, needs_chromium
from tests.waiting import exit_code, wait_until

pytestmark = needs_chromium
TEAM = """\
world = "office"

[[robots]]
name = "happy"
model = "p3dx-sh"
at_m = [2.0, 6.1]
"""
STANDS = 0.01  # rad/s
AN_HOUR = "3600"  # s
PAUSE = 0.1  # s between two looks at a robot
DESK = {"width": 1360, "height": 900}  # px


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "team.toml"
    file.write_text(TEAM)
    with running(str(file)) as team:
        yield team


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def served(team: RunningTeam) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    with console(team.profile) as served:
        yield served


@pytest.fixture(scope="module")
def tab(browser: Browser, served: "tuple[subprocess.Popen[str], str]") -> Iterator[ConsoleTab]:
    tab = ConsoleTab(browser, served[1], "/agents", viewport=DESK)
    yield tab
    tab.close()
    assert tab.errors == []


def speed(team: RunningTeam) -> float:
    """How fast happy really turns, rad/s."""
    time.sleep(PAUSE)
    return abs(float(team.emulator().ask("truth", robot="happy")["robots"]["happy"]["angular"]))


def turn(team: RunningTeam, tab: ConsoleTab) -> None:
    """Ask happy to turn for longer than any test waits."""
    tab.page.get_by_role("tab", name="Ask").click()
    tab.page.get_by_label("Within, s").fill(AN_HOUR)
    ask(tab, "drive", linear="0", angular="0.5", seconds=AN_HOUR)
    tab.wait(lambda: speed(team) > 0.2, "happy turns")


def stands(team: RunningTeam) -> None:
    wait_until(lambda: speed(team) < STANDS, "happy stands")


def choose(tab: ConsoleTab, agent: str) -> None:
    """Choose an agent in the tree, and wait for its form."""
    tab.page.locator(".a-agent", has_text=agent).first.click()
    tab.page.locator(".a-title", has_text=agent).wait_for()


def ask(tab: ConsoleTab, request: str, **fields: str) -> None:
    """Fill in the form of a request, and send it."""
    tab.page.get_by_role("tab", name="Ask").click()
    tab.page.get_by_label("Ask it to").click()
    tab.page.get_by_role("option", name=f"request {request}", exact=True).click()
    for name, text in fields.items():
        tab.page.get_by_label(name, exact=True).fill(text)
    tab.press("Ask")


def test_the_tree_is_searched_and_shows_what_acromovi_ps_shows(team: RunningTeam, tab: ConsoleTab) -> None:
    listed = {name for name in team.agents() if not name.startswith("ask-")}
    tab.wait(lambda: listed <= set(tab.page.locator(".a-name").all_text_contents()), "all agents are shown")
    tab.page.get_by_label("Search").fill("service=sonar")
    tab.wait(lambda: tab.page.locator(".a-name").all_text_contents() == ["sonar@happy"], "the sonar is found")
    tab.page.get_by_label("Search").fill("")


def test_an_agent_is_suspended_and_resumed(team: RunningTeam, tab: ConsoleTab) -> None:
    choose(tab, "sonar@happy")
    tab.press("Suspend")
    tab.page.locator(".a-agent", has_text="sonar@happy").get_by_text("suspended").wait_for()
    assert team.agents()["sonar@happy"]["state"] == "suspended"
    tab.press("Resume")
    tab.page.locator(".a-agent", has_text="sonar@happy").get_by_text("active").wait_for()
    tab.sees("sonar@happy is active in happy")


def test_a_request_is_made_by_its_form_and_its_conversation_is_watched(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    tab.press("Its messages")
    ask(tab, "turn", angle="0.1")
    tab.sees("turn: done")
    tab.page.get_by_role("cell", name="heading").first.wait_for()
    for word in ("request turn", "agree", "inform"):
        tab.page.locator(".a-arrow", has_text=word).first.wait_for()
    tab.page.locator(".a-arrow", has_text="request turn").first.press("Enter")
    tab.page.locator(".a-message", has_text='"angle": 0.1').wait_for()


def test_a_field_that_is_wrong_and_a_refusal_are_told_in_words(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    ask(tab, "go_to", x="far", y="0")
    tab.sees("Not sent: x is a number, not 'far'")
    ask(tab, "go_to", x="5000", y="0")
    tab.sees("name a place within 1000 m")


def test_a_composed_message_is_answered_and_hostile_text_stays_text(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    tab.page.get_by_role("tab", name="Message").click()
    tab.page.get_by_label("Content, JSON").fill('{"action": "<img src=x onerror=window.hacked=1>", "arguments": {}}')
    tab.press("Send")
    tab.page.get_by_role("cell", name="not-understood").wait_for()
    tab.page.locator(".a-arrow", has_text="<img").first.wait_for()
    assert tab.page.evaluate("window.hacked") is None


def test_the_inside_of_an_agent_shows_its_behaviours_and_streams(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    tab.page.get_by_role("tab", name="Inside").click()
    tab.page.get_by_role("cell", name="happy/odom").wait_for()


def test_a_motion_that_was_asked_for_ends_with_cancel_and_with_a_frozen_or_closed_browser(
    team: RunningTeam, tab: ConsoleTab, browser: Browser, served: "tuple[subprocess.Popen[str], str]"
) -> None:
    choose(tab, "base@happy")
    turn(team, tab)
    tab.press("Cancel")
    stands(team)
    turn(team, tab)
    with frozen(*children("--type=renderer")):
        stands(team)
    second = ConsoleTab(browser, served[1], "/agents", viewport=DESK)
    choose(second, "base@happy")
    turn(team, second)
    second.close()
    stands(team)


def test_a_motion_that_was_asked_for_ends_with_a_frozen_or_killed_console(
    team: RunningTeam, tab: ConsoleTab, served: "tuple[subprocess.Popen[str], str]"
) -> None:
    process, _ = served
    tab.go("/agents")
    choose(tab, "base@happy")
    turn(team, tab)
    with frozen(process.pid):
        stands(team)
    tab.go("/agents")
    choose(tab, "base@happy")
    turn(team, tab)
    process.kill()
    stands(team)
    assert exit_code(process) == -signal.SIGKILL

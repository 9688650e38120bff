"""What is driven and asked for stops when browser or console freeze or die. These tests come last, since they kill."""

import os
import signal

from playwright.sync_api import Browser

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, ask, choose, drive
from tests.apps.web.browsing import children, frozen, needs_chromium
from tests.waiting import wait_until

pytestmark = needs_chromium
AN_HOUR = "3600"  # s
OUT_OF_TIME = 2500  # ms; more than a container has for its answer


def turn(team: WatchedTeam, tab: ConsoleTab) -> None:
    """Ask max to turn for longer than any test waits."""
    if not tab.page.url.endswith("/agents"):
        tab.go("/agents")
    choose(tab, "base@max")
    tab.page.get_by_role("tab", name="Ask").click()
    tab.page.get_by_label("Within, s").fill(AN_HOUR)
    ask(tab, "request drive", linear="0", angular="0.5", seconds=AN_HOUR)
    tab.wait(lambda: team.speed("max") > 0.2, "max turns")


def test_a_form_that_its_container_has_not_told_of_is_asked_for_again(team: WatchedTeam, tab: ConsoleTab) -> None:
    tab.go("/agents")
    choose(tab, "base@max")
    fields = tab.page.locator(".c-form input")
    fields.first.wait_for()
    with frozen(*children("container\0--robot\0max", team.running.process.pid)):
        tab.page.locator(".a-agent", has_text="base@max").first.click()
        fields.first.wait_for(state="hidden")  # at once: nothing is asked for with an old form
        tab.page.wait_for_timeout(OUT_OF_TIME)

    def is_offered() -> bool:
        tab.press_if_shown(tab.page.get_by_role("button", name="Try again"))
        return fields.count() > 0

    tab.page.get_by_text("its container max has not answered").first.wait_for()
    tab.wait(is_offered, "the form is there")


def test_what_a_browser_has_set_in_motion_ends_with_cancel_and_when_it_is_frozen_or_closed(
    team: WatchedTeam, tab: ConsoleTab, browser: Browser
) -> None:
    asking = ConsoleTab(browser.new_context(), team.address, "/agents")
    turn(team, asking)
    asking.press("Cancel")
    team.stands("max")
    turn(team, asking)
    drive(team, tab)
    with frozen(*children("--type=renderer")):
        team.stands("happy")
        team.stands("max")
        wait_until(lambda: not team.holder(), "the lease is released")
    tab.release("ArrowLeft")
    asking.go("/agents")
    turn(team, asking)
    asking.close()
    driving = ConsoleTab(browser.new_context(), team.address)
    drive(team, driving, "ArrowRight")
    driving.close()
    team.stands("happy")
    team.stands("max")
    wait_until(lambda: not team.holder(), "the lease is released")


def test_what_a_console_has_set_in_motion_ends_when_it_is_frozen_or_killed_and_it_is_started_again(
    team: WatchedTeam, tab: ConsoleTab, browser: Browser
) -> None:
    (process,) = children("acromovi\0console", team.running.process.pid)
    asking = ConsoleTab(browser.new_context(), team.address, "/agents")
    turn(team, asking)
    drive(team, tab)
    with frozen(process):
        team.stands("happy")
        team.stands("max")
    tab.release("ArrowLeft")
    asking.go("/agents")
    turn(team, asking)
    drive(team, tab)
    os.kill(process, signal.SIGKILL)
    team.stands("happy")
    team.stands("max")
    wait_until(
        lambda: children("acromovi\0console", team.running.process.pid) not in ([], [process]), "it is started again"
    )
    asking.close()

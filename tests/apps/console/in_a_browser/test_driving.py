"""The map and the page of a robot, on an emulated team: what is drawn, and who drives."""

import re
from urllib.parse import urlsplit

from playwright.sync_api import BrowserContext, Route

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, drive
from tests.apps.web.browsing import needs_chromium

pytestmark = needs_chromium
DRIVES = re.compile(r"page \d+ .* drives")


def test_the_map_is_drawn_live_and_nothing_is_loaded_from_elsewhere(tab: ConsoleTab) -> None:
    tab.go("/")
    tab.sees("Robots are placed where the emulator says that they began.")
    tab.page.evaluate("document.querySelector('.c-map').addEventListener('drawn', (e) => (window.last = e.detail))")
    tab.page.wait_for_function("window.last && window.last.stamps.happy && window.last.stamps.max")
    first = tab.page.evaluate("window.last.stamps.happy")
    tab.page.wait_for_function("first => window.last.stamps.happy > first", arg=first)
    own = urlsplit(tab.page.url).netloc
    assert {urlsplit(url).netloc for url in tab.requested if not url.startswith(("data:", "blob:"))} == {own}
    tab.page.locator(".c-map").focus()
    tab.page.keyboard.press("n")
    tab.sees("nobody navigates happy")


def test_a_second_driver_sees_who_drives_and_can_stop_without_a_lease(
    team: WatchedTeam, tab: ConsoleTab, context: BrowserContext
) -> None:
    drive(team, tab)
    tab.release("ArrowLeft")
    team.stands()
    other = ConsoleTab(context, team.address, "/robot/happy")

    def is_seen() -> bool:
        drive(team, tab)  # again: a browser that a busy machine held up for 3 s has lost control
        take = other.page.get_by_role("button", name="Take control", exact=True).first
        return bool(other.page.get_by_text(DRIVES).count()) and take.is_disabled()

    tab.wait(is_seen, "the other tab shows who drives")
    other.press("Stop all robots")
    other.sees("all 2 robots stopped")
    team.stands()
    tab.sees("The e-stop holds the robot")
    tab.release("ArrowLeft")
    other.press("Release the stop")
    other.press("Release")
    other.page.locator(".c-chip.c-alarm").first.wait_for(state="hidden")
    tab.release_control()
    other.take_control()
    other.sees("You drive.")
    tab.page.get_by_text(DRIVES).first.wait_for()
    other.close()


def test_a_key_whose_release_a_menu_or_a_modifier_may_hide_drives_no_longer(team: WatchedTeam, tab: ConsoleTab) -> None:
    drive(team, tab, "a")
    tab.page.locator("h1").click(button="right")
    team.stands()
    drive(team, tab, "a")
    tab.hold("Meta")
    team.stands()
    tab.release("Meta")
    tab.release("a")
    drive(team, tab, "a")  # as before
    tab.release("a")
    tab.release_control()


def test_a_stop_that_is_never_answered_is_shown_as_failed(team: WatchedTeam, tab: ConsoleTab) -> None:
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    tab.go("/robot/happy")
    tab.page.route("**/stop", hold)  # as on a network that is dead: neither a reply nor an error
    tab.press("Stop all robots")
    tab.sees("NOT STOPPED: the console does not answer")
    for route in held:
        route.abort()  # a browser lets what is held go on when nothing is held back any more, and all robots would stop
    tab.page.unroute("**/stop")
    tab.rest()
    drive(team, tab)  # they have not
    tab.release("ArrowLeft")
    tab.release_control()

"""The page Vision: remote vision within the console."""

from urllib.parse import urlsplit

from tests.apps.console.in_a_browser.browsing import ConsoleTab
from tests.apps.remote_vision.viewer import ENOUGH, WATCH
from tests.apps.web.browsing import needs_chromium

pytestmark = needs_chromium


def test_operations_and_colours_of_a_robot_are_used_on_a_page_of_the_console(tab: ConsoleTab) -> None:
    tab.go("/robot/max")
    tab.page.get_by_role("link", name="Operations, colours and results").click()
    tab.page.wait_for_selector(".rv-viewer")
    assert urlsplit(tab.page.url).path == "/vision/max"
    tab.page.evaluate(WATCH)
    tab.page.wait_for_function(ENOUGH, arg=[0, "max", 3], polling=50)
    tab.choose("Operation or saved chain", "canny")
    tab.sees("canny: shown")
    tab.page.wait_for_function(ENOUGH, arg=[0, "canny", 2], polling=50)
    tab.page.get_by_role("switch").click()
    canvas = tab.page.locator("canvas").first
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    tab.page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + 0.85 * box["height"])
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.95 * box["height"], steps=3)
    tab.page.mouse.up()
    tab.sees("channel 1 trained")


def test_a_robot_that_is_not_there_is_told(tab: ConsoleTab) -> None:
    tab.go("/vision/nobody")
    tab.sees("nobody is not on the bus")
    tab.go("/")
    tab.page.get_by_role("link", name="Vision").click()
    tab.page.wait_for_selector(".rv-viewer[aria-label=max]")

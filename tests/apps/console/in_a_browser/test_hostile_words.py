"""A robot whose words would do harm as HTML is shown and sent as any other."""

import pytest

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, ask, choose
from tests.apps.console.in_a_browser.odd_robot import NAME, X, odd_robot
from tests.apps.remote_vision.browser import needs_chromium
from tests.waiting import wait_until

pytestmark = needs_chromium


def click(tab: ConsoleTab, x: float, y: float) -> None:
    """Click a place of the map, m."""
    tab.page.mouse.click(*tab.page.evaluate("([x, y]) => document.querySelector('.c-map').toScreen(x, y)", [x, y]))


def test_hostile_words_are_shown_as_text_and_such_a_robot_is_sent_by_a_click_and_queried(
    team: WatchedTeam, tab: ConsoleTab
) -> None:
    with odd_robot(team.running.profile) as navigation:
        tab.go("/")
        tab.page.locator(".c-chip", has_text=NAME).wait_for()

        def is_chosen() -> bool:
            click(tab, X, 0.0)
            tab.page.wait_for_timeout(300)
            return bool(tab.page.get_by_role("status").get_by_text(f"{NAME}: ").count())

        tab.wait(is_chosen, "it is chosen")
        tab.sees(f"{NAME} is shown in a frame of its own")
        tab.page.get_by_role("switch", name="Send by a click").click()
        tab.page.wait_for_function("document.querySelector('.c-map canvas.c-aim')")
        click(tab, 4.5, 1.0)
        wait_until(lambda: navigation.goals, "the goal has come")
        (goal,) = navigation.goals
        assert goal == {"x": pytest.approx(4.5, abs=0.05), "y": pytest.approx(1.0, abs=0.05), "heading": None}
        for path in ("/timeline", "/robot/" + NAME.replace("<", "%3C").replace(">", "%3E")):
            tab.go(path)
            tab.sees("<script>window.pwned=1</script>")
        tab.go("/agents")
        choose(tab, f"user_interface@{NAME}")
        ask(tab, "query goal", number="0")
        tab.sees("goal: done")
        tab.page.get_by_role("cell", name=str(goal["x"])).wait_for()
        assert not tab.page.evaluate("window.pwned")
        assert tab.page.locator("img").count() == 0

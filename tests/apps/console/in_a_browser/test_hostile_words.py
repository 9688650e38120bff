"""A robot whose words would do harm as HTML is shown and sent as any other."""

import pytest

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, ask, choose, click, drag
from tests.apps.console.in_a_browser.odd_robot import MAP, NAME, X, odd_robot
from tests.apps.web.browsing import needs_chromium
from tests.waiting import wait_until

pytestmark = needs_chromium


def test_hostile_words_are_shown_as_text_and_such_a_robot_is_sent_by_a_click_and_queried(
    team: WatchedTeam, tab: ConsoleTab
) -> None:
    with odd_robot(team.running.profile) as (navigation, localization):
        tab.go("/")
        tab.page.locator(".c-chip", has_text=NAME).wait_for()

        def is_chosen() -> bool:
            click(tab, MAP[0] + X, MAP[1])
            tab.page.wait_for_timeout(300)
            return bool(tab.page.get_by_role("status").get_by_text(f"{NAME}: ").count())

        tab.wait(is_chosen, "it is chosen")
        tab.sees(f"{NAME}: localized, ±0.40 m, ±6°")
        tab.page.get_by_role("switch", name="Send by a click").click()
        tab.page.wait_for_function("document.querySelector('.c-map canvas.c-aim')")
        click(tab, 4.5, 1.0)
        wait_until(lambda: navigation.goals, "the goal has come")
        (goal,) = navigation.goals
        on_map = {"x": 4.5 - MAP[0], "y": 1.0 - MAP[1]}
        assert goal == {**{name: pytest.approx(value, abs=0.05) for name, value in on_map.items()}, "heading": None}
        click(tab, 5.0, 2.0)  # the goal of the map
        wait_until(lambda: len(navigation.goals) == 2, "the named goal has come")
        assert navigation.goals[1] == {"x": 5.0 - MAP[0], "y": 2.0 - MAP[1], "heading": None}
        tab.page.get_by_role("switch", name="Relocalize by a click").click()
        tab.page.wait_for_timeout(300)  # ms, until the page's mode has come
        drag(tab, (6.0, 1.0), (6.0, 3.0))
        wait_until(lambda: localization.poses, "the pose has come")
        assert localization.poses == [pytest.approx((6.0, 1.0, 1.5708), abs=0.06)]
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

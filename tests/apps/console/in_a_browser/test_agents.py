"""The page Agents, on an emulated team."""

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, ask, choose
from tests.apps.web.browsing import needs_chromium

pytestmark = needs_chromium


def test_the_tree_is_searched_and_shows_what_acromovi_ps_shows(team: WatchedTeam, tab: ConsoleTab) -> None:
    tab.go("/agents")
    listed = {name for name in team.running.agents() if not name.startswith("ask-")}
    tab.wait(lambda: listed <= set(tab.page.locator(".a-name").all_text_contents()), "all agents are shown")
    tab.page.get_by_label("Search").fill("service=sonar")
    found = ["sonar@happy", "sonar@max"]
    tab.wait(lambda: tab.page.locator(".a-name").all_text_contents() == found, "the sonars are found")
    tab.page.get_by_label("Search").fill("")


def test_an_agent_is_suspended_resumed_moved_and_stopped(tab: ConsoleTab) -> None:
    choose(tab, "sound@happy")
    row = tab.page.locator(".a-agent", has_text="sound@happy")
    tab.press("Suspend")
    row.get_by_text("suspended").wait_for()
    tab.press("Resume")
    row.get_by_text("active").wait_for()
    tab.sees("sound@happy is active in happy")
    tab.press("Move …")
    tab.choose("Container", "max")
    tab.press("Move it")
    tab.sees("sound@happy is active in max")
    tab.press("Stop …")
    tab.press("Stop it")
    row.wait_for(state="hidden")


def test_a_request_is_made_by_its_form_and_its_conversation_is_watched(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    tab.press("Its messages")
    ask(tab, "request turn", angle="0.1")
    tab.sees("turn: done")
    tab.page.get_by_role("cell", name="heading").first.wait_for()
    for word in ("request turn", "agree", "inform"):
        tab.page.locator(".a-arrow", has_text=word).first.wait_for()
    tab.page.locator(".a-arrow", has_text="request turn").first.press("Enter")
    tab.page.locator(".a-message", has_text='"angle": 0.1').wait_for()


def test_a_field_that_is_wrong_and_a_refusal_are_told_in_words(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    ask(tab, "request go_to", x="far", y="0")
    tab.sees("Not sent: x is a number, not 'far'")
    ask(tab, "request go_to", x="5000", y="0")
    tab.sees("name a place within 1000 m")


def test_the_inside_of_an_agent_and_the_replies_to_a_composed_message_are_shown(tab: ConsoleTab) -> None:
    choose(tab, "base@happy")
    tab.page.get_by_role("tab", name="Inside").click()
    tab.page.get_by_role("cell", name="happy/odom").wait_for()
    tab.page.get_by_role("tab", name="Message").click()
    tab.page.get_by_label("Content, JSON").fill('{"action": "<img src=x onerror=window.hacked=1>", "arguments": {}}')
    tab.press("Send")
    tab.page.get_by_role("cell", name="not-understood").wait_for()
    tab.page.locator(".a-arrow", has_text="<img").first.wait_for()
    assert tab.page.evaluate("window.hacked") is None

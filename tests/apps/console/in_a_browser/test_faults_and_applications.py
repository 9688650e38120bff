"""The pages Faults and Applications, on an emulated team."""

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam
from tests.apps.web.browsing import needs_chromium

pytestmark = needs_chromium


def test_a_fault_is_injected_and_cleared(team: WatchedTeam, tab: ConsoleTab) -> None:
    emulator = team.running.emulator()
    tab.go("/faults")
    tab.page.get_by_label("Fault").first.click()
    tab.page.get_by_role("option", name="low-battery", exact=True).click()
    tab.press("Inject")
    tab.sees("low-battery is injected")
    assert [row["fault"] for row in emulator.ask("faults")["faults"]] == ["low-battery:robot=happy"]
    tab.press("Clear all")
    tab.sees("all faults are cleared")
    assert emulator.ask("faults")["faults"] == []


def test_an_application_is_started_with_arguments_and_stopped_and_its_output_is_read(
    team: WatchedTeam, tab: ConsoleTab
) -> None:
    tab.go("/applications")
    tab.page.get_by_label("Application").first.click()
    tab.page.get_by_role("option", name="wander", exact=True).click()
    tab.page.get_by_label("robot", exact=True).fill("nobody")
    tab.press("Start")
    tab.sees("failed (1)")
    tab.page.get_by_role("log").get_by_text("nobody").wait_for()  # its last words
    tab.page.get_by_label("robot", exact=True).fill("max")
    tab.page.get_by_label("speed", exact=True).fill("0.1")
    tab.press("Start")
    tab.wait(lambda: team.speed("max") > 0.05, "max wanders")
    tab.press("Stop")
    tab.sees("stopped")
    team.stands("max")
    tab.go("/timeline")
    tab.sees("low-battery was injected")
    tab.sees("wander was stopped")

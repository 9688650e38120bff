"""The pages Faults and Applications, on an emulated team."""

import re
from math import hypot

import pytest

from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, click, drag
from tests.apps.web.browsing import needs_chromium

pytestmark = needs_chromium


def test_a_fault_is_injected_and_cleared(team: WatchedTeam, tab: ConsoleTab) -> None:
    emulator = team.running.emulator()
    tab.go("/faults")
    tab.choose("Fault", "low-battery")
    tab.press("Inject")
    tab.sees("low-battery is injected")
    assert [row["fault"] for row in emulator.ask("faults")["faults"]] == ["low-battery:robot=happy"]
    tab.press("Clear all")
    tab.sees("all faults are cleared")
    assert emulator.ask("faults")["faults"] == []
    tab.go("/timeline")
    tab.sees("low-battery was injected")


def test_a_robot_is_put_elsewhere_by_dragging_it_and_by_two_clicks(team: WatchedTeam, tab: ConsoleTab) -> None:
    emulator = team.running.emulator()

    def truth() -> dict[str, float]:
        row: dict[str, float] = emulator.ask("truth", robot="max")["robots"]["max"]
        return row

    def is_near(place: tuple[float, float], x: float, y: float) -> bool:
        return hypot(x - place[0], y - place[1]) < 0.15

    def is_shown(place: tuple[float, float]) -> bool:
        row = tab.page.get_by_label("Robots on the map").get_by_text("max: ").inner_text()
        x, y = map(float, re.findall(r"-?\d+\.\d+(?= m)", row))
        return is_near(place, x, y)

    begun = truth()
    start = begun["x"], begun["y"]
    to = start[0] + 0.6, start[1]
    tab.go("/faults")
    tab.page.locator(".c-map").scroll_into_view_if_needed()
    tab.wait(lambda: is_shown(start), "max is on the map")
    drag(tab, start, to)
    tab.sees("max is put at")
    tab.wait(lambda: is_near(to, truth()["x"], truth()["y"]), "max is there")
    assert truth()["heading"] == pytest.approx(begun["heading"], abs=0.02)
    tab.wait(lambda: is_shown(to), "it is shown there")
    click(tab, *to)
    tab.page.wait_for_function("document.querySelector('.c-map canvas.c-aim')")
    click(tab, *start)
    tab.wait(lambda: is_near(start, truth()["x"], truth()["y"]), "max is back")
    tab.wait(lambda: is_shown(start), "it is shown there")


def test_an_application_is_started_with_arguments_and_stopped_and_its_output_is_read(
    team: WatchedTeam, tab: ConsoleTab
) -> None:
    tab.go("/applications")
    tab.choose("Application", "wander")
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
    tab.sees("wander was stopped")

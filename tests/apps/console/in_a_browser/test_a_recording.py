"""A recording in the console: play, pause, go to a position and to an event; nothing can be commanded."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext

from tests.apps.console.in_a_browser.browsing import ConsoleTab
from tests.apps.console.recordings import DRIVEN, ESTOP_AT, GOAL, THERE_AT, WAY_AT, recorded_drive
from tests.apps.web.browsing import needs_chromium, serving

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def replayed(context: BrowserContext, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ConsoleTab]:
    file: Path = recorded_drive(tmp_path_factory.mktemp("recording") / "drive.mcap")
    with serving("console", "--port", "0", "--bus", "local:unused", "--replay", str(file)) as (_, address):
        tab = ConsoleTab(context, address)
        yield tab
        tab.close()
        assert tab.errors == []


def position(tab: ConsoleTab) -> float:
    """The position that the bar shows, s."""
    return float(tab.page.get_by_label("Position").input_value())


def go_to(tab: ConsoleTab, elapsed: float) -> None:
    """Put the position elsewhere, as a person does with the keyboard or the pointer."""
    put = "(bar, to) => { bar.value = to; for (const kind of ['input', 'change']) bar.dispatchEvent(new Event(kind)); }"
    tab.page.get_by_label("Position").evaluate(put, elapsed)


def test_a_recording_is_played_paused_and_put_to_another_position(replayed: ConsoleTab) -> None:
    tab = replayed
    tab.page.locator(".c-chip", has_text="happy").wait_for()
    tab.wait(lambda: position(tab) > 0.3, "it plays")
    tab.press("Pause")
    tab.page.get_by_role("button", name="Play", exact=True).wait_for()
    tab.page.get_by_label("Speed").select_option("16")
    go_to(tab, 1.0)
    tab.page.evaluate("document.querySelector('.c-map').addEventListener('drawn', (e) => (window.last = e.detail))")
    tab.wait(lambda: abs(position(tab) - 1.0) < 0.01, "it is at 1 s")
    tab.page.locator(".c-unseen", has_text=f"happy: driving, at x {1.0 * DRIVEN:.1f} m").wait_for()
    tab.press("Play")
    tab.wait(lambda: position(tab) > 7.0, "it plays 16 times as fast")


def test_a_click_on_an_event_goes_to_its_time_and_the_robot_is_shown_as_it_was(replayed: ConsoleTab) -> None:
    tab = replayed
    tab.go("/timeline")
    tab.page.get_by_role("row").filter(has_text="is held by an emergency stop").click()
    tab.wait(lambda: abs(position(tab) - ESTOP_AT) < 0.01, "it is at the time of the stop")
    tab.page.locator(".c-chip.c-alarm", has_text="happy").wait_for()
    tab.page.locator(".c-later", has_text="is free again").wait_for()


def test_goal_way_and_state_of_a_mission_are_shown_where_it_stood(replayed: ConsoleTab) -> None:
    tab = replayed
    tab.go("/?robot=happy")
    tab.page.locator(".c-chip", has_text="happy").wait_for()
    if tab.page.get_by_role("button", name="Pause").count():
        tab.press("Pause")
    go_to(tab, WAY_AT + 0.5)
    tab.sees("m1: going (the way leads ahead)")
    words = f"on its way to x {GOAL[0]:.1f} m, y {GOAL[1]:.1f} m, by a way of 3 places"
    tab.page.locator(".c-unseen", has_text=words).wait_for()
    assert not tab.page.get_by_role("button", name="Cancel the mission").count()
    tab.go("/timeline")
    tab.page.get_by_role("row").filter(has_text="there, after 2.2 m").click()
    tab.wait(lambda: abs(position(tab) - THERE_AT) < 0.01, "it is at the end of the mission")
    tab.go("/?robot=happy")
    tab.sees("m1: done (there, after 2.2 m)")


def test_robots_of_a_recording_are_marked_and_cannot_be_commanded(replayed: ConsoleTab) -> None:
    tab = replayed
    tab.go("/robot/happy")
    tab.sees("This is a recording: its robots and agents cannot be commanded.")
    tab.page.locator("h1", has_text="happy").get_by_text("REPLAY").wait_for()
    tab.page.get_by_role("heading", name="Sonar", exact=True).wait_for()
    buttons = tab.page.locator("#content button:not([disabled]), #content .q-slider:not(.disabled)")
    tab.wait(lambda: not buttons.count(), "nothing is enabled")
    assert not tab.page.get_by_role("button", name="Stop all robots").count()
    assert not tab.page.get_by_role("link", name="Applications").count()

"""The live page in Chromium: a drive is seen, a frozen browser holds up nothing, and the button ends the drive."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.remote_vision.viewer import Viewer
from tests.apps.web.browsing import children, chromium, frozen, needs_chromium, serving
from tests.shown import files
from tests.waiting import exit_code, wait_until

pytestmark = needs_chromium
PLACE = "image, flow, and time to contact"


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "lab.toml"
    file.write_text(files("optical-flow", "toml")[0])
    with running(str(file)) as team:
        yield team


def test_the_page_shows_the_drive_a_frozen_browser_holds_up_nothing_and_the_button_ends_it(
    team: RunningTeam, tmp_path: Path
) -> None:
    command = "run", "optical_flow", "robot=bart", "page=0", "film=", "picture=", "--bus", team.profile
    with serving(*command, folder=tmp_path) as (process, url), chromium() as browser:
        viewer = Viewer(browser, url)
        assert process.stdout is not None
        drawn = viewer.until_drawn(PLACE)
        stamps = [each["stamp"] for each in drawn]
        assert stamps == sorted(set(stamps))
        viewer.sees("Situation: ")
        viewer.page.locator(".rv-log li").first.wait_for()
        before = where(team)
        with frozen(*children("--type=renderer")):
            wait_until(lambda: where(team) != before, "it drives on while the browser is frozen")
        viewer.until_drawn(PLACE)
        viewer.press("Stop")
        assert exit_code(process) == 0
        told = process.stdout.read()
    assert "stopped from the page" in told
    assert "floor visited" in told
    stands = where(team)
    assert where(team) == stands


def where(team: RunningTeam) -> tuple[float, float, float]:
    """The true pose, to the mm and the mrad."""
    truth = team.emulator().ask("truth", robot="bart")
    return round(truth["x"], 3), round(truth["y"], 3), round(truth["heading"], 3)

"""One team, one console and one browser for all tests of this folder, which one worker runs as a whole."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, ViewportSize

from tests.acromovi.team.running import running
from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam
from tests.apps.web.browsing import chromium

SIZE: ViewportSize = {"width": 1000, "height": 640}  # px
TEAM_FILE = """\
world = "office"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["gripper", "laser"]
at_m = [2.0, 6.1]

[[robots]]
name = "max"
model = "p3dx-sh"
fit = ["camera:160x120@5"]
at_m = [9.0, 6.1]
"""


@pytest.fixture(scope="package")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WatchedTeam]:
    file = tmp_path_factory.mktemp("team") / "team.toml"
    file.write_text(TEAM_FILE)
    with running(str(file), "--console", "0") as team:
        yield WatchedTeam(team)


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="package")
def context(browser: Browser) -> Iterator[BrowserContext]:
    """What all tabs share, their cache included: scripts are compiled once for a console."""
    with browser.new_context(viewport=SIZE) as context:
        yield context


@pytest.fixture(scope="package")
def team_tab(context: BrowserContext, team: WatchedTeam) -> Iterator[ConsoleTab]:
    tab = ConsoleTab(context, team.address)
    yield tab
    tab.close()
    assert tab.errors == []


@pytest.fixture(scope="module")
def tab(team_tab: ConsoleTab) -> Iterator[ConsoleTab]:
    yield team_tab
    team_tab.rest()

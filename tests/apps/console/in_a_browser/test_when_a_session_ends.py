"""A certificate that expires and a session that ends while their pages drive: robots stop, and the pages tell why."""

import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

from playwright.sync_api import Browser

from apps.web.access import PasswordHash
from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, drive
from tests.apps.console.in_a_browser.test_certificates import tab_of
from tests.apps.web.browsing import needs_chromium, serving
from tests.bus.secure_site import Site
from tests.waiting import wait_until

pytestmark = needs_chromium
LEAST, TIMES = 8.0, 5.0  # s, and times what it takes until one page drives; by then two pages must
PASSWORD = "correct horse"


def stops_and_tells_why(team: WatchedTeam, tab: ConsoleTab, robot: str, words: str) -> None:
    """Wait until a page has ended that drives, and see that it drives no more, though its key is still held."""
    tab.sees(words)
    tab.sees("This page has ended")
    team.stands(robot)
    wait_until(lambda: not team.holder(robot), "the lease is released")
    tab.page.keyboard.down("ArrowLeft")
    time.sleep(1.0)
    team.stands(robot)


def test_a_page_drives_no_longer_than_its_certificate_is_valid_or_its_session_lasts(
    team: WatchedTeam, tab: ConsoleTab, browser: Browser, tmp_path: Path
) -> None:
    begun = time.monotonic()
    drive(team, tab)
    lasts = round(LEAST + TIMES * (time.monotonic() - begun))
    tab.rest()
    site, file, settings = Site(tmp_path / "site"), tmp_path / "password", tmp_path / "settings.toml"
    site.make("router.lab")
    PasswordHash.of(PASSWORD).write(file)
    settings.write_text(f"[access]\nsession_s = {lasts}\n")
    words = "--certificate", str(site.folder / "router.lab"), "--password-file", str(file), "--settings", str(settings)
    with serving("console", "--port", "0", "--bus", team.running.profile, *words) as (_, address):
        brief = site.make("operator.brief", datetime.now(UTC), timedelta(seconds=lasts))
        with tab_of(browser, address, brief, "/robot/happy") as certified, tab_of(browser, address, None, "/") as known:
            known.page.get_by_label("Password of the console").fill(PASSWORD)
            known.press("Log in")
            known.page.locator(".c-chip").first.wait_for()
            drive(team, known, robot="max")
            drive(team, certified)
            stops_and_tells_why(team, certified, "happy", "The certificate of operator.brief has expired on")
            stops_and_tells_why(team, known, "max", "and a session lasts no longer")
            known.page.get_by_role("link", name="Open the console again").click()
            known.page.get_by_label("Password of the console").wait_for()

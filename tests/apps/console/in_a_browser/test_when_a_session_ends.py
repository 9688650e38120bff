"""A certificate that expires and a session that ends while their pages drive: robots stop, and the pages tell why."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

from playwright.sync_api import Browser, Error

from apps.web.access import PasswordHash
from tests.apps.console.in_a_browser.browsing import ConsoleTab, PageEnded, WatchedTeam, drive
from tests.apps.console.in_a_browser.test_certificates import tab_of
from tests.apps.web.browsing import needs_chromium, serving
from tests.bus.secure_site import Site
from tests.waiting import wait_until

pytestmark = needs_chromium
LEAST, TIMES = 8.0, 5.0  # s, and times what it takes until one page drives; by then two pages must
LONGER = 1, 3, 9  # times that, if the machine has become slower meanwhile
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


@contextmanager
def driving_pages(
    team: WatchedTeam, browser: Browser, folder: Path, lasts: int
) -> Iterator[tuple[ConsoleTab, ConsoleTab]]:
    """Open a page with a certificate and one with a password, which last for so many s, and drive with both.

    Raises:
        PageEnded: That was too short on this machine.
    """
    site, file, settings = Site(folder / "site"), folder / "password", folder / "settings.toml"
    site.make("router.lab")
    PasswordHash.of(PASSWORD).write(file)
    settings.write_text(f"[access]\nsession_s = {lasts}\n")
    words = "--certificate", str(site.folder / "router.lab"), "--password-file", str(file), "--settings", str(settings)
    with serving("console", "--port", "0", "--bus", team.running.profile, *words) as (_, address):
        begins = datetime.now(UTC)
        expires = begins + timedelta(seconds=lasts)
        brief = site.make("operator.brief", begins, timedelta(seconds=lasts))
        with ExitStack() as pages:
            try:
                certified = pages.enter_context(tab_of(browser, address, brief, "/robot/happy"))
                known = pages.enter_context(tab_of(browser, address, None, "/"))
                known.page.get_by_label("Password of the console").fill(PASSWORD)
                known.press("Log in")
                for tab in (known, certified):
                    tab.page.locator(".c-chip").first.wait_for()
                drive(team, known, robot="max")
                drive(team, certified)
            except Error as error:  # a page that is loaded when its certificate expires gets no answer, and stays empty
                if datetime.now(UTC) < expires:
                    raise
                raise PageEnded(address) from error
            yield certified, known


def test_a_page_drives_no_longer_than_its_certificate_is_valid_or_its_session_lasts(
    team: WatchedTeam, tab: ConsoleTab, browser: Browser, tmp_path: Path
) -> None:
    begun = time.monotonic()
    drive(team, tab)
    lasts = LEAST + TIMES * (time.monotonic() - begun)
    tab.rest()
    with ExitStack() as stack:
        for longer in LONGER:
            try:
                opened = driving_pages(team, browser, tmp_path / f"{longer}", round(longer * lasts))
                certified, known = stack.enter_context(opened)
                break
            except PageEnded:  # the machine has become slower than it was when the first page drove
                if longer == LONGER[-1]:
                    raise
        stops_and_tells_why(team, certified, "happy", "The certificate of operator.brief has expired on")
        stops_and_tells_why(team, known, "max", "and a session lasts no longer")
        known.page.get_by_role("link", name="Open the console again").click()
        known.page.get_by_label("Password of the console").wait_for()


def test_a_browser_that_is_away_when_its_certificate_expires_tells_that(
    team: WatchedTeam, tab: ConsoleTab, browser: Browser, tmp_path: Path
) -> None:
    begun = time.monotonic()
    tab.go("/timeline")
    tab.page.locator(".c-chip").first.wait_for()
    lasts = LEAST + TIMES * (time.monotonic() - begun)
    tab.rest()
    site = Site(tmp_path / "site")
    site.make("router.lab")
    words = "--certificate", str(site.folder / "router.lab")
    with serving("console", "--port", "0", "--bus", team.running.profile, *words) as (console, address):
        brief = site.make("operator.brief", datetime.now(UTC), timedelta(seconds=round(lasts)))
        with tab_of(browser, address, brief, "/timeline") as away:
            away.page.locator(".c-chip").first.wait_for()
            console.kill()  # as far as a browser can tell, its network is gone
            away.sees("The certificate of operator.brief has expired on")

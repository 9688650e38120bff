"""Browsers with certificates: an operator drives and stops, a viewer looks, and a browser without one is refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from bus.secure import CERTIFICATE, PRIVATE_KEY
from tests.apps.console.in_a_browser.browsing import ConsoleTab, WatchedTeam, drive
from tests.apps.web.browsing import needs_chromium, serving
from tests.bus.secure_site import Site
from tests.waiting import wait_until

pytestmark = needs_chromium
HOST = "127.0.0.1"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    site = Site(tmp_path_factory.mktemp("site"))
    for owner in ("router.lab", "operator.anna", "viewer.vera"):
        site.make(owner)
    return site


@pytest.fixture(scope="module")
def address(site: Site, team: WatchedTeam) -> Iterator[str]:
    none = site.folder / "no-password"
    words = "--certificate", str(site.folder / "router.lab"), "--password-file", str(none)
    with serving("console", "--port", "0", "--bus", team.running.profile, *words) as (_, address):
        assert address.startswith("https://")
        yield address


@contextmanager
def tab_of(browser: Browser, address: str, keys: Path | None, path: str) -> Iterator[ConsoleTab]:
    """Open a page with the certificate in a folder, or without one."""
    origin = address.rstrip("/")
    shown = {"origin": origin, "certPath": keys / CERTIFICATE, "keyPath": keys / PRIVATE_KEY} if keys else None
    # Playwright connects on behalf of the browser, and does not know the authority of this test.
    with browser.new_context(ignore_https_errors=True, client_certificates=[shown] if shown else None) as context:  # type: ignore[list-item]  # Playwright's typed dict has the same keys
        tab = ConsoleTab(context, address, path)
        yield tab
        assert tab.errors == []
        tab.close()


def test_an_operator_drives_and_a_viewer_only_looks(
    site: Site, browser: Browser, address: str, team: WatchedTeam
) -> None:
    with tab_of(browser, address, site.folder / "viewer.vera", "/robot/happy") as viewer:
        viewer.sees("The role of your certificate permits looking only.")
        viewer.page.get_by_role("heading", name="Sonar", exact=True).wait_for()
        buttons = viewer.page.locator("#content button:not([disabled]), #content .q-slider:not(.disabled)")
        viewer.wait(lambda: not buttons.count(), f"nothing is enabled: {buttons.all_text_contents()}")
        viewer.press("Stop all robots")
        viewer.sees("the role of your certificate permits looking only")
        with tab_of(browser, address, site.folder / "operator.anna", "/robot/happy") as operator:
            drive(team, operator)
            viewer.page.get_by_text("(operator.anna) drives.").or_(viewer.page.get_by_text("has it")).first.wait_for()
            drive(team, operator)  # the viewer's button has stopped nothing
        team.stands()
        viewer.go("/agents")
        viewer.page.locator(".a-agent", has_text="base@happy").first.click()
        viewer.page.get_by_text("the role of your certificate permits looking only").first.wait_for()
        wait_until(viewer.page.get_by_role("button", name="Ask", exact=True).is_disabled, "Ask is disabled")
        assert viewer.page.get_by_role("button", name="Suspend").is_disabled()
        viewer.go("/vision/max")
        viewer.page.get_by_text("the role of your certificate permits looking only").first.wait_for()
        viewer.page.wait_for_selector(".rv-viewer[aria-label=max]")
        for command in ("Take control", "Save chain", "Save channels"):
            assert not viewer.page.get_by_role("button", name=command).count()


def test_a_browser_without_a_certificate_is_refused(browser: Browser, address: str) -> None:
    with tab_of(browser, address, None, "/robot/happy") as stranger:
        stranger.sees("this page asks for a certificate")

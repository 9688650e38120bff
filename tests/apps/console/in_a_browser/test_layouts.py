"""Every page at the width of a phone, in both themes: nothing is cut or too wide, all can be read and has a name."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import ViewportSize

from tests.apps.console.in_a_browser.browsing import ConsoleTab, choose
from tests.apps.console.in_a_browser.conftest import SIZE
from tests.apps.web.browsing import needs_chromium
from tests.waiting import Deadline

pytestmark = needs_chromium
AUDIT = Path(__file__).with_name("audit.js").read_text()
PHONE: ViewportSize = {"width": 390, "height": 800}  # px
OVERFLOW = (
    "const each = document.createElement('p'); each.style.cssText = 'width: 2000px; color: #777; background: #888';"
)


@pytest.fixture
def phone(tab: ConsoleTab) -> Iterator[ConsoleTab]:
    tab.page.set_viewport_size(PHONE)
    yield tab
    tab.page.evaluate("Quasar.Dark.set(false)")
    tab.page.set_viewport_size(SIZE)


def bring_into_use(tab: ConsoleTab, path: str) -> None:
    """Open what a page shows only when something is chosen."""
    if path == "/agents":
        choose(tab, "base@happy")
        tab.page.get_by_label("Within, s").wait_for()
    elif path == "/faults":
        tab.choose("Fault", "sonar-dead")
        tab.page.get_by_label("disc").wait_for()
    elif path == "/applications":
        tab.choose("Application", "wander")
        tab.page.get_by_label("speed", exact=True).wait_for()


@pytest.mark.parametrize(
    "path", ["/", "/robot/happy", "/vision/max", "/agents", "/faults", "/timeline", "/applications"]
)
def test_a_page_fits_a_phone_and_can_be_read_in_both_themes(phone: ConsoleTab, path: str) -> None:
    phone.go(path)
    phone.page.locator(".c-chip", has_text="happy").wait_for()
    bring_into_use(phone, path)
    for dark in (False, True):
        phone.page.evaluate("(dark) => Quasar.Dark.set(dark)", dark)
        deadline = Deadline()
        while True:
            phone.page.wait_for_timeout(1000)  # ms, in which colours have changed, unless the machine is busy
            found = phone.page.evaluate(AUDIT)
            if not found or deadline.has_passed():
                break
        assert found == [], f"{path}, dark: {dark}"


def test_the_audit_finds_what_is_too_wide_and_what_cannot_be_read_or_named(phone: ConsoleTab) -> None:
    phone.go("/timeline")
    phone.page.locator(".c-chip", has_text="happy").wait_for()
    words = (
        "each.textContent = 'pale'; document.querySelector('#content').append(each, document.createElement('button'));"
    )
    phone.page.evaluate(f"() => {{ {OVERFLOW} {words} }}")
    phone.page.locator("#content > button").evaluate("(button) => (button.style.padding = '9px')")
    found = "\n".join(phone.page.evaluate(AUDIT))
    assert "beyond the right side: pale" in found
    assert "contrast 1." in found
    assert "without a name: <button" in found

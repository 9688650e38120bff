"""The page of the remote vision in Chromium."""

from typing import Any

from playwright.sync_api import Browser

from tests.apps.web.browsing import OpenPage

WATCH = """() => {
    window.drawn = [];
    for (const viewer of document.querySelectorAll(".rv-viewer")) {
        viewer.addEventListener("drawn", (event) => {
            window.drawn.push({ place: viewer.getAttribute("aria-label"), ...event.detail });
        });
    }
}"""
"""Notes each image that is drawn: its place, number, stamp, and when it was drawn, s since 1970."""
SMALL = {"width": 760, "height": 560}
"""Of the window, px: what is drawn is drawn by the processor."""
ENOUGH = "([since, place, count]) => window.drawn.slice(since).filter((each) => each.place === place).length >= count"


class Viewer(OpenPage):
    """A page with images, in a context of its own."""

    def __init__(self, browser: Browser, address: str, **options: Any) -> None:
        self.context = browser.new_context(**{"viewport": SMALL, **options})
        super().__init__(self.context)
        self.page.goto(address)
        self._watch()

    def reload(self) -> None:
        """Load the page anew."""
        self.page.reload()
        self._watch()

    def _watch(self) -> None:
        self.page.wait_for_selector(".rv-viewer")
        self.page.evaluate(WATCH)

    def until_drawn(self, place: str = "happy", count: int = 3) -> list[dict[str, Any]]:
        """Wait until further images are drawn in a place, and return them."""
        since = self.page.evaluate("window.drawn.length")
        self.page.wait_for_function(ENOUGH, arg=[since, place, count], polling=50)
        drawn: list[dict[str, Any]] = self.page.evaluate("since => window.drawn.slice(since)", since)
        return [each for each in drawn if each["place"] == place]

    def take_control(self) -> None:
        """Take control of the head, unless this page has it; again, while another page is about to release it."""

        def steers() -> bool:
            if self.page.get_by_text("You steer.").count():
                return True
            self.press_if_shown(self.page.get_by_role("button", name="Take control", exact=True))
            return False

        self.wait(steers, "the page steers")

    def release_control(self) -> None:
        """Release control of the head, unless this page has lost it."""

        def does_not_steer() -> bool:
            self.press_if_shown(self.page.get_by_role("button", name="Release control", exact=True))
            return not self.page.get_by_text("You steer.").count()

        self.wait(does_not_steer, "the page does not steer")

    def key(self, name: str) -> None:
        """Press a key on the image."""
        self.page.locator(".rv-viewer").first.focus()
        self.page.keyboard.press(name)

    def place(self, across: float, down: float) -> tuple[float, float]:
        """A point of the image of the camera on the page; parts of its width and height."""
        canvas = self.page.locator("canvas").first
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        assert box is not None
        return box["x"] + across * box["width"], box["y"] + down * box["height"]

    def close(self) -> None:
        """Close it, as a person does."""
        self.context.close()

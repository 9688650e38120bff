"""Make the pictures of the console: `python -m tools.console_pictures [FOLDER]`, by default `docs/pictures`.

It starts a team with the console and Chromium, sends a robot to a place, drives another one, and takes the pictures: in
both themes, and at the width of a phone. It takes about a minute.
"""

import json
import sys
import tempfile
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which

from PIL import Image
from playwright.sync_api import Browser, Page, ViewportSize, sync_playwright

from tools.page_picture import FOLDER, started
from tools.small_png import make_small

SIZE: ViewportSize = {"width": 1280, "height": 800}  # px
PHONE: ViewportSize = {"width": 390, "height": 800}  # px
TALL: ViewportSize = {"width": 1280, "height": 1080}  # px
TRIES = 10
GAP = 24  # px between the pictures of phones
TEAM = """\
world = "office"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["gripper", "laser"]
navigation = true
at_m = [2.0, 6.1]

[[robots]]
name = "doc"
model = "p3dx-sh"
fit = ["gripper", "ptz:vcc4", "camera:320x240@10"]
at_m = [12.6, 6.1]
heading_deg = 180.0

[[robots]]
name = "max"
model = "powerbot-sh"
fit = ["arm"]
at_m = [8.2, 5.85]

[[robots]]
name = "sneezy"
model = "p3dx-sh"
fit = ["no-rear-sonar"]
at_m = [2.5, 2.5]
heading_deg = 90.0
"""
GOAL = 13.5, 9.5  # m on the map
Act = Callable[[Page], None]


@contextmanager
def opened(browser: Browser, url: str, path: str, theme: str, size: ViewportSize) -> Iterator[Page]:
    """Open a page in a theme."""
    context = browser.new_context(viewport=size, device_scale_factor=1)
    context.add_cookies([{"name": "acromovi-theme", "value": theme, "url": url}])
    page = context.new_page()
    page.goto(url.rstrip("/") + path)
    page.locator(".c-chip").first.wait_for()
    yield page
    context.close()


def take(browser: Browser, url: str, path: str, theme: str, file: Path, act: Act, size: ViewportSize = SIZE) -> None:
    """Take one picture; act: brings the page into the state that it shows."""
    with opened(browser, url, path, theme, size) as page:
        act(page)
        page.mouse.move(5, size["height"] - 100)
        page.wait_for_timeout(1200)  # ms, until everything is drawn
        page.screenshot(path=file)
    make_small(file)
    print(file)


def _look(page: Page) -> None:
    page.wait_for_timeout(1500)


def _send(page: Page) -> None:
    """Send happy to a place by a click on the map."""
    page.get_by_role("switch", name="Send by a click").click()
    page.wait_for_timeout(1500)  # ms, until the map stands still
    x, y = page.evaluate("([x, y]) => document.querySelector('.c-map').toScreen(x, y)", list(GOAL))
    page.mouse.click(x, y)
    page.get_by_text("is sent to").first.wait_for()
    page.get_by_role("switch", name="Send by a click").click()
    page.wait_for_timeout(9000)  # ms, until a part of the way has been driven


def _drive(page: Page) -> None:
    """Drive doc ahead; again, while a busy machine holds the browser up."""
    page.get_by_role("button", name="Take control").first.click()
    page.get_by_text("You drive.").wait_for()
    for _ in range(TRIES):
        page.keyboard.up("ArrowUp")
        page.wait_for_timeout(400)
        page.keyboard.down("ArrowUp")
        page.wait_for_timeout(1500)
        if not page.get_by_text("stopped: let go").count():
            return


def _detect(page: Page) -> None:
    """Show edges beside the image, and train a colour channel by dragging over it."""
    page.get_by_label("Operation or saved chain").click()
    page.get_by_role("option", name="canny", exact=True).click()
    page.get_by_text("canny: shown").first.wait_for()
    page.get_by_role("checkbox", name="Colour blobs").click()
    page.get_by_role("switch").click()
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.8 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.95 * box["height"], steps=3)
    page.mouse.up()
    page.get_by_text("channel 1 trained").first.wait_for()
    page.evaluate("window.scrollTo(0, 0)")


def _inject(page: Page) -> None:
    """Inject a fault, and show what another one takes."""
    page.get_by_label("Fault").first.click()
    page.get_by_role("option", name="sonar-dead", exact=True).click()
    page.wait_for_timeout(500)


def _ask(page: Page) -> None:
    """Ask the base of sneezy for a turn, and for a place that is too far away.

    Not that of happy: its navigation has the lease until the mission ends, which takes long on a busy machine.
    """
    page.locator(".a-agent", has_text="base@sneezy").first.click()
    page.get_by_label("Ask it to").wait_for()
    for request, fields, words in (
        ("turn", {"angle": "0.3"}, "turn: done"),
        ("go_to", {"x": "5000", "y": "0"}, "go_to: refused"),
    ):
        page.get_by_label("Ask it to").click()
        page.get_by_role("option", name=f"request {request}", exact=True).click()
        for name, text in fields.items():
            page.get_by_label(name, exact=True).fill(text)
        page.get_by_role("button", name="Ask", exact=True).click()
        page.get_by_text(words).first.wait_for()
    page.evaluate("window.scrollTo(0, 0)")


def _start(page: Page) -> None:
    """Let sneezy wander, and show the output."""
    page.get_by_label("Application").first.click()
    page.get_by_role("option", name="wander", exact=True).click()
    page.get_by_label("robot", exact=True).fill("sneezy")
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_role("button", name="wander robot=sneezy").click()
    page.wait_for_timeout(8000)  # ms, until it drives


def _side_by_side(files: list[Path], to: Path) -> None:
    """Join pictures of phones."""
    pictures = [Image.open(file).convert("RGB") for file in files]
    width = sum(picture.width for picture in pictures) + GAP * (len(pictures) - 1)
    page = Image.new("RGB", (width, pictures[0].height), "white")
    at = 0
    for picture in pictures:
        page.paste(picture, (at, 0))
        at += picture.width + GAP
    page.save(to)
    make_small(to)
    print(to)


def main(arguments: list[str]) -> None:
    """Make the pictures."""
    folder = Path(*arguments) if arguments else FOLDER
    chromium = which("chromium")
    if chromium is None:
        sys.exit("tools/console_pictures.py: chromium is not installed; install it with: apt install chromium")
    bus = f"local:picture-{uuid.uuid4().hex[:8]}"
    with tempfile.TemporaryDirectory() as scratch:
        team = Path(scratch) / "team.toml"
        team.write_text(TEAM)
        with (
            started("up", str(team), "--bus", bus, "--console", "0", "--json", answer='"console"') as line,
            sync_playwright() as playwright,
        ):
            url = json.loads(line)["console"]
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            take(browser, url, "/?robot=happy", "light", folder / "console-map.png", _send)
            take(browser, url, "/robot/doc", "dark", folder / "console-robot-dark.png", _drive)
            take(browser, url, "/?robot=doc", "dark", folder / "console-map-dark.png", _look)
            take(browser, url, "/robot/max", "light", folder / "console-robot.png", _look)
            take(browser, url, "/vision/doc", "light", folder / "console-vision.png", _detect, TALL)
            take(browser, url, "/agents", "light", folder / "console-agents.png", _ask, TALL)
            take(browser, url, "/faults", "light", folder / "console-faults.png", _inject)
            take(browser, url, "/timeline", "dark", folder / "console-timeline.png", _look)
            take(browser, url, "/applications", "light", folder / "console-applications.png", _start)
            phones = [("/?robot=happy", "light", _look), ("/robot/doc", "dark", _drive), ("/faults", "light", _inject)]
            files = [Path(scratch) / f"{number}.png" for number in range(len(phones))]
            for (path, theme, act), file in zip(phones, files, strict=True):
                take(browser, url, path, theme, file, act, PHONE)
            _side_by_side(files, folder / "console-phone.png")
            browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])

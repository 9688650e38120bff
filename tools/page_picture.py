"""Make the picture of the page of remote vision: `python tools/page_picture.py [FOLDER]`, by default `docs/pictures`.

It starts a team, `acromovi remote-vision` and Chromium, trains a colour, shows edges beside the image, and takes the
picture. It takes about 20 s.
"""

import subprocess
import sys
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which

from playwright.sync_api import Page, ViewportSize, sync_playwright

from tools.small_png import make_small

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "pictures"
NAME = "remote-vision.png"
SIZE: ViewportSize = {"width": 1280, "height": 1030}  # px
TEAM = """\
world = "texture-lab"

[[robots]]
name = "happy"
model = "peoplebot-sh"
fit = ["ptz:vcc4", "camera:320x240@15"]
at_m = [1.4, 4.0]
heading_deg = -7.0

[[robots]]
name = "doc"
model = "p3dx-sh"
fit = ["target"]
at_m = [3.2, 3.7]
heading_deg = 10.0
"""
RECTANGLES = (("left", 0.425, 0.47), ("centre", 0.61, 0.65), ("right", 0.74, 0.775))
"""The flanks and the centre of the target: name, left and right side as parts of the width of the image."""
TOP, BOTTOM = 0.45, 0.55  # likewise of its height


@contextmanager
def started(*words: str, answer: str) -> Iterator[str]:
    """Start a command; gives the first line that it prints, which contains a word."""
    command = [sys.executable, "-m", "acromovi", *words]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield next(line for line in process.stdout if answer in line)
        finally:
            process.terminate()


def _show(page: Page) -> None:
    """Bring the page into the state that the picture shows."""
    page.get_by_role("button", name="Take control").click()
    page.get_by_text("You steer.").wait_for()
    page.wait_for_timeout(1500)  # ms, until images come evenly
    page.get_by_role("switch").click()
    for channel, (name, left, right) in enumerate(RECTANGLES, 1):
        page.get_by_label("Channel", exact=True).click()
        page.get_by_role("option", name=str(channel), exact=True).click()
        page.get_by_label("Name").fill(name)
        page.keyboard.press("Tab")
        box = page.locator("canvas").first.bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + left * box["width"], box["y"] + TOP * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + right * box["width"], box["y"] + BOTTOM * box["height"], steps=3)
        page.mouse.up()
        page.get_by_text(f"channel {channel} trained").wait_for()
    page.get_by_role("switch").click()
    page.get_by_role("checkbox", name="Colour blobs").click()
    page.get_by_label("Operation or saved chain").click()
    page.get_by_role("option", name="canny", exact=True).click()
    page.get_by_text("canny: shown").wait_for()
    page.mouse.move(0, 0)
    page.wait_for_timeout(1500)


def main(arguments: list[str]) -> None:
    """Make the picture."""
    folder = Path(*arguments) if arguments else FOLDER
    chromium = which("chromium")
    if chromium is None:
        sys.exit("tools/page_picture.py: chromium is not installed; install it with: apt install chromium")
    bus = f"local:picture-{uuid.uuid4().hex[:8]}"
    with tempfile.TemporaryDirectory() as scratch:
        team = Path(scratch) / "team.toml"
        team.write_text(TEAM)
        with (
            started("up", str(team), "--bus", bus, answer="Ctrl-C ends the team"),
            started("remote-vision", "happy", "--port", "0", "--bus", bus, answer="http://") as line,
            sync_playwright() as playwright,
        ):
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            page = browser.new_page(viewport=SIZE)
            page.goto(line.split()[4])
            _show(page)
            page.screenshot(path=folder / NAME)
            browser.close()
    make_small(folder / NAME)
    print(folder / NAME)


if __name__ == "__main__":
    main(sys.argv[1:])

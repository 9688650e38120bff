"""Make the picture of a patrol in the console: `python -m tools.patrol_picture [FOLDER]`, by default `docs/pictures`.

It starts the team and the building of docs/surveillance.md with cameras on the robots, starts the surveillance from the
page Applications, adds a stranger to the world, and takes the picture when there is an alarm with a picture. It takes
about two minutes.
"""

import json
import re
import subprocess
import sys
import tempfile
import uuid
from pathlib import Path
from shutil import which

from playwright.sync_api import Page, ViewportSize, sync_playwright

from tools.console_pictures import opened, take
from tools.page_picture import FOLDER, ROOT, started

NAME = "console-patrol.png"
PATIENCE = 180_000.0  # ms for rooms to be divided, and for the stranger to be seen
STRANGER = "p3dx-sh", "--name", "stranger", "--at", "3.2", "2.3"  # as the page of the surveillance adds it
LASER, CAMERA = 'fit = ["laser"]', 'fit = ["laser", "camera:160x120@5"]'
SIZE: ViewportSize = {"width": 1280, "height": 1120}  # px


def night(page: Path, folder: Path) -> tuple[Path, Path]:
    """Write the map and the team of a page of the documentation, with cameras; return the files."""
    text = page.read_text(encoding="utf-8")
    building, team = (re.search(rf"```{kind}\n({begin}.*?)```", text, re.DOTALL) for kind, begin in KINDS)
    assert building, "the page has a map"
    assert team, "the page has a team"
    with_cameras = team[1].replace(LASER, CAMERA)
    assert with_cameras != team[1], "its robots have lasers"
    files = folder / "night.map", folder / "night.toml"
    files[0].write_text(building[1], encoding="utf-8")
    files[1].write_text(with_cameras.replace('"night.map"', json.dumps(str(files[0]))), encoding="utf-8")
    return files


KINDS = (("text", "2D-Map"), ("toml", "world ="))


def _patrol(page: Page, building: Path, team: Path, report: Path) -> None:
    """Start the surveillance, and wait until both robots patrol."""
    page.get_by_label("Application").first.click()
    page.get_by_role("option", name="surveillance", exact=True).click()
    for name, text in (("map", building), ("starts", team), ("report", report)):
        page.get_by_label(name, exact=True).fill(str(text))
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_role("button", name=re.compile("^surveillance ")).click()
    for robot in ("happy", "doc"):
        page.get_by_text(f"{robot} joins the patrol").first.wait_for()


def _alarm(page: Page) -> None:
    """Wait for an alarm with a picture."""
    page.set_default_timeout(PATIENCE)
    page.locator(".c-alarms img").first.wait_for()
    page.wait_for_timeout(6000)  # ms, until the robot that follows is near


def main(arguments: list[str]) -> None:
    """Make the picture."""
    folder = Path(*arguments) if arguments else FOLDER
    chromium = which("chromium")
    if chromium is None:
        sys.exit("tools/patrol_picture.py: chromium is not installed; install it with: apt install chromium")
    bus = f"local:picture-{uuid.uuid4().hex[:8]}"
    with tempfile.TemporaryDirectory() as scratch:
        building, team = night(ROOT / "docs" / "surveillance.md", Path(scratch))
        with (
            started("up", str(team), "--bus", bus, "--console", "0", "--json", answer='"console"') as line,
            sync_playwright() as playwright,
        ):
            told = json.loads(line)
            browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            with opened(browser, told["console"], "/applications", "light", SIZE) as page:
                page.set_default_timeout(PATIENCE)
                _patrol(page, building, team, Path(scratch) / "report")
            stranger = [sys.executable, "-m", "acromovi", "world", "add", *STRANGER, "--control", told["control"]]
            subprocess.run(stranger, cwd=ROOT, check=True)
            take(browser, told["console"], "/?robot=happy", "light", folder / NAME, _alarm, SIZE)
            browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])

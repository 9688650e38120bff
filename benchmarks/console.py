"""What the console costs, how old the map is when it is drawn, and how soon a joystick and a closed tab reach a robot.

The team of seven drives on the spot, as in `team`. Chromium has no window, draws with the processor, and notes when it
has drawn an update of the map, by the same clock as the stamps of odometry. For the ways to the robot's line the
benchmark plays the robot on a pty (`CableRobot`), so that the first byte is seen when it comes. Processor time is that
of the console alone; Chromium's own is not counted. Twenty tabs are pages without a browser (`headless_pages`).
"""

import argparse
import json
import random
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from shutil import which

from playwright.sync_api import BrowserContext, Page, sync_playwright

from acromovi.children import gateway
from benchmarks.figures import Figure, percentile
from benchmarks.peer import CableRobot
from benchmarks.processes import CpuMeter, resident_megabytes, running_team
from benchmarks.team import TEAM, driving_team
from bus import Sample, ZenohBus, keys
from configs.defaults import default_bus

GROUP = "console"
SECONDS = 20.0
SETTLE = 5.0  # s that are not counted
TRIALS = 60
CLOSINGS = 5
TABS = 20
MANY_SECONDS = 10.0  # with all tabs
SEED = 17
PATIENCE = 120.0  # s for what a trial waits for, and for a page
BESIDE = "doc"  # of the team; a robot with a camera
CPU, MEMORY, TABS_CPU = 15.0, 200.0, 100.0  # % of a core, MB, % of a core
DRAWN_P50, DRAWN_P95, JOYSTICK, CLOSED, BEHIND, LONGER = 60.0, 150.0, 60.0, 600.0, 500.0, 20.0  # ms
WATCH = """() => {
    window.drawn = [];
    const last = {};
    document.querySelector(".c-map").addEventListener("drawn", (event) => {
        for (const [name, stamp] of Object.entries(event.detail.stamps)) {
            if (last[name] !== stamp) window.drawn.push((event.detail.at - stamp) * 1000);
            last[name] = stamp;
        }
    });
}"""
PRESS = """([kind, key]) => {
    document.body.dispatchEvent(new KeyboardEvent(kind, { key, bubbles: true }));
    return (performance.timeOrigin + performance.now()) / 1000;
}"""


def measure(options: argparse.Namespace) -> list[Figure]:
    """Measure all figures; none without Chromium."""
    chromium = which("chromium")
    if chromium is None:
        print("     chromium is not installed, so nothing is measured; install it with: apt install chromium")
        return []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        try:
            context = browser.new_context()
            context.set_default_timeout(PATIENCE * 1e3)
            return [*_to_the_line(context), *_of_a_team(context)]
        finally:
            browser.close()


def _of_a_team(browser: BrowserContext) -> Iterator[Figure]:
    """Processor time, memory and age of what is drawn, with one tab and with twenty."""
    with running_team(TEAM), running_console("--team", TEAM) as (process, url), driving_team():
        page, beside = browser.new_page(), browser.new_page()
        for each, path in ((page, ""), (beside, f"robot/{BESIDE}")):
            each.goto(url + path)
            each.wait_for_selector(".c-chip")
        page.bring_to_front()
        page.wait_for_timeout(SETTLE * 1e3)
        page.evaluate(WATCH)
        meter = CpuMeter(process.pid)
        page.wait_for_timeout(SECONDS * 1e3)
        cpu, memory = meter.percent(), resident_megabytes(process.pid)
        drawn = page.evaluate("window.drawn")
        what = "team of seven driving, a map with a laser and a camera shown"
        yield Figure(GROUP, f"{what}: processor", cpu, CPU, "%")
        yield Figure(GROUP, f"{what}: memory", memory, MEMORY, "MB")
        yield Figure(GROUP, "reading to drawn in the browser, p50", percentile(drawn, 50), DRAWN_P50, "ms", len(drawn))
        yield Figure(GROUP, "reading to drawn in the browser, p95", percentile(drawn, 95), DRAWN_P95, "ms", len(drawn))
        for each in (page, beside):
            each.close()
        yield from _of_many_tabs(url, process.pid)


def _of_many_tabs(url: str, console: int) -> Iterator[Figure]:
    """Processor time, how far the slowest page is behind, and the readings of robots, before and with all pages.

    Args:
        url: Of the console.
        console: Its process.
    """
    with _gaps() as gaps:
        time.sleep(MANY_SECONDS)
        alone = _longest_usual(gaps)
    command = [sys.executable, "-m", "benchmarks.headless_pages", url, *map(str, (TABS, SETTLE, MANY_SECONDS))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process, _gaps() as gaps:
        time.sleep(SETTLE)
        gaps.clear()
        meter = CpuMeter(console)
        time.sleep(MANY_SECONDS)
        cpu, together = meter.percent(), _longest_usual(gaps)
        ages = json.loads(process.communicate(timeout=PATIENCE)[0])
    # A page that has got nothing is behind by all of the time.
    worst = max(percentile(age, 95) if age else MANY_SECONDS * 1e3 for age in ages)
    samples = sum(map(len, ages))
    yield Figure(GROUP, f"{TABS} tabs: processor", cpu, TABS_CPU, "%")
    yield Figure(GROUP, f"{TABS} tabs: age of readings in the slowest tab, p95", worst, BEHIND, "ms", samples)
    what = f"{TABS} tabs: longer between two readings of the slowest robot, p95"
    yield Figure(GROUP, what, together - alone, LONGER, "ms", sum(map(len, gaps.values())))


@contextmanager
def _gaps() -> Iterator[dict[str, list[float]]]:
    """Note the times between two readings of odometry during a block, ms, by robot."""
    gaps: defaultdict[str, list[float]] = defaultdict(list)
    latest: dict[str, float] = {}

    def hear(sample: Sample) -> None:
        now = time.monotonic()
        if sample.key in latest:
            gaps[sample.key].append((now - latest[sample.key]) * 1e3)
        latest[sample.key] = now

    with ZenohBus.open(default_bus()) as bus:
        bus.subscribe(f"*/{keys.ODOM.suffix}", hear)
        yield gaps


def _longest_usual(gaps: dict[str, list[float]]) -> float:
    """Return the 95th percentile of the robot that has the largest, ms."""
    return max(percentile(each, 95) for each in gaps.values())


def _to_the_line(browser: BrowserContext) -> Iterator[Figure]:
    """From a key to the first byte of a velocity on the robot's line, and from a tab that is closed to the stop."""
    name = "bench-console"
    moments = random.Random(SEED)
    with CableRobot(name) as robot, gateway(robot.port, "--quiet", "--name", name), running_console() as (_, url):
        page = _driver(browser, url, name)
        moved = []
        for _ in range(TRIALS):
            page.wait_for_timeout(moments.uniform(150.0, 350.0))
            moved.append((_first(robot, page.evaluate(PRESS, ["keydown", "ArrowUp"]), moving=True)) * 1e3)
            _first(robot, page.evaluate(PRESS, ["keyup", "ArrowUp"]), moving=False)
        page.close()
        yield Figure(GROUP, "joystick to first byte on the line, p95", percentile(moved, 95), JOYSTICK, "ms", TRIALS)
        closed = []
        for _ in range(CLOSINGS):
            page = _driver(browser, url, name)
            page.wait_for_timeout(300.0)
            _first(robot, page.evaluate(PRESS, ["keydown", "ArrowUp"]), moving=True)
            at = time.time()
            page.close()
            closed.append(_first(robot, at, moving=False) * 1e3)
        yield Figure(GROUP, "tab closed to stop on the line, worst", max(closed), CLOSED, "ms", CLOSINGS)


def _driver(browser: BrowserContext, url: str, robot: str) -> Page:
    """Open the page of a robot, and take control."""
    page = browser.new_page()
    page.goto(f"{url}robot/{robot}")
    page.get_by_role("button", name="Take control").first.click()
    page.get_by_text("You drive.").wait_for()
    page.wait_for_timeout(500.0)
    return page


def _first(robot: CableRobot, at: float, *, moving: bool) -> float:
    """Return how long after a time, s since 1970, the first velocity came that moves the robot, or stops it."""
    offset = time.time() - time.monotonic()
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        for heard, speed in robot.velocities[-20:]:
            if heard + offset >= at and bool(speed) is moving:
                return heard + offset - at
        time.sleep(0.002)
    raise TimeoutError(f"no velocity that {'moves' if moving else 'stops'} the robot came within {PATIENCE:g} s")


@contextmanager
def running_console(*options: str) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """Run the command on the bus of the benchmarks; gives the process and the address of its pages."""
    command = [sys.executable, "-m", "acromovi", "console", "--json", "--port", "0", "--bus", default_bus(), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process, json.loads(process.stdout.readline())["console"]
        finally:
            process.terminate()

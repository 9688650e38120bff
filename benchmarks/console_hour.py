"""Memory of the console, of the browser and of a team while one page with the map is open for an hour.

Two robots drive in circles, one with a laser, and `acromovi console` shows their map to Chromium without a window.
Memory is read every 15 s, by kind of process, and of the page also the heap of JavaScript, nodes and listeners.

Memory that grows at first is not a leak, and neither is a step or the up and down of garbage. A leak grows in every
part of the run. So the first ten minutes are left out, the rest is divided into three parts, and the figure is the
least slope of the three, as in `soak`. All samples are in console-hour.csv.
"""

import argparse
import csv
import os
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import NamedTuple

from playwright.sync_api import CDPSession, sync_playwright

from benchmarks.console import PATIENCE, running_console
from benchmarks.figures import Figure
from benchmarks.processes import own_megabytes, running_team
from benchmarks.soak import slope
from benchmarks.team import driving_team, sums_by_kind

GROUP = "console_hour"
TEAM_FILE = """\
world = "office"

[[robots]]
name = "hour-laser"
model = "p3dx-sh"
fit = ["gripper", "laser"]
at_m = [2.0, 6.1]

[[robots]]
name = "hour-sonar"
model = "p3dx-sh"
at_m = [9.0, 6.1]
"""
AHEAD = 0.1  # m/s
PERIOD_S = 15.0
"""Between two samples."""
WARM_UP = 10.0  # min
PARTS = 3
GROWTH = 3.0  # MB an hour; what is less over an hour is within the noise of allocators
SHOWN = ("console", "browser", "gateways", "containers", "services", "emulator")
HEAP, NODES, LISTENERS = "page: heap of JavaScript", "page: nodes", "page: listeners"
COUNTS = 100.0  # nodes or listeners an hour
METRICS = {HEAP: ("JSHeapUsedSize", 1 / 2**20), NODES: ("Nodes", 1.0), LISTENERS: ("JSEventListeners", 1.0)}
"""Names of Chromium's, and their factor to MB or a number."""


class Row(NamedTuple):
    """One sample. time: s since the start. name: what was measured. value: MB, or a number."""

    time: float
    name: str
    value: float


def measure(options: argparse.Namespace) -> list[Figure]:
    """One run; nothing without Chromium."""
    chromium = which("chromium")
    if chromium is None:
        print("     chromium is not installed, so nothing is measured; install it with: apt install chromium")
        return []
    minutes: float = options.console_minutes
    with TemporaryDirectory() as name, sync_playwright() as playwright:
        team = Path(name) / "bench-hour.toml"
        team.write_text(TEAM_FILE, encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        with running_team(str(team)), running_console("--team", str(team)) as (_, url), driving_team(str(team), AHEAD):
            page = browser.new_page()
            page.set_default_timeout(PATIENCE * 1e3)
            page.goto(url)
            page.wait_for_selector(".c-chip")
            session = page.context.new_cdp_session(page)
            session.send("Performance.enable")
            options.out.mkdir(parents=True, exist_ok=True)
            rows = _sample(session, 60.0 * minutes, options.out / "console-hour.csv")
            browser.close()
    return figures(rows, 60.0 * min(WARM_UP, minutes / PARTS))


def figures(rows: Sequence[Row], warm_up: float) -> list[Figure]:
    """Steady growth of all that was measured, per hour; warm_up: s that are not counted."""
    series: defaultdict[str, tuple[list[float], list[float]]] = defaultdict(lambda: ([], []))
    for row in rows:
        if row.time >= warm_up:
            times, values = series[row.name]
            times.append(row.time / 3600.0)
            values.append(row.value)
    found = []
    for name, (times, values) in series.items():
        counts = name in (NODES, LISTENERS)
        reach, unit = (COUNTS, "") if counts else (GROWTH, "MB")
        what = f"{name}: growth in an hour after the first {warm_up / 60:g} min"
        found.append(Figure(GROUP, what, steady(times, values), reach, unit, len(values)))
    return found


def steady(times: Sequence[float], values: Sequence[float]) -> float:
    """Return the least slope of a value over time in the parts of a run; at least 0."""
    size = len(values) // PARTS
    parts = [slice(part * size, (part + 1) * size) for part in range(PARTS)]
    return max(0.0, min(slope(times[part], values[part]) for part in parts))


def _sample(session: CDPSession, seconds: float, file: Path) -> list[Row]:
    """Measure for some time; each sample is in the file at once, so that a run that is ended is not lost."""
    rows: list[Row] = []
    begun = due = time.monotonic()
    with file.open("w", encoding="utf-8", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(Row._fields)
        while (now := time.monotonic()) - begun < seconds:
            due += PERIOD_S
            new = [Row(now - begun, name, value) for name, value in _values(session).items()]
            writer.writerows([f"{row.time:.1f}", row.name, f"{row.value:.3f}"] for row in new)
            out.flush()
            rows += new
            time.sleep(max(0.0, due - time.monotonic()))
    return rows


def _values(session: CDPSession) -> Mapping[str, float]:
    """Return what is held now, MB or a number, by name."""
    held = sums_by_kind(os.getpid(), own_megabytes)
    told = {row["name"]: row["value"] for row in session.send("Performance.getMetrics")["metrics"]}
    page = {name: told[metric] * factor for name, (metric, factor) in METRICS.items()}
    return {**{kind: held[kind] for kind in SHOWN if kind in held}, **page}

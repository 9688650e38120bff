"""Maps of laser scans against the truth, in lockstep; writes mapping.md and a picture of each map.

Settings were tuned on office and house with seed 1, and on plan:1.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.components.mapping.mapping_tools import MapWork, sensors_of
from agents.components.mapping.settings import MappingAgentSettings
from benchmarks.figures import Figure
from benchmarks.mapping_course import Heard, spread_places, survey
from benchmarks.mapping_scores import MapScore, score, true_edges
from geometry import Pose2D, Segment, wrap_angle
from maps.building_map import BuildingMap
from p2os_emu.world import load_world

GROUP = "mapping"
WORLDS = ("office", "house", "plan:11", "plan:12", "plan:13")
SEED = 7
APART = 5.0  # m between places of worlds that name too few
FEW_PLACES = 4
HEIGHT = 0.2  # m of the scanned plane, as in configs/accessories/lms200.toml
REACH = 0.05  # share of walls that may be farther off than 4 cm
MOST_DOUBLE = 0.3  # m of lines that double a wall: some samples at corners
MOST_OFF = 0.10  # m; an open loop leaves more


@dataclass(frozen=True, slots=True)
class MapResult:
    """One map. drift: m by which odometry alone was wrong at the end. cost: s of processor time."""

    world: str
    seed: int
    driven: float
    seconds: float
    drift: float
    scans: int
    keys: int
    loops: int
    cost: float
    score: MapScore


def measure(options: argparse.Namespace) -> list[Figure]:
    """Drive through all worlds, build their maps, and judge them."""
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.map or ():
        load_world(name)  # a mistake is told before the first drive
    results = []
    for name in (*WORLDS, *(options.map or ())):
        results.append(build(name, SEED, options.out))
        print(row(results[-1]), flush=True)
        (options.out / "mapping.md").write_text(page(results), encoding="utf-8")
    inexact = max(1.0 - each.score.exact for each in results)
    count = len(results)
    return [
        Figure(GROUP, "walls farther than 4 cm from the truth, worst map", inexact, REACH, "", count),
        Figure(GROUP, "double walls, worst map", max(each.score.double for each in results), MOST_DOUBLE, "m", count),
        Figure(GROUP, "error of a pose, worst map", max(each.score.off for each in results), MOST_OFF, "m", count),
    ]


def build(name: str, seed: int, out: Path) -> MapResult:
    """Drive through a world, build its map, and draw it."""
    world = load_world(name)
    places = list(world.places.values())
    start = None
    if len(places) < FEW_PLACES or name.endswith(".map"):
        start = Pose2D(*places[0], 0.0) if places else world.starts[0]
        places = spread_places(world, (start.x, start.y), APART)
    heard = survey(world, places, seed=seed, start=start)
    work, began = work_of(heard), time.process_time()
    for message in heard.messages:
        work.read(message)
    work.refine()
    made, cost = work.map(), time.process_time() - began
    truth = true_poses(heard, [key.view.stamp for key in work.keys])
    edges = true_edges(world, heard.standing, HEIGHT)
    judged = score(made, work.keys, truth, edges)
    first, last = work.keys[0].view.pose, work.keys[-1].view.pose
    by_odometry, true = last.relative_to(first), truth[-1].relative_to(truth[0])
    progress = work.progress()
    picture = out / f"mapping-{Path(name).stem.replace(':', '-')}.png"
    draw(picture, made, judged.placed, edges, [judged.placed.compose(key.pose) for key in work.keys])
    return MapResult(
        Path(name).stem,
        seed,
        progress["driven"],
        heard.truth[-1][0],
        float(np.hypot(by_odometry.x - true.x, by_odometry.y - true.y)),
        progress["scans"],
        progress["key_scans"],
        progress["loops"],
        cost,
        judged,
    )


def work_of(heard: Heard) -> MapWork:
    """Begin a map for the robot of a drive."""
    return MapWork(sensors_of(heard.description), MappingAgentSettings.load())


def true_poses(heard: Heard, stamps: Sequence[float]) -> list[Pose2D]:
    """Return where the robot truly was at some times, s."""
    table = np.array(heard.truth)
    columns = [np.interp(stamps, table[:, 0], each) for each in (table[:, 1], table[:, 2], np.unwrap(table[:, 3]))]
    return [Pose2D(float(x), float(y), wrap_angle(float(h))) for x, y, h in zip(*columns, strict=True)]


def draw(path: Path, made: BuildingMap, placed: Pose2D, edges: Sequence[Segment], way: Sequence[Pose2D]) -> None:
    """Draw lines and points of a map over the true walls."""
    from matplotlib.figure import Figure as Page

    from maps.building.surfaces import map_at

    shown = map_at(made, placed)
    page = Page(figsize=(11, 8), layout="constrained")
    axes = page.subplots()
    for number, edge in enumerate(edges):
        label = "true walls" if number == 0 else None
        axes.plot((edge.x1, edge.x2), (edge.y1, edge.y2), color="#e3b9a0", linewidth=4.0, label=label)
    for number, line in enumerate(shown.lines):
        label = "lines of the map" if number == 0 else None
        axes.plot((line.x1, line.x2), (line.y1, line.y2), color="#202428", linewidth=1.0, label=label)
    axes.plot(*shown.points.T, ".", color="#7a4fa3", markersize=1.5, label="points of the map")
    axes.plot([p.x for p in way], [p.y for p in way], ".-", color="#4f7fb5", linewidth=0.5, markersize=2, label="way")
    axes.set_aspect("equal")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.05), ncols=4, frameon=False)
    page.savefig(path, dpi=80, bbox_inches="tight")


def row(result: MapResult) -> str:
    """Return a row of the table."""
    judged = result.score
    cells = (
        result.world,
        f"{result.seed}",
        f"{result.driven:.0f} m, {result.seconds:.0f} s",
        f"{result.drift:.2f} m",
        f"{result.keys} of {result.scans}",
        f"{result.loops}",
        f"{judged.exact:.1%}",
        f"{judged.complete:.1%}",
        f"{judged.double:.2f} m",
        f"{100.0 * judged.off:.1f} cm",
        f"{result.cost:.0f} s",
    )
    return f"| {' | '.join(cells)} |"


HEAD = (
    "world",
    "seed",
    "drive",
    "odometry alone off by",
    "key scans",
    "loops",
    "within 4 cm",
    "complete",
    "double",
    "worst pose",
    "processor time",
)


def page(results: Sequence[MapResult]) -> str:
    """Return the page with all maps."""
    lines = ["# Maps of laser scans", "", f"| {' | '.join(HEAD)} |", f"|{' --- |' * len(HEAD)}"]
    lines += [row(each) for each in results]
    lines += ["", *(f"![{each.world}](mapping-{each.world.replace(':', '-')}.png)" for each in results)]
    return "\n".join(lines) + "\n"

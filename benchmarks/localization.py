"""Localization in lockstep, from recorded drives; writes localization.md and pictures."""

import argparse
import math
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from random import Random

import numpy as np

from benchmarks.figures import Figure, percentile
from benchmarks.localization_drives import Drive, map_of_world, record
from benchmarks.localization_plots import draw_errors, draw_path
from geometry import Pose2D, wrap_angle
from maps.building_map import BuildingMap
from maps.localization.likelihood_field import LikelihoodField
from maps.localization.localizer import LocalizationState, Localizer
from maps.localization.settings import LocalizationSettings
from p2os_emu.world import load_world

GROUP = "localization"
LONG = 1800.0  # s of the drive with a known start
LONG_SEED = 40  # settings were tuned on seeds 1 and 2, and on the plans 11 and 12
UNKNOWN = (("plan:41", 41), ("plan:42", 42), ("hall:43", 43), ("office", 44), ("skew:45", 45))
"""World and seed of the drives from which unknown starts are taken."""
STARTS, WINDOW, DRIVE = 20, 15.0, 160.0
"""Unknown starts in each drive, s that each may take, and s of the drive."""
WRONG = (("plan:41", "office"), ("office", "plan:42"), ("hall:43", "plan:41"), ("plan:42", "hall:43"))
"""Building, and the map that is given for it."""
WRONG_STARTS = 5
ODOMETRY_ERROR = 0.0075  # of distances and of turns, beside the errors of the emulated robot
NEAR, TURNED = 0.5, math.radians(10.0)  # m and rad: farther off, a pose is wrong
LATENESS = 0.03  # s by which scans come later than odometry


@dataclass(frozen=True, slots=True)
class TracedPose:
    """One step. time: s. error: m. turn: rad. guess: where it is believed to be, None without a guess."""

    time: float
    state: LocalizationState
    guess: Pose2D | None
    true: Pose2D
    error: float
    turn: float

    @property
    def is_wrong(self) -> bool:
        """Whether a wrong pose is believed."""
        return self.state is LocalizationState.LOCALIZED and (self.error > NEAR or self.turn > TURNED)


@dataclass(frozen=True, slots=True)
class UnknownStart:
    """What became of an unknown start. found: s until it was localized, None if never."""

    world: str
    begin: float
    found: float | None
    is_right: bool
    was_wrong: bool


def measure(options: argparse.Namespace) -> list[Figure]:
    """Record the drives, localize on them, and judge by the truth."""
    options.out.mkdir(parents=True, exist_ok=True)
    office = load_world("office")
    office_map = map_of_world(office)
    drive = record(office, LONG, LONG_SEED)
    traces = {sensor: list(trace(office_map, drive, sensor)) for sensor in ("laser", "sonar")}
    draw_path(office_map, traces["laser"], traces["sonar"], options.out / "localization-office.svg")
    draw_errors(traces, options.out / "localization-errors.svg")
    drives = {name: record(load_world(name), DRIVE, seed) for name, seed in UNKNOWN}
    maps = {name: map_of_world(load_world(name)) for name in drives}
    starts = [start for name, each in drives.items() for start in _unknown_starts(name, maps[name], each)]
    wrong = [late for building, given in WRONG for late in _wrong_maps(maps[given], drives[building])]
    count = len(starts)
    figures = [
        *_accuracy("laser", traces["laser"], 0.03, 0.7, 0.08, 2.0),
        *_accuracy("sonar", traces["sonar"], 0.15, 4.0, None, None),
        Figure(GROUP, "unknown starts not found within 15 s", _missed(starts), 0.03, "share", count),
        Figure(
            GROUP, "unknown starts with a wrong pose believed", sum(s.was_wrong for s in starts), 0, "", len(starts)
        ),
        Figure(GROUP, "wrong maps not reported within 10 s", _late(wrong), 0, "", len(wrong)),
        Figure(GROUP, "one update, 2000 particles, 181 beams", _update_time(office_map), 6.0, "ms", 50),
    ]
    (options.out / "localization.md").write_text(page(figures, starts, wrong), encoding="utf-8")
    return figures


def trace(
    map_: BuildingMap, drive: Drive, sensor: str, begin: float = 0.0, end: float = math.inf, *, is_known: bool = True
) -> Iterator[TracedPose]:
    """Localize on a part of a drive; yields a step for each odometry.

    Args:
        map_: On which.
        drive: With what the sensors said.
        sensor: `laser` or `sonar`.
        begin, end: Of the part, s.
        is_known: Whether the localization begins at the true pose, 0.1 m and 3 degrees off.
    """
    localizer = Localizer(map_, LocalizationSettings.load())
    odometry = np.array(drive.odometry)
    steps = list(_with_errors(odometry))
    ranges = [(at + LATENESS, kind, at, ends) for kind, at, ends in _ranges(drive, sensor) if begin <= at < end]
    ranges.reverse()
    has_begun = False
    for row, pose in zip(drive.odometry, steps, strict=True):
        if not begin <= row[0] < end:
            continue
        while ranges and ranges[-1][0] <= row[0]:
            _, kind, at, ends = ranges.pop()
            (localizer.add_scan if kind == "laser" else localizer.add_sonar)(at, ends)
            localizer.advance()
        localizer.add_odometry(row[0], pose)
        true = Pose2D(*row[4:7])
        if not has_begun:
            has_begun = True
            if is_known:
                localizer.start_at(true.compose(Pose2D(0.08, -0.06, 0.05)))
            else:
                localizer.start_unknown()
        localizer.advance()
        guess = localizer.estimate.pose
        error = math.dist((guess.x, guess.y), (true.x, true.y)) if guess else math.inf
        turn = abs(wrap_angle(guess.heading - true.heading)) if guess else math.inf
        yield TracedPose(row[0], localizer.state, guess, true, error, turn)


def _ranges(drive: Drive, sensor: str) -> Iterator[tuple[str, float, np.ndarray]]:
    return ((sensor, at, ends) for at, ends in (drive.scans if sensor == "laser" else drive.sonar))


def _with_errors(odometry: np.ndarray) -> Iterator[Pose2D]:
    """The poses of odometry if it measured distances too long and turns too short."""
    poses = [Pose2D(*row) for row in odometry[:, 1:4].tolist()]
    pose = poses[0]
    yield pose
    for before, after in pairwise(poses):
        step = after.relative_to(before)
        longer, less = 1.0 + ODOMETRY_ERROR, 1.0 - ODOMETRY_ERROR
        pose = pose.compose(Pose2D(longer * step.x, longer * step.y, less * step.heading))
        yield pose


def _unknown_starts(name: str, map_: BuildingMap, drive: Drive) -> Iterator[UnknownStart]:
    rng = Random(f"unknown {name}")
    for _ in range(STARTS):
        begin = drive.odometry[0][0] + rng.uniform(1.0, drive.seconds - WINDOW - 1.0)
        steps = list(trace(map_, drive, "laser", begin, begin + WINDOW, is_known=False))
        found = next((step.time - begin for step in steps if step.state is LocalizationState.LOCALIZED), None)
        is_right = steps[-1].state is LocalizationState.LOCALIZED and not steps[-1].is_wrong
        yield UnknownStart(name, begin, found, is_right, any(step.is_wrong for step in steps))


def _wrong_maps(map_: BuildingMap, drive: Drive) -> Iterator[float | None]:
    """s of driving until a wrong map is reported; None if that is not so after 12 s."""
    rng = Random(f"wrong {drive.seconds}")
    for _ in range(WRONG_STARTS):
        begin = drive.odometry[0][0] + rng.uniform(1.0, drive.seconds - WINDOW - 1.0)
        driven, before = 0.0, None
        late = None
        for step in trace(map_, drive, "laser", begin, begin + WINDOW, is_known=False):
            if before is not None and math.dist((step.true.x, step.true.y), (before.true.x, before.true.y)) > 0.004:
                driven += step.time - before.time
            before = step
            if step.state is LocalizationState.WRONG_MAP:
                late = driven
                break
        yield late


def _accuracy(
    sensor: str, steps: Sequence[TracedPose], mean: float, turn: float, worst: float | None, worst_turn: float | None
) -> Iterator[Figure]:
    known = [step for step in steps if step.state is LocalizationState.LOCALIZED]
    errors, turns = [100.0 * step.error for step in known], [math.degrees(step.turn) for step in known]
    about = f"{sensor}, office, {(steps[-1].time - steps[0].time) / 60.0:.0f} min"
    yield Figure(GROUP, f"{about}: mean error", statistics.mean(errors), 100.0 * mean, "cm", len(known))
    yield Figure(GROUP, f"{about}: mean error of the heading", statistics.mean(turns), turn, "deg", len(known))
    if worst is not None and worst_turn is not None:
        yield Figure(GROUP, f"{about}: p99", percentile(errors, 99), 100.0 * worst, "cm", len(known))
        yield Figure(GROUP, f"{about}: p99 of the heading", percentile(turns, 99), worst_turn, "deg", len(known))
    lost = 1.0 - len(known) / len(steps)
    yield Figure(GROUP, f"{about}: share of the time not localized", lost, 0.02, "share", len(steps))


def _missed(starts: Sequence[UnknownStart]) -> float:
    return sum(not start.is_right for start in starts) / len(starts)


def _late(wrong: Sequence[float | None]) -> int:
    return sum(late is None or late > 10.0 for late in wrong)


def _update_time(map_: BuildingMap) -> float:
    """Median ms of processor time of one update."""
    settings = LocalizationSettings.load().field
    costs = LikelihoodField(map_, settings.cell).costs(settings.laser_sigma, settings.clutter)
    rng = np.random.default_rng(0)
    poses = rng.uniform((0.0, 0.0, -3.0), (16.0, 12.0, 3.0), (2000, 3))
    ends = rng.normal(0.0, 3.0, (181, 2)).astype(np.float32)
    times = []
    for _ in range(50):
        began = time.process_time()
        costs.of(poses, ends)
        times.append(1000.0 * (time.process_time() - began))
    return statistics.median(times)


def page(figures: Sequence[Figure], starts: Sequence[UnknownStart], wrong: Sequence[float | None]) -> str:
    """The table, and every start."""
    lines = ["# Localization", "", "| figure | value | target | samples |", "|---|---|---|---|"]
    lines += [f"| {f.name} | {f.value:.3g} {f.unit} | {f.reach:g} {f.unit} | {f.samples} |" for f in figures]
    lines += ["", "| world | from s | localized after s | right at the end | a wrong pose was believed |"]
    lines += ["|---|---|---|---|---|"]
    for start in starts:
        found = "never" if start.found is None else f"{start.found:.1f}"
        said = ["no", "yes"]
        lines.append(
            f"| {start.world} | {start.begin:.0f} | {found} | {said[start.is_right]} | {said[start.was_wrong]} |"
        )
    reports = ", ".join("not" if late is None else f"{late:.1f}" for late in wrong)
    lines += ["", f"Wrong maps reported after s of driving: {reports}.", ""]
    return "\n".join(lines)

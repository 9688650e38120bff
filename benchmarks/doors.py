"""Doors in generated scans: how many are found and how well, how long a scan takes; a naive detector beside."""

import argparse
import time
from itertools import pairwise
from math import atan2, hypot, pi

import numpy as np

from apps.indoor_navigation.algorithms.doors import find_doors
from apps.indoor_navigation.algorithms.opening import DoorParameters
from apps.indoor_navigation.data import Door, LaserRead
from apps.indoor_navigation.parameters import shipped_parameters
from benchmarks.door_scans import Case, cases
from benchmarks.door_scores import Score, score
from benchmarks.figures import Figure, p50_p99, percentile
from geometry import Pose2D

GROUP = "doors"
FIRST_SEED = 110_000_000  # nothing was tuned on these
SCANS = 4000
LOOKS = 3  # at each scan, for the time that it takes
WARM_UP = 500  # scans
MEDIAN_MS, P99_MS = 0.4, 1.0
PRECISION, RECALL = 0.98, 0.97
CENTRE, WIDTH = 0.05, 0.06  # m, of 95 % of the doors that were found

NAIVE_JUMP = 0.5  # m from one beam to the next that begins or ends a gap


def measure(options: argparse.Namespace) -> list[Figure]:
    """Score both detectors on the same scans, and time ours."""
    scans = list(cases(FIRST_SEED, SCANS))
    ours, naive = (
        score(lambda scan: find_doors(scan, shipped_parameters("dle_detecting")), scans),
        score(find_gaps, scans),
    )
    _print_table(ours, naive, scans)
    found = ours.found + ours.missed
    figures = [
        Figure(GROUP, "doors invented, of those found", 1.0 - ours.precision, 1.0 - PRECISION, "", ours.found),
        Figure(GROUP, "doors missed, of those well in view", 1.0 - ours.recall, 1.0 - RECALL, "", found),
        Figure(GROUP, "a door's centre from the true one, p95", percentile(ours.off, 95), CENTRE, "m", ours.found),
        Figure(GROUP, "a door's width from the true one, p95", percentile(ours.width_off, 95), WIDTH, "m", ours.found),
    ]
    milliseconds, first = _times([case.scan for case in scans])
    median = percentile(milliseconds, 50)
    print(f"     the quickest scan took {min(milliseconds):.3f} ms, {min(milliseconds) / median:.2f} of the median;")
    p50, p99 = percentile(first, 50), percentile(first, 99)
    print(f"     at the first look, with whatever else the machine did: p50 {p50:.3f} ms, p99 {p99:.3f} ms")
    name = f"one scan of 361 beams, best of {LOOKS} looks at it"
    return [*figures, *p50_p99(GROUP, name, milliseconds, (MEDIAN_MS, P99_MS), "ms")]


def find_gaps(scan: LaserRead) -> tuple[Door, ...]:
    """What a naive detector takes for doors: where the range jumps out and in again, as far apart as a door is wide.

    What lies between must be a metre farther than the nearer of the two jambs.
    """
    parameters = shipped_parameters("dle_detecting")
    ranges = np.minimum(scan.ranges, scan.range_max)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    steps = np.diff(ranges)
    jumps = [(int(at), bool(steps[at] > 0.0)) for at in np.flatnonzero(np.abs(steps) > NAIVE_JUMP)]
    scanner, doors = Pose2D(*scan.pose).compose(Pose2D(*scan.mount)), []
    for (out, is_out), (back, is_out_again) in pairwise(jumps):
        if not is_out or is_out_again:
            continue
        x1, y1 = ranges[out] * np.cos(angles[out]), ranges[out] * np.sin(angles[out])
        x2, y2 = ranges[back + 1] * np.cos(angles[back + 1]), ranges[back + 1] * np.sin(angles[back + 1])
        width, jamb = hypot(x2 - x1, y2 - y1), min(ranges[out], ranges[back + 1])
        if (
            not parameters.narrowest <= width <= parameters.widest
            or ranges[out + 1 : back + 1].min() < jamb + parameters.clear
        ):
            continue
        x, y = scanner.transform((x1 + x2) / 2.0, (y1 + y2) / 2.0)
        normal = scanner.heading + atan2(y2 - y1, x2 - x1) - pi / 2.0
        doors.append(Door(x, y, width, atan2(np.sin(normal), np.cos(normal)), 1.0))
    return tuple(doors)


def _times(scans: list[LaserRead]) -> tuple[list[float], list[float]]:
    """Milliseconds by the clock that each scan takes: the least of some looks, and the first look.

    The least is the cost of the computation; what others do on the same core meanwhile disturbs hardly all looks.
    """
    parameters = shipped_parameters("dle_detecting")
    for scan in scans[:WARM_UP]:
        find_doors(scan, parameters)
    looks = [[_time(scan, parameters) for _ in range(LOOKS)] for scan in scans]
    return [min(each) for each in looks], [each[0] for each in looks]


def _time(scan: LaserRead, parameters: DoorParameters) -> float:
    began = time.perf_counter()
    find_doors(scan, parameters)
    return 1e3 * (time.perf_counter() - began)


def _print_table(ours: Score, naive: Score, scans: list[Case]) -> None:
    well = sum(sight.is_sure for case in scans for sight in case.sights)
    print(f"     {len(scans)} scans, {well} doors well in view")
    print("     detector   precision  recall  centre p95  width p95  centre < 5 cm  width < 6 cm  others found")
    for name, each in (("ours", ours), ("naive", naive)):
        near, wide = np.mean(np.array(each.off) < CENTRE), np.mean(np.array(each.width_off) < WIDTH)
        print(
            f"     {name:<9}  {each.precision:9.3f}  {each.recall:6.3f}  {percentile(each.off, 95):8.3f} m"
            f"  {percentile(each.width_off, 95):7.3f} m  {near:13.3f}  {wide:12.3f}  {each.neither:12d}"
        )

"""`acromovi missions`: run navigation missions faster than real time, and judge them by the true state."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from acromovi.missions.matrix import Instead, Result, play, play_all
from acromovi.missions.page import page
from acromovi.missions.picture import draw_mission
from acromovi.missions.tasks import ROBOTS, SEEDS, Case, Condition, Job
from acromovi.subcommand import Subcommand
from configs.extras import require

EPILOG = """\
examples:
  acromovi missions --case rooms --condition people --seed 7 --picture /tmp/mission.png
  acromovi missions --smoke                 a few missions of all kinds
  acromovi missions --all --out bench       all three hundred, with a table

Exit codes: 0 all reached and nothing touched, 1 not, 2 wrong usage.
"""
SMOKE = (
    (Case.ROOM, Condition.STATIC, 0),
    (Case.CORRIDOR, Condition.ERROR, 1),
    (Case.ROOM, Condition.OBSTACLES, 3),
    (Case.ROOMS, Condition.PEOPLE, 0),
)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--case", type=Case, choices=list(Case), default=Case.ROOM, help="set the case of the goal [room]"
    )
    parser.add_argument(
        "--condition",
        type=Condition,
        choices=list(Condition),
        default=Condition.STATIC,
        help="set the conditions [static]",
    )
    parser.add_argument("--seed", type=int, default=0, help="set the seed of the random generator [0]")
    parser.add_argument(
        "--robot", default="", metavar="MODEL", help=f"set the model [by the seed, of {', '.join(ROBOTS)}]"
    )
    parser.add_argument("--world", default="", help="set the world [by the seed, the house or a generated plan]")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the mission, as PNG or SVG by the ending")
    parser.add_argument("--smoke", action="store_true", help="run a few missions of all kinds")
    parser.add_argument("--all", action="store_true", help="run the whole matrix")
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"with --all: set the number of seeds [{SEEDS}]")
    parser.add_argument(
        "--out", type=Path, default=Path("bench"), help="with --all: set the folder for the table [bench]"
    )


def _run(options: argparse.Namespace) -> int:
    """Run the requested missions."""
    if options.robot and options.robot not in ROBOTS:
        print(f"acromovi missions: --robot must be one of {', '.join(ROBOTS)}", file=sys.stderr)
        return 2
    if options.picture or options.all:
        require("a picture of missions", "plots")
    if options.smoke or options.all:
        jobs = Job.matrix(range(options.seeds)) if options.all else [Job.of(*row) for row in SMOKE]
        results = play_many(jobs)
        if options.all:
            options.out.mkdir(parents=True, exist_ok=True)
            (options.out / "missions.md").write_text(page(results), encoding="utf-8")
            print(f"see {options.out}/missions.md")
        return 0 if all(result.is_good for result in results) else 1
    job = Job.of(options.case, options.condition, options.seed, options.robot, options.world)
    result = play(job)
    _tell(result)
    if options.picture is not None:
        draw_mission(options.picture, result)
    return 0 if result.is_good else 1


def play_many(jobs: Sequence[Job], instead: Instead | None = None) -> list[Result]:
    """Run missions on all cores, and print the progress."""
    began, good = time.monotonic(), []

    def told(result: Result) -> None:
        good.append(result.is_good)
        job = result.job
        mark = "ok  " if result.is_good else "FAIL"
        name = f"{job.case} {job.condition} {job.seed} {job.robot} {job.world}"
        so_far = f"{len(good)}/{len(jobs)} {time.monotonic() - began:.0f} s, {good.count(False)} failed"
        print(f"{mark} {name:<48} {so_far}", flush=True)

    return play_all(jobs, told, instead=instead)


def _tell(result: Result) -> None:
    verdict = result.verdict
    print(f"{result.job.robot} in {result.job.world}")
    for line in (*result.told, *result.reports):
        print(f"  {line}")
    if verdict is None:
        print(result.error)
        return
    print("reached" if verdict.reached else f"not reached: {verdict.why_not}")
    for what in verdict.touched:
        print(f"touched {what}")
    print(f"{verdict.length:.2f} m in {verdict.seconds:.1f} s, {verdict.over_shortest:.2f} of the shortest way")
    print(f"{verdict.off:.2f} m from the goal, odometry off by {verdict.odometry_off:.2f} m")
    print(f"{verdict.turned:.2f} rad/m, {verdict.turns:.2f} turns/m, jerk {verdict.jerk:.2f} m/s3")


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

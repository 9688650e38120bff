"""`acromovi missions`: run navigation missions faster than real time, and judge them by the true state."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import configs
from acromovi.missions.fresh import FreshMission, FreshScore, fresh_missions, fresh_seed
from acromovi.missions.fresh_page import fresh_page
from acromovi.missions.jobs import ROBOTS, SEEDS, Case, Condition, Job
from acromovi.missions.matrix import Instead, M, Result, play, play_all
from acromovi.missions.mission_file import FileMission, read_missions
from acromovi.missions.page import page
from acromovi.missions.picture import draw_mission
from acromovi.missions.report import as_json, in_words, summary, summary_in_words
from acromovi.missions.results_file import ResultsFile
from acromovi.options import count
from acromovi.subcommand import Subcommand
from configs import ConfigError
from configs.extras import require

EPILOG = """\
examples:
  acromovi missions --case rooms --condition people --seed 7 --picture /tmp/mission.png
  acromovi missions --smoke                 a few missions of all kinds
  acromovi missions --all --out bench       all three hundred, with a table
  acromovi missions --file my-floor.jsonl --pictures seen     missions on a floor of your own
  acromovi missions --fresh --out bench     floors that nobody has seen, of all families, with a table

A line of such a file is one mission, in m and rad:
  {"world": "floor.toml", "robot": "powerbot", "fit": ["laser"], "start": [0, 0, 1.57], "goal": [6.5, 3], "seed": 1}

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
        "--robot",
        default="",
        metavar="MODEL",
        help=f"set the model, with a laser [by the seed, of {', '.join(ROBOTS)}]",
    )
    parser.add_argument("--no-laser", action="store_true", help="let the robot navigate by sonar alone")
    parser.add_argument("--world", default="", help="set the world [by the seed, the house or a generated plan]")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the mission, as PNG or SVG by the ending")
    parser.add_argument(
        "--file", type=Path, metavar="MISSIONS.jsonl", help="play the missions of a file, one JSON object a line"
    )
    parser.add_argument("--line", type=int, help="with --file: play the mission of this line only")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="with --file: draw each mission into this folder")
    parser.add_argument("--workers", type=int, help="set how many missions are played at once [one for each core]")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--json", action="store_true", help="with --file: print a line of JSON for each, and a summary")
    how.add_argument("--quiet", action="store_true", help="with --file: print the summary only")
    parser.add_argument("--smoke", action="store_true", help="run a few missions of all kinds")
    parser.add_argument("--all", action="store_true", help="run the whole matrix")
    parser.add_argument(
        "--fresh",
        nargs="?",
        type=int,
        const=-1,
        metavar="SEED",
        help="run missions on generated floors of all families, by this seed [a new one each time]",
    )
    parser.add_argument(
        "--floors", type=count, default=1, help="with --fresh: set the floors for each family and robot [1]"
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="with --fresh SEED: go on with a run that was interrupted, of the same --out",
    )
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"with --all: set the number of seeds [{SEEDS}]")
    parser.add_argument(
        "--out", type=Path, default=Path("bench"), help="with --all and --fresh: set the folder for the table [bench]"
    )


def _run(options: argparse.Namespace) -> int:
    """Run the requested missions."""
    if options.workers is not None and options.workers < 1:
        return _refuse("--workers must be 1 or more")
    if options.file is not None:
        return _run_file(options)
    if options.line is not None or options.pictures is not None or options.json or options.quiet:
        return _refuse("--line, --pictures, --json and --quiet are for missions of a --file")
    if options.fresh is not None:
        return _run_fresh(options)
    if options.resume:
        return _refuse("--resume is for a run with --fresh SEED")
    if options.picture or options.all:
        require("a picture of missions", "plots")
    return _run_matrix(options) if options.smoke or options.all else _run_one(options)


def _run_matrix(options: argparse.Namespace) -> int:
    """Play the whole matrix and write its table, or a few missions of it."""
    jobs = Job.matrix(range(options.seeds)) if options.all else [Job.of(*row) for row in SMOKE]
    results = play_many(jobs, processes=options.workers)
    if options.all:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "missions.md").write_text(page(results), encoding="utf-8")
        print(f"see {options.out}/missions.md")
    return 0 if all(result.is_good for result in results) else 1


def _run_one(options: argparse.Namespace) -> int:
    """Play one mission, and draw it if a picture is wanted."""
    try:
        configs.find("robots", options.robot or ROBOTS[0])
    except ConfigError as err:
        return _refuse(f"--robot: {err}")
    job = Job.of(options.case, options.condition, options.seed, options.robot, options.world)
    job = replace(job, has_laser=not options.no_laser)
    result = play(job)
    _tell(result)
    if options.picture is not None:
        draw_mission(options.picture, result)
    return 0 if result.is_good else 1


def _run_fresh(options: argparse.Namespace) -> int:
    """Play missions on floors that nobody has seen, and write the table and a picture of every failure."""
    require("pictures of missions", "plots")
    if options.resume and options.fresh < 0:
        return _refuse("--resume needs the seed of the run that was interrupted, as in --fresh 7 --floors 2 --resume")
    seed = fresh_seed() if options.fresh < 0 else options.fresh
    print(f"the same missions again: acromovi missions --fresh {seed} --floors {options.floors}")
    print("after an interruption, the same command with --resume goes on", flush=True)
    missions = fresh_missions(seed, options.floors)
    pictures = {mission: f"fresh-{number:03}.png" for number, mission in enumerate(missions)}
    try:
        kept = ResultsFile(options.out / "fresh.jsonl", FreshScore, resume=options.resume)
    except ConfigError as err:
        return _refuse(str(err))
    with kept:
        scores = {score.job: score for score in kept.earlier}

        def keep(result: Result[FreshMission]) -> None:
            scores[result.job] = FreshScore.of(result)
            kept.add([scores[result.job]])
            if result.verdict is not None and not result.is_good:
                draw_mission(options.out / pictures[result.job], result)

        play_many([each for each in missions if each not in scores], processes=options.workers, on_result=keep)
    played = [scores[mission] for mission in missions]
    failed = [score for score in played if score.has_room and not score.is_good]
    shown = [pictures[score.job] for score in failed if score.verdict is not None]
    (options.out / "fresh.md").write_text(fresh_page(played, seed, shown), encoding="utf-8")
    print(f"see {options.out}/fresh.md")
    return 1 if failed else 0


def _run_file(options: argparse.Namespace) -> int:
    """Play the missions of a file, and report them in its order as soon as they have ended."""
    try:
        missions = read_missions(options.file)
    except ConfigError as err:
        return _refuse(str(err))
    if options.line is not None:
        missions = [mission for mission in missions if mission.line == options.line]
        if not missions:
            return _refuse(f"{options.file} has no mission in line {options.line}")
    if options.pictures is not None:
        require("a picture of missions", "plots")
        options.pictures.mkdir(parents=True, exist_ok=True)
    ended: dict[int, Result[FileMission]] = {}
    waiting = [mission.line for mission in missions]

    def told(result: Result[FileMission]) -> None:
        ended[result.job.line] = result
        while waiting and waiting[0] in ended:
            _report(ended[waiting.pop(0)], options)
        if sys.stderr.isatty() and waiting:
            print(f"{len(ended)} of {len(missions)} played", end="\r", file=sys.stderr, flush=True)

    results = play_all(missions, told, processes=options.workers)
    print(json.dumps({"summary": summary(results)}) if options.json else summary_in_words(results))
    return 0 if all(result.is_good for result in results) else 1


def _report(result: Result[FileMission], options: argparse.Namespace) -> None:
    if options.json:
        print(json.dumps(as_json(result)), flush=True)
    elif not options.quiet:
        print(in_words(result), flush=True)
    if options.pictures is not None:
        draw_mission(options.pictures / f"{options.file.stem}-{result.job.line:03}.png", result)
    if "Traceback" in result.error:
        print(result.error, file=sys.stderr)


def _refuse(why: str) -> int:
    print(f"acromovi missions: {why}", file=sys.stderr)
    return 2


def play_many(
    jobs: Sequence[M],
    instead: Instead | None = None,
    processes: int | None = None,
    on_result: Callable[[Result[M]], None] = lambda result: None,
) -> list[Result[M]]:
    """Run missions on all cores, and print the progress; `on_result` is told of each as it ends."""
    began, good = time.monotonic(), []

    def told(result: Result[M]) -> None:
        good.append(result.is_good or not result.has_room)
        mark = ("ok  " if result.is_good else "FAIL") if result.has_room else "none"
        so_far = f"{len(good)}/{len(jobs)} {time.monotonic() - began:.0f} s, {good.count(False)} failed"
        print(f"{mark} {result.job.name:<48} {so_far}", flush=True)
        on_result(result)

    return play_all(jobs, told, processes, instead)


def _tell(result: Result[Job]) -> None:
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

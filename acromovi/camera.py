"""`acromovi camera calibrate`: measure the lens of a camera by views of a chessboard."""

import argparse
import json
import sys
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict
from math import atan, degrees
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.camera_sources import VIDEOS, Shot, files_of, live_shots, robot_of, shots_of_files
from acromovi.options import add_bus, count, seconds
from acromovi.subcommand import Subcommand
from configs.camera_calibration import CameraCalibration
from configs.loader import ConfigError
from configs.team_edit import write_calibration
from configs.team_file import read_team

if TYPE_CHECKING:  # it loads OpenCV
    from vision.calibration import CalibrationViews

VIEWS = 12
TIME = 300.0  # s
NAMED = 5  # images not used, in an error
EPILOG = f"""\
examples:
  acromovi camera calibrate views/*.png --board 9x6
      print the model of the camera that took these images
  acromovi camera calibrate views/*.png --board 9x6 --into my-team.toml doc
      write it into the team file as well, as camera_calibration of the robot doc
  acromovi camera calibrate doc --board 9x6 --into my-team.toml doc
      use the live camera of the robot doc, and print which views are missing
  acromovi camera calibrate http://10.0.0.7:8080/stream --board 9x6

Print a chessboard, and glue it to something flat. 9x6 are its inner corners, one less than squares. Show it at many
places, near all edges of the image, and slanted by 20 to 40 degrees to all sides. Hold it still, or leave it in its
place and move the robot. A camera that zooms is calibrated at its widest zoom.

A source is an image, a video ({", ".join(VIDEOS)}), ROBOT or ROBOT/camera on the bus, or a camera's URL or device. A
live camera is used until the views suffice.

With --json one object is printed: width, height, fx, fy, cx, cy in px, distortion (k1, k2, p1, p2, k3), error_px, used,
not_used with the reason for each image, and advice.

Exit codes: 0 calibrated, 1 not (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="calibrate", required=True)
    summary = "measure the lens of a camera by views of a chessboard"
    calibrate = actions.add_parser(
        "calibrate",
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.",
        epilog=EPILOG,
        formatter_class=parser.formatter_class,
        allow_abbrev=False,
    )
    calibrate.add_argument(
        "sources", metavar="SOURCE", nargs="+", help="images, a video, ROBOT[/camera], or a camera's URL or device"
    )
    calibrate.add_argument(
        "--board", metavar="COLUMNSxROWS", type=_board, default=(9, 6), help="set the inner corners of the board [9x6]"
    )
    calibrate.add_argument(
        "--square", metavar="M", type=float, default=0.025, help="set the side of a square [%(default)g m]"
    )
    calibrate.add_argument(
        "--into", nargs=2, metavar=("TEAM.toml", "ROBOT"), help="write the result into a team file, for ROBOT[/camera]"
    )
    calibrate.add_argument(
        "--views", metavar="N", type=count, default=VIEWS, help="set how many live views to collect [%(default)d]"
    )
    calibrate.add_argument(
        "--timeout", metavar="S", type=seconds, default=TIME, help="set the time to collect them [%(default)g s]"
    )
    calibrate.add_argument("--json", action="store_true", help="print one JSON object")
    calibrate.add_argument("--quiet", action="store_true", help="print no progress")
    add_bus(calibrate)


def _run(arguments: argparse.Namespace) -> int:
    """Calibrate, print the result, and write it."""
    from configs.extras import require

    require("acromovi camera", "vision")
    from agents.client.errors import RobotError
    from cameras import CameraError
    from vision.calibration import CalibrationViews, Chessboard
    from vision.image import VisionError

    into = None if arguments.into is None else _target(*arguments.into)
    try:
        columns, rows = arguments.board
        views = CalibrationViews(Chessboard(columns, rows, arguments.square))
        not_used = _collect(arguments, views)
        try:
            result = views.solve()
        except VisionError as err:
            reasons = "".join(f"\n  {name} {why}" for name, why in list(not_used.items())[:NAMED])
            more = f"\n  and {len(not_used) - NAMED} more" if len(not_used) > NAMED else ""
            raise VisionError(f"{err}{reasons}{more}") from err
    except (VisionError, RobotError, CameraError) as err:
        print(f"acromovi camera: {err}", file=sys.stderr)
        return 1
    model = result.model
    size, matrix = (model.width, model.height), (model.fx, model.fy, model.cx, model.cy)
    k1, k2, p1, p2, k3 = model.distortion.tolist()
    calibration = CameraCalibration(*size, *matrix, (k1, k2, p1, p2, k3), result.error)
    if into is not None:
        write_calibration(*into, calibration)
    if arguments.json:
        about = {"used": result.used, "not_used": not_used, "advice": result.advice}
        print(json.dumps({**asdict(calibration), **about}))
        return 0
    _print(calibration, len(result.used), not_used, result.advice)
    if into is not None:
        print(f"written into {into[0]} for {into[1]}; its gateway uses it when the team is started again")
    return 0


def _target(team: str, robot: str) -> tuple[Path, str]:
    """Return team file and robot, after both were found: before somebody shows a chessboard in vain.

    Raises:
        ConfigError: There is no such file or robot.
    """
    name = robot_of(robot)
    if not Path(team).is_file():
        raise ConfigError(f"there is no team file {team}; --into takes a file of your own")
    names = [each.name for each in read_team(team).robots]
    if name not in names:
        raise ConfigError(f"{team}: there is no robot {name!r} in this team; its robots are {', '.join(names)}")
    return Path(team), name


def _collect(arguments: argparse.Namespace, views: "CalibrationViews") -> dict[str, str]:
    """Take images until there are no more, or live ones suffice; returns why images of files are not used."""
    tell: Callable[[str], None] = _ignore if arguments.quiet else _report
    not_used = {}
    files = files_of(arguments.sources)
    for shot in shots_of_files(files):
        why = views.add(*shot[:2], is_live=shot.is_live)
        if not shot.is_live:  # the images of a video are too many to tell of each
            tell(f"{shot.name} {why or 'is used'}")
            if why:
                not_used[shot.name] = why
    if files:
        return not_used
    until, told = time.monotonic() + arguments.timeout, ""
    with closing(live_shots(arguments.sources[0], arguments.bus, tell)) as shots:
        for shot in shots:
            words = _looked(shot, views, arguments.views)
            if words != told:
                tell(words)
                told = words
            if not views.missing(arguments.views):
                return {}
            if time.monotonic() > until:
                tell(f"the {arguments.timeout:g} s are over; --timeout gives more")
                return {}
    return {}


def _looked(shot: Shot, views: "CalibrationViews", wanted: int) -> str:
    """Look at a live image; returns what there is and what is missing, in words."""
    why = views.add(*shot[:2], is_live=True)
    missing = views.missing(wanted)
    there = f"{len(views)} views; missing: {', '.join(missing)}" if missing else f"{len(views)} views, which suffice"
    return f"{there} (the image {why})" if why else there


def _print(found: CameraCalibration, used: int, not_used: dict[str, str], advice: str) -> None:
    print(f"{used} images of {found.width} x {found.height} px, error {found.error_px:.2f} px")
    print(f"focal lengths {found.fx:.1f} and {found.fy:.1f} px, centre ({found.cx:.1f}, {found.cy:.1f})")
    print("distortion " + ", ".join(f"{each:.4f}" for each in found.distortion))
    print(f"horizontal field of view {degrees(2.0 * atan(found.width / 2.0 / found.fx)):.1f} degrees")
    if not_used:
        print(f"{len(not_used)} images not used: {', '.join(list(not_used)[:NAMED])}")
    if advice:
        print(advice)


def _report(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


def _ignore(words: str) -> None:
    """With --quiet."""


def _board(text: str) -> tuple[int, int]:
    """Inner corners in a row and in a column."""
    columns, by, rows = text.lower().partition("x")
    if not (by and columns.isdecimal() and rows.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text!r} is not COLUMNSxROWS; write for example 9x6")
    return int(columns), int(rows)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

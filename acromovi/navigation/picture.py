"""`acromovi navigate picture`: the mission as it stands."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.options import add_bus
from acromovi.sniff import new_file

if TYPE_CHECKING:
    from bus.bus import Bus

EPILOG = """\
examples:
  acromovi navigate picture happy now.svg
  acromovi navigate picture happy now.png

It shows what the robot has seen, the doors with their confidence, the plan with its sub-targets, the path travelled,
the goal, and what each component wants of the wheels now, with the command that the fuser makes of it. Afterwards it
shows the last mission.

Exit codes: 0 done, 1 nobody navigates the robot, or the file cannot be written, 2 wrong usage.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("file", metavar="FILE", type=picture_file, help="what to write: .svg or .png")
    add_bus(parser)


def picture_file(text: str) -> Path:
    """A file that can be written, of a kind that can be drawn."""
    path = new_file(text)
    if path.suffix not in (".svg", ".png"):
        raise argparse.ArgumentTypeError(f"{text} ends neither in .svg nor in .png")
    return path


def run(arguments: argparse.Namespace) -> int:
    """Ask once, and draw."""
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        return take(bus, arguments.robot, arguments.file, "picture")


def take(bus: "Bus", robot: str, path: Path, order: str) -> int:
    """Draw the mission as it stands; the exit code.

    Raises:
        NobodyNavigates, RequestNotDone, ConfigError: As `snapshot` and `draw`.
    """
    from acromovi.navigation.mission_picture import draw
    from acromovi.navigation.snapshot import snapshot

    shot = snapshot(bus, robot)
    try:
        draw(path, shot)
    except OSError as err:
        print(f"acromovi navigate {order}: {path} cannot be written: {err.strerror}", file=sys.stderr)
        return 1
    return 0

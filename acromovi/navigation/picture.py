"""`acromovi navigate picture`: draw the present mission."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.options import add_bus
from acromovi.sniff import new_file
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from bus.bus import Bus

EPILOG = """\
examples:
  acromovi navigate picture happy now.svg
  acromovi navigate picture happy now.png

The picture shows the grid, the doors with their confidence, the plan with the ends of its pieces, the path travelled,
the goal, and the motion commands of all components with the fused one. After a mission it shows the last one.

Exit codes: 0 done, 1 the navigation does not run, or the file cannot be written, 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("file", metavar="FILE", type=picture_file, help="picture to write, .svg or .png")
    add_bus(parser)


def picture_file(text: str) -> Path:
    """Return the path of a writable picture file."""
    path = new_file(text)
    if path.suffix not in (".svg", ".png"):
        raise argparse.ArgumentTypeError(f"{text} ends neither in .svg nor in .png")
    return path


def _run(arguments: argparse.Namespace) -> int:
    """Query the components once, and draw; return the exit code."""
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        return take(bus, arguments.robot, arguments.file, "picture")


def take(bus: "Bus", robot: str, path: Path, order: str) -> int:
    """Draw the present mission; return the exit code.

    Raises:
        NotOnBus, RequestNotDone, ConfigError: As `Snapshot.of` and `draw`.
    """
    from acromovi.navigation.mission_picture import draw
    from acromovi.navigation.snapshot import Snapshot

    shot = Snapshot.of(bus, robot)
    try:
        draw(path, shot)
    except OSError as err:
        print(f"acromovi navigate {order}: {path} cannot be written: {err.strerror}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

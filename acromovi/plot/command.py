"""`acromovi plot`: draw a recording as PNG or SVG, or open it in Rerun."""

import argparse
import math
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.subcommand import Subcommand
from configs.extras import require
from geometry import MapError, Pose2D, read_map

if TYPE_CHECKING:
    from acromovi.plot.figures import Background
    from recorder.recording import McapRecording

FORMATS = (".png", ".svg")
RERUN = "rerun"
EPILOG = """\
examples:
  acromovi plot drive.mcap                           drive.png: paths, speeds, ranges, battery, latency
  acromovi plot drive.mcap --output drive.svg
  acromovi plot drive.mcap --output pictures         each figure as a file of its own in a folder
  acromovi plot drive.mcap --map office --at anna=14,6.1,-90
  acromovi plot drive.mcap --rerun                   open the recording in Rerun, where it is installed

Paths are in the frame of each robot's odometry, which begins where its gateway connected. Over a map they are where a
recorded transform has them, or where --at says that the odometry began: x and y in m, heading in degrees. Without --map
the latest recorded occupancy grid is the map.

Exit codes: 0 drawn, 1 not drawn (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", nargs="+", type=Path, help="recording; all of its files if it was split"
    )
    parser.add_argument(
        "--output", type=Path, metavar="FILE|DIR", help="set the picture (.png, .svg), or a folder [FILE.png]"
    )
    parser.add_argument("--map", metavar="MAP", help="draw over a map: an ARIA .map file, or a world of the emulator")
    parser.add_argument(
        "--at", type=_start, action="append", default=[], metavar="ROBOT=X,Y,DEG", help="set a start; repeatable"
    )
    parser.add_argument("--rerun", action="store_true", help="open the recording in Rerun, and draw nothing")
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def _start(text: str) -> tuple[str, Pose2D]:
    """Read `robot=x,y,degrees`."""
    name, equals, numbers = text.partition("=")
    try:
        x, y, degrees = (float(each) for each in (*numbers.split(","), "0")[:3])
    except ValueError:
        equals = ""
    if not (name and equals) or not all(map(math.isfinite, (x, y, degrees))):
        raise argparse.ArgumentTypeError(f"{text!r} is not ROBOT=X,Y,DEG; write for example anna=14,6.1,-90")
    return name, Pose2D(x, y, math.radians(degrees))


def _run(arguments: argparse.Namespace) -> int:
    """Draw a recording, or open it in Rerun."""
    if arguments.rerun:
        return _open_in_rerun(arguments.file)
    require("reading a recording", "recorder")
    require("the picture of a recording", "plots")
    output, is_folder, wrong = _output(arguments)
    if wrong:
        print(f"acromovi plot: {wrong}", file=sys.stderr)
        return 2
    try:
        return _draw(arguments, output, is_folder)
    except MapError as err:
        print(f"acromovi plot: {err}", file=sys.stderr)
    except OSError as err:
        print(f"acromovi plot: {err.filename or output}: {err.strerror}", file=sys.stderr)
    return 1


def _draw(arguments: argparse.Namespace, output: Path, is_folder: bool) -> int:
    """Read the recording and draw it."""
    from acromovi.plot.figures import PlottedRecording, draw
    from acromovi.plot.series import is_drawn, read_series
    from recorder.recording import McapRecording

    background = _background(arguments.map)
    with McapRecording.open(arguments.file) as recording:
        if arguments.map is None:
            background = _recorded_map(recording) or background
        robots, damaged = read_series(recording.samples(is_wanted=is_drawn), recording.start_ns)
        notes = recording.notes + [f"{damaged} messages could not be decoded and are left out"] * bool(damaged)
        begun, duration = time.localtime(recording.start_ns / 1e9), recording.duration
    for note in notes:
        print(f"acromovi plot: {note}", file=sys.stderr)
    if not robots:
        print("acromovi plot: the recording has no odometry; record a robot: acromovi record NAME", file=sys.stderr)
        return 1
    starts = dict(arguments.at)
    if unknown := sorted(starts.keys() - {each.name for each in robots}):
        print(f"acromovi plot: --at {unknown[0]}: the recording has no such robot", file=sys.stderr)
        return 2
    title = f"{arguments.file[0].name}: {duration:.0f} s from {time.strftime('%Y-%m-%d %H:%M:%S', begun)}"
    plotted = PlottedRecording(title, robots, background, starts)
    for name in plotted.not_in_map():
        print(
            f"acromovi plot: where {name} began in the map is not known; say it: --at {name}=X,Y,DEG", file=sys.stderr
        )
    files = draw(plotted, output, is_folder)
    if not arguments.quiet:
        print(f"drawn: {', '.join(map(str, files))}")
    return 0


def _output(arguments: argparse.Namespace) -> tuple[Path, bool, str]:
    """Return the output, whether it is a folder, and what is wrong with it."""
    output = arguments.output or Path(arguments.file[0].name).with_suffix(".png")
    is_folder = output.is_dir() or not output.suffix
    if not is_folder and output.suffix not in FORMATS:
        return output, False, f"{output} must end in {' or '.join(FORMATS)}, or be a folder"
    if not is_folder and not output.parent.is_dir():
        return output, False, f"there is no folder {output.parent}"
    return output, is_folder, ""


def _background(name: str | None) -> "Background":
    """Return the walls of a map.

    Raises:
        MapError: There is no such map, or it cannot be read.
        ExtraMissing: It is a world, and the emulator is not installed.
    """
    from acromovi.plot.figures import Background

    if name is None:
        return Background()
    if name.endswith(".map"):
        return Background(lines=[((each.x1, each.y1), (each.x2, each.y2)) for each in read_map(name).lines])
    require("a world of the emulator as a map", "emu")
    from p2os_emu.world import WorldError, load_world

    try:
        world = load_world(name)
    except WorldError as err:
        raise MapError(str(err)) from err
    return Background(walls=[block.footprint for block in (*world.walls, *world.furniture)])


def _recorded_map(recording: "McapRecording") -> "Background | None":
    """Return the latest occupancy grid of a recording, None if it has none that can be read."""
    from acromovi.plot.figures import Background
    from acromovi.plot.series import GRID_TYPE
    from bus.errors import MessageError

    grids = {each.key for each in recording.channels if each.type_name == GRID_TYPE}
    latest = None
    for recorded in recording.samples(is_wanted=lambda key: key in grids):
        latest = recorded.sample
    if latest is None:
        return None
    try:
        return Background.of_grid(latest.decoded())
    except (MessageError, ValueError):  # garbage, or a size that its cells do not have
        return None


def _open_in_rerun(files: list[Path]) -> int:
    """Open a recording in Rerun, which reads MCAP files, and wait until it is closed."""
    # pip puts it beside this program's interpreter, which need not be on the path
    folders = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)))
    program = shutil.which(RERUN, path=folders)
    if program is None:
        how = f"install it with: {sys.executable} -m pip install rerun-sdk"
        print(f"acromovi plot: Rerun is not installed; {how}", file=sys.stderr)
        return 1
    if absent := [each for each in files if not each.exists()]:
        print(f"acromovi plot: {absent[0]} does not exist", file=sys.stderr)
        return 1
    return subprocess.run([program, *map(str, files)], check=False).returncode  # which is this one's


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

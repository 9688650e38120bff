"""`acromovi map merge`: join two maps of one building."""

import argparse
import json
import sys
from pathlib import Path

from acromovi.mapping.files import new_map, new_picture
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi map merge happy.map doc.map building.map
  acromovi map merge old.yaml new.yaml building.yaml --picture building.png

The maps need not begin at the same place: how they lie is found by what both show, so they must have a room or a
corridor in common. The result has the frame of the first map, and where both have looked, the second is right. It takes
some seconds.

With --json the output is one object: pose (m, m, rad) of the second map in the first, agrees (share of its walls that
lie on walls of the first), against (share of walls where the other map has seen free floor), files.

Exit codes: 0 joined, 1 not, or the picture cannot be drawn (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("first", metavar="A", type=Path, help="map that gives the frame, .map or .yaml")
    parser.add_argument("second", metavar="B", type=Path, help="map that is joined to it")
    parser.add_argument("out", metavar="OUT", type=new_map, help="map to write, .map or .yaml")
    parser.add_argument("--picture", metavar="FILE", type=new_picture, help="draw the joined map, .png or .svg")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _run(arguments: argparse.Namespace) -> int:
    """Join them; return the exit code."""
    from acromovi.mapping.picture import draw_map
    from configs.extras import require
    from maps.building.merging import NoOverlap, merged
    from maps.map_files import read_building_map, write_building_map

    if arguments.picture is not None:
        require("pictures of maps", "plots")
    first, second = read_building_map(arguments.first), read_building_map(arguments.second)
    try:
        made, placement = merged(first, second)
    except NoOverlap as err:
        print(f"acromovi map merge: {arguments.first} and {arguments.second}: {err}", file=sys.stderr)
        return 1
    files = [str(file) for file in write_building_map(made, arguments.out)]
    pose = placement.pose
    told = {
        "pose": [round(pose.x, 4), round(pose.y, 4), round(pose.heading, 5)],
        "agrees": round(placement.agrees, 3),
        "against": round(placement.against, 3),
        "files": files,
    }
    if arguments.json:
        print(json.dumps(told))
    else:
        print(
            f"{', '.join(files)}: {arguments.second} lies at x {pose.x:.2f} m, y {pose.y:.2f} m, turned by "
            f"{pose.heading:.3f} rad; {placement.agrees:.0%} of its walls lie on walls of {arguments.first}"
        )
    if arguments.picture is not None:
        try:
            draw_map(arguments.picture, made, f"{arguments.first.name} and {arguments.second.name}")
        except (ValueError, OSError) as err:
            print(f"acromovi map merge: {arguments.picture} cannot be drawn: {err}", file=sys.stderr)
            return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi map show`: draw a map."""

import argparse
import json
import sys
from pathlib import Path

from acromovi.mapping.files import new_picture
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi map show lab.map lab.png
  acromovi map show lab.yaml lab.svg

The picture shows the grid, lines, points, named places, and forbidden lines and areas. With --json the output is one
object: lines, points, places, cells, width and height in m.

Exit codes: 0 drawn, 1 the map cannot be read, or the picture not be written (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("map", metavar="MAP", type=Path, help="map to draw, .map or .yaml")
    parser.add_argument("picture", metavar="PICTURE", type=new_picture, help="picture to write, .png or .svg")
    parser.add_argument("--json", action="store_true", help="print figures of the map as one JSON object")


def _run(arguments: argparse.Namespace) -> int:
    """Draw; return the exit code."""
    from acromovi.mapping.picture import draw_map
    from maps.map_files import read_building_map

    drawn = read_building_map(arguments.map)
    try:
        draw_map(arguments.picture, drawn, arguments.map.name)
    except (ValueError, OSError) as err:
        print(f"acromovi map show: {arguments.picture} cannot be drawn: {err}", file=sys.stderr)
        return 1
    x_min, y_min, x_max, y_max = drawn.bounds
    figures = {
        "lines": len(drawn.lines),
        "points": len(drawn.points),
        "places": len(drawn.places),
        "cells": 0 if drawn.grid is None else int(drawn.grid.cells.size),
        "width": round(x_max - x_min, 2),
        "height": round(y_max - y_min, 2),
    }
    words = f"{figures['lines']} lines, {figures['points']} points, {figures['places']} places"
    for_people = f"{arguments.picture}: {words}, {figures['width']:g} m x {figures['height']:g} m"
    print(json.dumps(figures) if arguments.json else for_people)
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

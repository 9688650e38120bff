"""`acromovi map save`: write the map of a robot."""

import argparse
import asyncio
import base64
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.mapping.files import new_map
from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import AgentName
    from bus.bus import Bus
    from maps.building_map import BuildingMap

TIME = 60.0  # s in which the agent fits lines to what it has seen
EPILOG = """\
examples:
  acromovi map save happy lab.map      an ARIA map: lines, points, RobotHome
  acromovi map save happy lab.yaml     a map of ROS: lab.yaml and lab.pgm

The map is written on this machine, wherever the robot is, while it is being built or after that. With --json the output
is one object: files.

Exit codes: 0 saved, 1 there is no map, or it cannot be written (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("file", metavar="FILE", type=new_map, help="file to write or replace, .map or .yaml")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Fetch the map, and write it; return the exit code."""
    from bus.session import ZenohBus
    from maps.map_files import write_building_map

    with ZenohBus.open(arguments.bus) as bus:
        made = fetched(bus, mapping_agent(bus, arguments.robot), arguments.file.suffix)
    files = [str(file) for file in write_building_map(made, arguments.file)]
    print(json.dumps({"files": files}) if arguments.json else f"{', '.join(files)}: {len(made.lines)} lines")
    return 0


def mapping_agent(bus: "Bus", robot: str) -> "AgentName":
    """Wait until the mapping agent of a robot is there, and return its name.

    Raises:
        NotOnBus: It is not.
    """
    from acromovi.known_agents import KnownAgents
    from agents.platform.names import AgentName

    name = AgentName("mapping", robot)
    with KnownAgents(bus) as known:
        known.expect(name)
    return name


def fetched(bus: "Bus", agent: "AgentName", suffix: str) -> "BuildingMap":
    """Return the map of a mapping agent, in the form that a kind of file has.

    Raises:
        RequestNotDone: It has none.
    """
    from acromovi.ask import ask
    from maps.map_files import read_building_map

    kind = "map" if suffix == ".map" else "yaml"
    files = asyncio.run(ask(bus, agent, "content", {"kind": kind}, TIME)).value()["files"]
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (Path(folder) / Path(name).name).write_bytes(base64.b64decode(content))
        return read_building_map(Path(folder) / f"map.{kind}")


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

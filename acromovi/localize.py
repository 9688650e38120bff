"""`acromovi localize`: find out where a robot is on a map."""

import argparse
import asyncio
import json
import sys
from collections.abc import Mapping
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.navigation.going import finite
from acromovi.options import add_bus, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

TIMEOUT = 60.0  # s
LOADING = 30.0  # s for a large map
PERIOD = 0.5  # s between two looks
LOCALIZED, WRONG_MAP, STOPPED = "localized", "wrong map", "stopped"
EPILOG = """\
examples:
  acromovi localize happy --map office.map
      the robot stands at the RobotHome of the map
  acromovi localize happy --map office.yaml --pose 2.5 6.1 1.57
  acromovi localize happy --map office.map --unknown
      the robot is anywhere; drive it meanwhile, with acromovi teleop for example
  acromovi localize happy --state
  acromovi localize happy --stop

The map is a file .map of ARIA or .yaml of ROS, on the machine of the robot's container, and so are settings. The
command ends when the pose is known; the localization continues until it is stopped, and publishes HAPPY/pose, HAPPY/tf
and HAPPY/map. Send the robot to a goal of the map with: acromovi navigate go happy "Lab 2".

With --json the output is one object: state, pose (x, y, heading in map), deviations, score, reason and more.

Exit codes: 0 localized (with --state too), or stopped; 1 not localized within the time, wrong map, or refused (the
reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--map", metavar="FILE", help="localize the robot on this map")
    action.add_argument("--state", action="store_true", help="print what is known now")
    action.add_argument("--stop", action="store_true", help="end the localization")
    start = parser.add_mutually_exclusive_group()
    start.add_argument(
        "--pose",
        nargs=3,
        type=finite,
        metavar=("X", "Y", "HEADING"),
        help="begin there, m and rad [RobotHome of the map]",
    )
    start.add_argument("--unknown", action="store_true", help="begin anywhere in the map")
    parser.add_argument(
        "--settings", metavar="FILE", default="", help="use changes of the settings from this TOML file"
    )
    parser.add_argument(
        "--timeout", type=seconds, default=TIMEOUT, metavar="S", help="wait for the pose [%(default)g s]"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of the progress")
    parser.add_argument("--quiet", action="store_true", help="print no progress")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Start, and wait for the pose; return the exit code."""
    from acromovi.known_agents import KnownAgents
    from agents.platform.names import AgentName
    from bus.session import ZenohBus

    if arguments.map is None and (arguments.pose or arguments.unknown or arguments.settings):
        print("acromovi localize: --pose, --unknown and --settings need --map FILE", file=sys.stderr)
        return 2
    agent = AgentName("localization", arguments.robot)
    with ZenohBus.open(arguments.bus) as bus:
        with KnownAgents(bus) as known:
            known.expect(agent)
        return asyncio.run(_localize(bus, agent, arguments))


async def _localize(bus: "Bus", peer: "AgentName", arguments: argparse.Namespace) -> int:
    """Do what is asked for.

    Raises:
        RequestNotDone: It was refused.
    """
    from acromovi.ask import asker

    async with asker(bus, peer) as agent:
        if arguments.stop:
            told = (await agent.request(peer, "stop")).value()
            print(json.dumps(told) if arguments.json else f"the localization of {arguments.robot} is stopped")
            return 0
        if arguments.map is not None:
            given: dict[str, Any] = {"map": str(Path(arguments.map).resolve())}
            given["settings"] = str(Path(arguments.settings).resolve()) if arguments.settings else ""
            given["pose"] = arguments.pose or ("unknown" if arguments.unknown else "home")
            (await agent.request(peer, "start", reply_within=LOADING, **given)).value()
        told = await _told(agent, peer, arguments)
    if arguments.json:
        print(json.dumps(told))
    elif told["state"] == LOCALIZED:
        print(f"{arguments.robot} is {_words(told)}")
    if told["state"] == LOCALIZED:
        return 0
    print(f"acromovi localize: {arguments.robot} is not localized ({told['state']}): {told['reason']}", file=sys.stderr)
    return 1


async def _told(agent: "Agent", peer: "AgentName", arguments: argparse.Namespace) -> Mapping[str, Any]:
    """Print progress until the pose is known, the map is wrong, or time is up; return the last state."""
    loop = asyncio.get_running_loop()
    until, shown = loop.time() + arguments.timeout, ""
    while True:
        told: Mapping[str, Any] = (await agent.request(peer, "state")).value()
        if arguments.map is None or told["state"] in (LOCALIZED, WRONG_MAP, STOPPED) or loop.time() > until:
            return told
        words = _words(told)
        if words != shown and not arguments.quiet and not arguments.json:
            print(words, file=sys.stderr, flush=True)
        shown = words
        await asyncio.sleep(PERIOD)


def _words(told: Mapping[str, Any]) -> str:
    if told["pose"] is None:
        return f"{told['state']}: {told['reason']}"
    x, y, heading = told["pose"]
    dx, dy, turn = told["deviations"]
    place = f"({x:.2f} ± {dx:.2f}, {y:.2f} ± {dy:.2f}) m, {degrees(heading):.0f} ± {degrees(turn):.1f} degrees"
    why = f": {told['reason']}" if told["reason"] else ""
    return f"{told['state']} at {place}, score {told['score']:.2f}{why}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

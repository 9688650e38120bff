"""`acromovi map build`: let robots build maps, and let them explore."""

import argparse
import asyncio
import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.mapping.files import new_map, new_picture
from acromovi.options import add_bus, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from acromovi.mapping.explore import ExploringTeam
    from acromovi.mapping.grids import LiveGrids
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

LOOK = 1.0  # s between two looks at the progress
PICTURE_PERIOD = 5.0  # s between two pictures
REPLY = 10.0  # s in which an agent begins a map, or says how far it is
REFINING = 120.0  # s in which it improves a large map at the end
EPILOG = """\
examples:
  acromovi map build happy                             until Ctrl-C; drive the robot meanwhile, from another terminal
  acromovi map build happy --explore                   the robot drives by itself until it has seen all rooms
  acromovi map build happy doc --explore               both explore, and share the rooms as soon as their maps overlap
  acromovi map build happy --save lab.map --for 300
  acromovi map build happy --extend /home/me/lab.map --at 2.5 1.0 1.57

A robot maps with its laser. The map is improved when the building ends, and kept by the agent mapping@ROBOT until the
next one is begun: acromovi map save ROBOT FILE writes it, also meanwhile. A file to extend is read on the machine of
that agent; --at says where the robot is in it, about, unless it stands at its RobotHome.

--explore needs the navigation of each robot: acromovi navigate up ROBOT, or navigation = true in the team's file. It
asks it to go to frontiers, one after the other, doors first; Ctrl-C cancels the mission, and the robot stops.

With --json each line is one object: robot, building, scans, key_scans, loops, driven (m), pose and odom (m, m, rad, in
map), trouble, and target (m) with --explore; the last line has ended: "explored", "time" or "interrupted".

Exit codes: 0 ended by --for, or explored; 1 a robot cannot build a map or drive (the reason is on stderr), 2 wrong
usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robots", metavar="ROBOT", nargs="+", help="names on the bus")
    parser.add_argument("--explore", action="store_true", help="let the robots drive by themselves")
    parser.add_argument("--extend", metavar="FILE", default="", help="extend this map, .map or .yaml (absolute path)")
    parser.add_argument(
        "--at", metavar=("X", "Y", "RAD"), nargs=3, type=float, help="say where the robot is in that map, m, m, rad"
    )
    parser.add_argument("--for", metavar="S", dest="duration", type=seconds, help="end after so many s [never]")
    parser.add_argument("--save", metavar="FILE", type=new_map, help="write the map at the end, .map or .yaml")
    parser.add_argument("--picture", metavar="FILE", type=new_picture, help="draw the map so far, every 5 s")
    parser.add_argument("--json", action="store_true", help="print one JSON object for each look")
    parser.add_argument("--quiet", action="store_true", help="print no progress")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Build; return the exit code."""
    from acromovi.mapping.save import fetched, mapping_agent
    from bus.session import ZenohBus
    from configs.extras import require
    from maps.map_files import write_building_map

    robots = list(dict.fromkeys(arguments.robots))
    if len(robots) > 1 and (arguments.save or arguments.extend):
        print("acromovi map build: --save and --extend are for one robot; use acromovi map save", file=sys.stderr)
        return 2
    if arguments.at and not arguments.extend:
        print("acromovi map build: --at is a place in the map of --extend; add that", file=sys.stderr)
        return 2
    if arguments.picture is not None:
        require("pictures of maps", "plots")
    with ZenohBus.open(arguments.bus) as bus:
        agents = {robot: mapping_agent(bus, robot) for robot in robots}

        def finish(ended: str) -> None:
            if arguments.save is not None:
                files = write_building_map(fetched(bus, agents[robots[0]], arguments.save.suffix), arguments.save)
                _tell(arguments, f"written: {', '.join(map(str, files))}")
            if arguments.json:
                print(json.dumps({"ended": ended}))

        try:
            ended = asyncio.run(_build(bus, agents, arguments))
        except Exception:
            raise  # the map of the agent may be an earlier one
        except BaseException:  # Ctrl-C or SIGTERM, the usual end of a drive
            finish("interrupted")
            raise
        finish(ended)
    return 0


async def _build(bus: "Bus", agents: dict[str, "AgentName"], arguments: argparse.Namespace) -> str:
    """Build until the end, and return what ended it; however it ends, robots that explore are stopped.

    Raises:
        RequestNotDone: A robot cannot build a map.
        NotOnBus: A robot that is to explore does not navigate.
    """
    from acromovi.ask import asker
    from acromovi.mapping.explore import ExploringTeam
    from acromovi.mapping.grids import LiveGrids

    async with asker(bus, next(iter(agents.values()))) as agent:
        with LiveGrids(bus, list(agents)) as grids:
            team = await ExploringTeam.found(bus, agent, grids) if arguments.explore else None
            begun: dict[str, AgentName] = {}
            try:
                for robot, name in agents.items():
                    (await agent.request(name, "start", reply_within=REPLY, **_begin(arguments))).value()
                    begun[robot] = name
                return await _follow(agent, agents, grids, team, arguments)
            finally:
                if team is not None:
                    await team.cancel()
                for robot, name in begun.items():
                    _tell(arguments, f"{robot}: improving the map")
                    outcome = await agent.request(name, "stop", reply_within=REFINING)
                    _report(arguments, robot, outcome.value() if outcome.is_done else {"trouble": outcome.why}, None)
                    if outcome.is_done and arguments.save is None:
                        _tell(arguments, f"to write it: acromovi map save {robot} FILE.map")
                await asyncio.sleep(LOOK / 2)  # for the last maps
                _draw(arguments, grids, team)


def _begin(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of the request that begins a map."""
    if not arguments.extend:
        return {}
    given = {"extend": str(Path(arguments.extend).expanduser().resolve())}
    return {**given, **dict(zip(("x", "y", "heading"), arguments.at, strict=True))} if arguments.at else given


async def _follow(
    agent: "Agent",
    agents: dict[str, "AgentName"],
    grids: "LiveGrids",
    team: "ExploringTeam | None",
    arguments: argparse.Namespace,
) -> str:
    """Print how far the maps are, and let the team explore, until the end."""
    began = drawn = time.monotonic()
    while True:
        for robot, name in agents.items():
            state = (await agent.request(name, "state", reply_within=REPLY)).value()
            grids.note(robot, state)
            _report(arguments, robot, state, team)
            if not state["building"]:
                raise _ended(robot, state)
        now = time.monotonic()
        if team is not None and await team.step(now):
            return "explored"
        if arguments.duration is not None and now - began > arguments.duration:
            return "time"
        if now - drawn > PICTURE_PERIOD:
            drawn = now
            _draw(arguments, grids, team)
        await asyncio.sleep(LOOK)


def _ended(robot: str, state: dict[str, Any]) -> Exception:
    from agents.platform.errors import RequestNotDone

    return RequestNotDone(f"{robot} builds no map any more: {state.get('trouble') or 'another program has ended it'}")


def _report(arguments: argparse.Namespace, robot: str, state: dict[str, Any], team: "ExploringTeam | None") -> None:
    """Print a line about one robot."""
    target = None if team is None else team.targets.get(robot)
    if arguments.json:
        told = {"robot": robot, **state, **({"target": target} if team is not None else {})}
        print(json.dumps(told), flush=True)
        return
    words = [f"{state.get('key_scans', 0)} key scans", f"{state.get('loops', 0)} loops closed"]
    words.append(f"{state.get('driven', 0.0):.1f} m driven")
    if target is not None:
        words.append(f"drives to ({target[0]:.1f}, {target[1]:.1f})")
    if state.get("trouble"):
        words.append(state["trouble"])
    _tell(arguments, f"{robot}: {', '.join(words)}")


def _tell(arguments: argparse.Namespace, words: str) -> None:
    """Print words, unless they were the last that were printed."""
    if not (arguments.quiet or arguments.json) and getattr(arguments, "told", "") != words:
        arguments.told = words
        print(words, flush=True)


def _draw(arguments: argparse.Namespace, grids: "LiveGrids", team: "ExploringTeam | None") -> None:
    """Draw the first robot's map so far. That a picture cannot be drawn is reported once; the map is built anyway."""
    if arguments.picture is None:
        return
    from acromovi.mapping.picture import draw_map
    from maps.building_map import BuildingMap

    robot, grid, robots = grids.first()
    if grid is None:
        return
    target = None if team is None else team.targets.get(robot)
    targets = () if target is None else (target,)
    try:
        draw_map(arguments.picture, BuildingMap(grid=grid), f"map of {robot}", robots, targets)
    except (ValueError, OSError) as err:
        if not getattr(arguments, "complained", False):
            print(f"acromovi map build: {arguments.picture} cannot be drawn: {err}", file=sys.stderr, flush=True)
        arguments.complained = True


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

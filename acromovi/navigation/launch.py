"""`acromovi navigate up`: run the processes of a robot's navigation, until Ctrl-C."""

import argparse
import asyncio
import json
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.navigation.wired import Processes, add_wiring, processes, words
from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from bus.bus import Bus

FOLDER = "acromovi-"
DISCOVERY_TIME = 0.5  # s within which a navigation that runs already is found
EPILOG = """\
examples:
  acromovi navigate up happy                         the processes of the wiring
  acromovi navigate up happy --processes each        ten processes
  acromovi navigate up happy --processes one         one process
  acromovi navigate up happy --process hardware --process reactive
      these two here; run the others by the same command on another machine, with a --bus that connects both
  acromovi navigate up happy --set components.path_planning.numbers.mission.speed=0.3
  acromovi navigate up happy --wiring mine.toml

A process that dies or is frozen is restarted, and the mission continues. With --json the output is one line once all
components run: {"robot": NAME, "processes": {PROCESS: [COMPONENT, ...], ...}}

Exit codes: 1 a process could not start (the reason is on stderr, and no process is left), 2 wrong usage, 130 stopped by
Ctrl-C, 143 by SIGTERM.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    add_wiring(parser)
    parser.add_argument(
        "--process",
        metavar="NAME",
        action="append",
        default=[],
        dest="only",
        help="start only this process; repeatable [all]",
    )
    parser.add_argument("--json", action="store_true", help="print one line of JSON once all components run")
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Run the processes until a signal; return the exit code."""
    from acromovi.navigation.at_work import NotUp
    from bus.keys import robot_name

    robot_name(arguments.robot)
    chosen = of_names(processes(arguments), arguments.only)
    # A process that is just ending may still write there; what is left of the folder does no harm.
    with tempfile.TemporaryDirectory(prefix=FOLDER, ignore_cleanup_errors=True) as folder:
        try:
            return asyncio.run(_hold(arguments, chosen, Path(folder)))
        except NotUp as err:
            print(f"acromovi navigate up: {err}", file=sys.stderr)
            return 1


def of_names(known: Processes, wanted: list[str]) -> Processes:
    """Return the wanted processes; all where none is named.

    Raises:
        ConfigError: There is no such process.
    """
    from configs.loader import ConfigError

    for name in wanted:
        if name not in known:
            raise ConfigError(f"the wiring has no process {name!r}; choose one of {', '.join(known)}")
    return {name: parts for name, parts in known.items() if name in (wanted or known)}


async def _hold(arguments: argparse.Namespace, chosen: Processes, folder: Path) -> int:
    from acromovi.navigation.at_work import NavigationAtWork
    from acromovi.team.plan import PlannedProcess
    from acromovi.team.processes import Processes as RealProcesses
    from acromovi.up import ENDINGS, keep_up, signals
    from bus.session import ZenohBus

    def tell(sentence: str) -> None:
        if not (arguments.json or arguments.quiet):
            print(sentence, flush=True)

    def complain(sentence: str) -> None:
        print(f"acromovi navigate up: {sentence}", file=sys.stderr, flush=True)

    asked_to_end = signals(ENDINGS)
    robot = arguments.robot
    programs = [PlannedProcess.of_navigation(robot, name, words(arguments), arguments.bus) for name in chosen]
    with ZenohBus.open(arguments.bus) as bus:
        await _look_round(bus, robot, chosen, tell)
        real = await RealProcesses.open(folder)
        at_work = NavigationAtWork(programs, real.start, bus, complain)

        async def come_up() -> None:
            await at_work.come_up()
            _announce(arguments, chosen, tell)

        return 128 + await keep_up(at_work, real, come_up, asked_to_end)


def _announce(arguments: argparse.Namespace, chosen: Processes, tell: Any) -> None:
    names = {process: [part.local for part in parts] for process, parts in chosen.items()}
    count = sum(map(len, names.values()))
    tell(f"{arguments.robot} navigates: {count} components in {', '.join(names)}; Ctrl-C ends them")
    tell(f"acromovi navigate go {arguments.robot} X Y sends it")
    if arguments.json:
        print(json.dumps({"robot": arguments.robot, "processes": names}), flush=True)


async def _look_round(bus: "Bus", robot: str, chosen: Processes, tell: Any) -> None:
    """Check that the components do not run already, because two of one name would both command; look for the robot.

    Raises:
        NotUp: A component of this process runs already, or the key does not belong to the robot.
    """
    from acromovi.navigation.at_work import NotUp
    from bus.keys import ALIVE

    if bus.own_name not in (None, robot):
        raise NotUp(
            f"this key belongs to {bus.own_name}, and the components run as {robot}; "
            f"use the robot's key, --bus secure:keys/robot.{robot}, or an admin's"
        )
    there: set[str] = set()
    keys = {part.agent(robot).alive_key: part.agent(robot) for parts in chosen.values() for part in parts}
    watching = [bus.watch_alive(key, lambda key, is_there: there.add(key)) for key in [*keys, ALIVE.key(robot)]]
    await asyncio.sleep(DISCOVERY_TIME)
    for each in watching:
        each.close()
    if taken := sorted(str(agent) for key, agent in keys.items() if key in there):
        raise NotUp(f"{taken[0]} is on this bus already; stop it first, or use another --bus")
    if ALIVE.key(robot) not in there:
        tell(f"{robot} is not on this bus yet; its navigation waits for it")


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi up`: start a whole team from one file, and end it with Ctrl-C."""

import argparse
import asyncio
import json
import signal
import sys
import tempfile
from collections.abc import Awaitable, Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.options import CONSOLE_PORT, add_apps, add_bus, seconds, tcp_port
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from acromovi.navigation.at_work import NavigationAtWork
    from acromovi.team.identities import TeamOptions
    from acromovi.team.plan import TeamPlan
    from acromovi.team.processes import Processes
    from acromovi.team.team import TeamAtWork
    from bus.bus import Bus

FOLDER = "acromovi-"
TIMED_OUT = 3  # exit code
MEETING_TIME = 0.5  # s in which a team that is up already must have been seen
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
EPILOG = """\
examples:
  acromovi up acromovi                  the team of configs/teams/acromovi.toml, until Ctrl-C
  acromovi up my-team.toml              a team of one's own
  acromovi up acromovi --only happy,doc
  acromovi up acromovi --bus secure:keys
      on a bus with keys, each robot with its own, robot.NAME, and what looks after all with admin.acromovi
  acromovi up acromovi --console
      with the web console (docs/console.md), whose address is printed once all serve
  acromovi up acromovi --json --quiet   one line once all serve:
      {"console": URL or null, "robots": [NAME, ...], "control": PATH}
  acromovi up my-team.toml --check      check the file, ports and extras; start nothing
  acromovi up my-team.toml --only happy --units ~/.config/systemd/user
      write units of systemd that start the gateway and the agents of this robot when its own computer boots

A robot whose port is "emu" is emulated; with a device or a URL in its place it is real, and nothing else differs. All
serve when every emulated robot does and every real one that is there; one that is not is waited for, and served when it
comes. The control socket is the emulator's (null without one).

While the team comes up, a line is printed for each robot that becomes ready, and what the others wait for.

Exit codes: 1 the team cannot come up (the reason is on stderr), 2 wrong usage, 3 it has not come up within --timeout
(the cause for each robot that is missing is on stderr), 130 stopped by Ctrl-C, 143 by SIGTERM. Nothing is left running.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("team", metavar="TEAM", help="team: a name in configs/teams, or a file")
    parser.add_argument("--only", metavar="ROBOT,...", type=_names, default=(), help="start only these robots")
    parser.add_argument("--seed", type=int, metavar="N", help="set the seed of the emulator's random generator")
    parser.add_argument(
        "--timeout",
        type=seconds,
        metavar="S",
        help="stop if the team has not come up within this time, s [60]",
    )
    add_apps(parser)
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--check", action="store_true", help="check the file, ports and extras, and start nothing")
    instead.add_argument(
        "--units", type=Path, metavar="DIR", help="write units of systemd for the real robots, and start nothing"
    )
    parser.add_argument(
        "--console",
        metavar="PORT",
        nargs="?",
        type=tcp_port,
        const=CONSOLE_PORT,
        help=f"start the web console as well, on this TCP port, 0 for any [{CONSOLE_PORT}]",
    )
    parser.add_argument("--json", action="store_true", help="print one line of JSON once all serve")
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Start a team, keep it running, and end it in order."""
    from acromovi.team.identities import TeamOptions, folder_of_keys
    from acromovi.team.plan import TeamPlan
    from acromovi.team.team import TeamFailed, TeamTimedOut
    from configs.extras import require

    if arguments.check:
        return _check(arguments)
    team = TeamPlan.load(arguments.team, arguments.only)
    if arguments.units is not None:
        return _write_units(team, arguments)
    if team.emulated:
        require("a team with emulated robots", "emu")
    if arguments.console is not None:
        require("acromovi up --console", "console")
    keys = folder_of_keys(arguments.bus, team.name, [robot.name for robot in team.robots])
    choices = TeamOptions(arguments.bus, arguments.seed, tuple(arguments.apps), keys, arguments.console)
    # A process that is just ending may still write there; what is left of the folder does no harm.
    with tempfile.TemporaryDirectory(prefix=FOLDER, ignore_cleanup_errors=True) as folder:
        try:
            return asyncio.run(_hold(team, choices, Path(folder), arguments))
        except TeamFailed as err:
            print(f"acromovi up: {err}", file=sys.stderr)
            return TIMED_OUT if isinstance(err, TeamTimedOut) else 1


def _check(arguments: argparse.Namespace) -> int:
    """Check a team, and print what was found."""
    from acromovi.team.check import check_team

    found = check_team(arguments.team, arguments.only, arguments.bus, console=arguments.console is not None)
    if arguments.json:
        print(json.dumps(found.as_json()))
    elif not arguments.quiet:
        for line in (*found.robots, *found.notes):
            print(line)
    if not arguments.json:
        for problem in found.problems:
            print(f"acromovi up: {problem}", file=sys.stderr)
        if not (found.problems or arguments.quiet):
            print(f"the team can be started: acromovi up {arguments.team}")
    return 1 if found.problems else 0


def _write_units(team: "TeamPlan", arguments: argparse.Namespace) -> int:
    """Write units of systemd, and print how to enable them."""
    from acromovi.team.identities import TeamOptions, folder_of_keys
    from acromovi.team.units import write_units

    keys = folder_of_keys(arguments.bus, team.name, [robot.name for robot in team.robots])
    try:
        written = write_units(team, TeamOptions(arguments.bus, keys=keys), arguments.units)
    except OSError as err:
        print(f"acromovi up: {err.filename or arguments.units}: {err.strerror}", file=sys.stderr)
        return 1
    if arguments.json:
        print(json.dumps({"units": list(written.units), "files": [str(each) for each in written.files]}))
    elif not arguments.quiet:
        for file in written.files:
            print(f"written: {file}")
        print(
            "start them now and at each boot, on the computer of the robot, where they are in ~/.config/systemd/user:"
        )
        print(f"  systemctl --user daemon-reload && systemctl --user enable --now {' '.join(written.units)}")
        print("  loginctl enable-linger $USER    # at boot, before anybody logs in")
    return 0


def _names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise argparse.ArgumentTypeError(f"{text!r} names no robot; write for example happy,doc")
    return names


async def _hold(team: "TeamPlan", choices: "TeamOptions", folder: Path, arguments: argparse.Namespace) -> int:
    from acromovi.team.processes import Processes
    from acromovi.team.team import STARTING_TIME, TeamAtWork, TeamFailed
    from bus import ZenohBus

    def tell(sentence: str) -> None:
        if not (arguments.json or arguments.quiet):
            print(sentence, flush=True)

    def complain(sentence: str) -> None:
        print(f"acromovi up: {sentence}", file=sys.stderr, flush=True)

    asked_to_end = signals(ENDINGS)
    with ZenohBus.open(choices.bus_of_team(team.name)) as bus:
        processes = await Processes.open(folder)  # the fork server loads its modules meanwhile
        try:
            await _see_that_nobody_is_there(bus, team)
        except TeamFailed:
            await processes.end()
            raise
        at_work = TeamAtWork(team, choices, folder, processes.start, bus, tell, complain)

        async def come_up() -> None:
            robots = await at_work.come_up(arguments.timeout or STARTING_TIME)
            if at_work.control is not None:
                tell(f"faults and truth of the emulated ones: {at_work.control}")
            if at_work.console is not None:
                tell(f"console: {at_work.console}")
            tell(_greeting(team, robots))
            if arguments.json:
                print(
                    json.dumps({"console": at_work.console, "robots": robots, "control": at_work.control}), flush=True
                )

        return 128 + await keep_up(at_work, processes, come_up, asked_to_end)


async def keep_up(
    at_work: "TeamAtWork | NavigationAtWork",
    processes: "Processes",
    come_up: Callable[[], Awaitable[None]],
    asked_to_end: "asyncio.Future[int]",
) -> int:
    """Run processes until a signal, end them in order, and return it. `come_up` waits until they run, and says so."""
    with at_work:
        try:
            at_work.begin()
            coming_up = asyncio.ensure_future(come_up())
            either: list[asyncio.Future[Any]] = [coming_up, asked_to_end]
            await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            if coming_up.done():
                coming_up.result()
            coming_up.cancel()
            return await asked_to_end
        finally:
            at_work.supervisor.rest()
            await processes.end()
            await at_work.supervisor.end()


def _greeting(team: "TeamPlan", robots: Sequence[str]) -> str:
    away = [robot.name for robot in team.robots if robot.name not in robots]
    who = f"{len(robots)} of {len(team.robots)} robots" if away else f"all {len(robots)} robots"
    if not away and len(robots) == 1:
        who = f"the robot {robots[0]}"
    serves = "serves" if len(robots) == 1 else "serve"
    waited_for = f", {' and '.join(away)} will when they come" if away else ""
    return f"{who} of {team.name} {serves}{waited_for}; Ctrl-C ends the team"


def signals(numbers: Iterable[signal.Signals]) -> "asyncio.Future[int]":
    """Resolved with the first of these signals that comes; more of them do no harm."""
    loop = asyncio.get_running_loop()
    came: asyncio.Future[int] = loop.create_future()

    def note(number: signal.Signals) -> None:
        if not came.done():
            came.set_result(int(number))

    for number in numbers:
        loop.add_signal_handler(number, note, number)
    return came


async def _see_that_nobody_is_there(bus: "Bus", team: "TeamPlan") -> None:
    """Refuse to start a robot or team that is running already: two of one name would both carry out commands.

    Raises:
        TeamFailed: The team, or a robot of this name, is on this bus.
    """
    from acromovi.team.host_control import HostControl
    from acromovi.team.team import TeamFailed
    from bus.keys import ALIVE

    taken: set[str] = set()
    ours = {HostControl.alive_key(team.name): f"the team {team.name}"}
    ours |= {ALIVE.key(robot.name): f"a robot {robot.name}" for robot in team.robots}
    watching = [bus.watch_alive(key, lambda key, is_there: taken.add(key)) for key in ours]
    await asyncio.sleep(MEETING_TIME)
    for each in watching:
        each.close()
    if taken:
        raise TeamFailed(f"{ours[min(taken)]} is on this bus already; end it first, or use another --bus")


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

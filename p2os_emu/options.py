"""The command line of `p2os-emu`."""

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import configs
from configs.command_line import CommandParser
from configs.defaults import EMPTY_WORLD, LINK, WORLD
from configs.team_file import MOST_ROBOTS, TeamFile, read_team
from geometry import Pose2D
from p2os_emu.fault_spec import FaultError, FaultSpec, parse_fault
from p2os_emu.pacing import FASTEST, SLOWEST

EXIT_OK = 0
EXIT_PARTS = 1
EXIT_USAGE = 2  # argparse's own
EXIT_CONFIG = 3
EXIT_PORT = 4
EXIT_PHYSICS = 5
MOBILESIM_PORT = 8101
"""Where clients look for a simulator."""

_EXAMPLES = """\
examples:
  p2os-emu --robot powerbot                          a PowerBot in the office, on a pseudo-terminal of its own
  p2os-emu --robot p3dx:happy --pty /tmp/happy       always at the same path
  p2os-emu --robot p3dx --robot p2dx --tcp 8101      two robots, on TCP ports 8101 and 8102
  p2os-emu --robot p3dx --fit gripper,laser,ptz:vcc4 with accessories; the laser has a port of its own
  p2os-emu --team acromovi                           one PowerBot and six Pioneers, each as its file says
  p2os-emu --robot p3dx --world lab.map --link rs232 in a world of an ARIA map, on a cable of 9600 baud
  p2os-emu -m lab.map -r p3dx:happy -p 8101          as with MobileSim; -R p3dx makes a robot for every client
  p2os-emu --robot p3dx --fault line-cut:robot=p3dx@5+10
                                                     5 s after the start the cable is cut for 10 s
  p2os-emu --robot p3dx --record drive.jsonl         write down all that flows on its cable
  p2os-emu --serve drive.jsonl --pty /tmp/happy      a client meets the robot as it was recorded
  p2os-emu --check robot.jsonl                       where does the emulator part from a recorded robot?

exit codes:
  0  ended by --duration, by SIGINT, by SIGTERM or over the control socket
  1  --check found that the recorded robot and the emulated one part
  2  the command line is wrong
  3  a robot, world, link or fault does not exist, or a file has an error
  4  a port, a path for one or the control socket cannot be had
  5  the physics engine is missing, or has no display for --gui
"""


class PhysicsError(Exception):
    """There is no physics engine, or it cannot start."""


@dataclass(frozen=True, slots=True)
class EmulatorOptions:
    """What was asked for on the command line.

    places: where robots of a team begin. link: the line of every robot that `links` does not name.
    speed: emulated s per s. duration: s of emulated time.
    """

    robots: tuple[str, ...]
    places: Mapping[str, Pose2D]
    factory: str | None
    fits: tuple[str, ...]
    world: str
    pty: Path | None
    tcp: int | None
    link: str
    links: Mapping[str, str]
    seed: int
    speed: float
    faults: tuple[FaultSpec, ...]
    fault_files: tuple[Path, ...]
    duration: float | None
    control: Path | None
    flash: Path | None
    gui: bool
    perfect: bool
    hangup_stops: bool
    as_simulator: bool
    record: Path | None
    force: bool
    serve: Path | None
    check: Path | None
    until_stdin_closes: bool
    json: bool
    quiet: bool
    listing: str | None


def parse(argv: Sequence[str] | None = None) -> EmulatorOptions:
    """Read the command line; ends the program with exit code 2 and a message where it is wrong.

    Raises:
        ConfigError: There is no such team, its file has an error, or there are too many robots.
    """
    parser = _parser()
    given = parser.parse_args(argv)
    if given.only is not None and not given.team:
        parser.error("--only chooses among the robots of a team: give --team as well")
    places = _add_emulated(given, read_team(given.team)) if given.team else {}
    needs_robot = given.listing is None and given.serve is None and given.check is None
    if needs_robot and not (given.robot or given.tcp_robot or given.factory):
        parser.error("which robot? give --robot MODEL[:NAME] or --team; --list-robots shows the models")
    if given.factory and given.pty is not None:
        parser.error("-R serves its clients on TCP: give -p PORT, not --pty")
    if (given.tcp_robot or given.factory) and given.pty is None and given.tcp is None:
        given.tcp = MOBILESIM_PORT
    if given.pty is not None and given.tcp is not None:
        parser.error("a robot has one port: give --pty or --tcp, not both")
    if (count := len(given.robot) + len(given.tcp_robot)) > MOST_ROBOTS:
        raise configs.ConfigError(f"{count} robots are too many; use at most {MOST_ROBOTS}")
    links = {name: profile for name, _, profile in (text.rpartition("=") for text in given.link)}
    as_given = {each.name: getattr(given, each.name) for each in fields(EmulatorOptions) if hasattr(given, each.name)}
    as_given |= {name: tuple(value) for name, value in as_given.items() if isinstance(value, list)}
    changed = {
        "robots": (*given.robot, *given.tcp_robot),
        "places": places,
        "world": given.world or (WORLD if given.check is None else EMPTY_WORLD),
        "link": links.pop("", LINK),
        "links": links,
    }
    return EmulatorOptions(**as_given | changed)


def _add_emulated(given: argparse.Namespace, team: TeamFile) -> dict[str, Pose2D]:
    """Add a team's emulated robots to what was asked for; returns where those begin that have a place of their own."""
    robots = [robot for robot in team.robots if robot.is_emulated]
    for name in given.only or ():
        if name not in [robot.name for robot in robots]:
            raise configs.ConfigError(f"--only {name}: no emulated robot of {given.team} has this name")
    robots = [robot for robot in robots if given.only is None or robot.name in given.only]
    given.robot += [f"{robot.model}:{robot.name}" for robot in robots]
    given.fits += [f"{robot.name}={','.join(robot.fit)}" for robot in robots if robot.fit]
    given.world = given.world or team.world
    own = [f"{robot.name}={robot.link}" for robot in robots if robot.link]
    given.link = [team.link, *own, *given.link]  # what stands later wins
    return {robot.name: Pose2D(*robot.at_m, math.radians(robot.heading_deg)) for robot in robots if robot.at_m}


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="p2os-emu",
        description="Emulates Pioneer and PowerBot robots: a client that opens the port meets one as on its own cable.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_version()
    _add_team(parser)
    _add_ports(parser)
    _add_run(parser)
    _add_recordings(parser)
    _add_lists(parser)
    return parser


def _add_team(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("robots and world")
    group.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar="MODEL[:NAME]",
        help="add a robot of this model; repeatable; its default name is that of its model, then MODEL-2 and so on",
    )
    group.add_argument(
        "--team", metavar="NAME|FILE", help="add the emulated robots of a team, with their accessories, world and line"
    )
    group.add_argument(
        "--only",
        type=lambda text: text.split(","),
        metavar="NAME,...",
        help="start only these robots of a team",
    )
    group.add_argument(
        "-r",
        dest="tcp_robot",
        action="append",
        default=[],
        metavar="MODEL[:NAME]",
        help=f"add a robot on TCP, as MobileSim does [port {MOBILESIM_PORT}, or that of -p]",
    )
    group.add_argument(
        "-R",
        "--robot-factory",
        dest="factory",
        metavar="MODEL",
        help="make a robot of this model for each client on TCP; it is removed with its client",
    )
    group.add_argument(
        "--fit",
        dest="fits",
        action="append",
        default=[],
        metavar="[NAME=]PART,...",
        help="fit accessories to every robot or to the one named; no-PART removes one; --list-parts shows them",
    )
    group.add_argument(
        "-m",
        "--map",
        "--world",
        dest="world",
        metavar="NAME|FILE",
        help="set the world: a name, a .toml or .map file, or FAMILY:SEED for a generated floor, as hall:7; "
        f"--list-worlds shows them [{WORLD}; {EMPTY_WORLD} for --check]",
    )
    group.add_argument(
        "--as-simulator",
        action="store_true",
        help="execute MobileSim's commands, which a real robot does not know: SIM_SET_POSE, SIM_STAT and the others, "
        "and 35 to 38 for a laser in the robot's own line; the serial number is SIM",
    )
    group.add_argument("--perfect", action="store_true", help="remove imperfections: exact wheels, sonar without noise")
    group.add_argument(
        "--flash",
        type=Path,
        metavar="FILE",
        help="replace FLASH parameters of every robot by those of a TOML file",
    )
    group.add_argument("--seed", type=int, default=0, metavar="N", help="set the seed of the random generator [0]")
    group.add_argument("--gui", action="store_true", help="show the world in a window")


def _add_ports(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("ports")
    group.add_argument(
        "--pty",
        type=Path,
        metavar="PATH",
        help="make a symbolic link to the port; with several robots one PATH-NAME for each",
    )
    group.add_argument(
        "-p",
        "--tcp",
        dest="tcp",
        type=_tcp_port,
        metavar="PORT",
        help="listen on TCP instead, on this machine only; further robots get the next ports; 0: any free port",
    )
    group.add_argument(
        "--link",
        action="append",
        default=[],
        metavar="[NAME=]PROFILE",
        help="set the line profile of every robot or of the one named [ideal]",
    )
    group.add_argument(
        "--hangup-stops", action="store_true", help="stop a robot whose client closed the port; no real one could"
    )
    group.add_argument(
        "--control", type=Path, metavar="PATH", help="set the path of the control socket [in a private folder]"
    )


def _add_run(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("run")
    group.add_argument("--duration", type=_positive, metavar="SECONDS", help="end after this emulated time, s")
    group.add_argument(
        "--until-stdin-closes",
        action="store_true",
        help="end when the pipe on standard input is closed, so that no program leaves its emulator behind",
    )
    group.add_argument(
        "--speed",
        type=_speed,
        default=1.0,
        metavar="X",
        help=f"set the emulated seconds per second, {SLOWEST:g} to {FASTEST:g} [1]; at any other than 1 the clients' "
        "watchdogs and the robot's no longer agree",
    )
    group.add_argument(
        "--fault",
        dest="faults",
        type=_fault,
        action="append",
        default=[],
        metavar="NAME[:key=value,...][@START[+DURATION]]",
        help="schedule a fault; START counts from the start, s; repeatable",
    )
    group.add_argument(
        "--fault-file",
        dest="fault_files",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="schedule the faults of a file, one a line as above, # begins a comment; repeatable",
    )
    group.add_argument("--json", action="store_true", help="print one line of JSON once every robot is ready")
    group.add_argument("--quiet", action="store_true", help="print errors only")


def _add_recordings(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "recordings", "recorded lines: one JSON object a line, with t (s), from (host or robot) and hex"
    )
    group.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="record the robot's line; with several robots one FILE-NAME for each; an existing file is an error",
    )
    group.add_argument("--force", action="store_true", help="let --record overwrite existing files")
    group.add_argument(
        "--serve",
        type=Path,
        metavar="FILE",
        help="replay a recording: answer a client as the recorded robot answered the same commands",
    )
    group.add_argument(
        "--check",
        type=Path,
        metavar="FILE",
        help="send the recorded client's bytes to an emulated robot and print where its answers differ; the model is "
        "the recorded one unless --robot gives another",
    )


def _add_lists(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("lists")
    for kind in ("robots", "parts", "teams", "worlds", "links", "faults"):
        group.add_argument(f"--list-{kind}", action="store_const", const=kind, dest="listing", help=f"list the {kind}")


def _tcp_port(text: str) -> int:
    port = int(text) if text.isascii() and text.isdecimal() else -1
    if not 0 <= port <= 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is not a TCP port; give a number from 0 to 65535")
    return port


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} will not do; give a number above zero")
    return number


def _speed(text: str) -> float:
    number = _positive(text)
    if not SLOWEST <= number <= FASTEST:
        raise argparse.ArgumentTypeError(f"{text!r} is not possible; give a number from {SLOWEST:g} to {FASTEST:g}")
    return number


def _fault(text: str) -> FaultSpec:
    try:
        return parse_fault(text)
    except FaultError as error:
        raise argparse.ArgumentTypeError(str(error)) from error

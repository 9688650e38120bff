"""The command `p2os-gateway`: brings a robot on a serial port to the bus."""

import argparse
import sys
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from configs import ConfigError
from configs.command_line import CommandParser
from configs.defaults import VARIABLE, default_bus
from gateway.elements.all_elements import cable_kinds
from gateway.errors import ExitCode, GatewayError, PortBusy
from gateway.gateway import GatewayOptions
from gateway.line import RADIO_BAUD
from gateway.robot_service import RobotPlan, serve_robots
from gateway.settings import Settings, load_settings
from p2os import BAUD_CODES

EXIT_OK = 0
SWITCH_INTERVAL = 0.001
"""Seconds after which a thread yields to others; the default of Python, 0.005, adds to the latencies."""

FLAGS = ("--help", "--version", "--radio", "--wait", "--force", "--quiet", "--json", "-h")
"""Options without a value."""
SHARED_OPTIONS = ("--help", "--version", "--bus", "--wait", "--force", "--quiet", "--json", "-h")
"""Options that hold for all robots of the process; any other is of the robot whose port it follows."""

EPILOG = """\
examples:
  p2os-gateway /dev/ttyUSB0                            a robot on an adapter, under the name it gives itself
  p2os-gateway /tmp/happy --name happy --wait          an emulated one, also if it is not there yet
  p2os-gateway socket://localhost:8101                 behind a TCP bridge
  p2os-gateway /dev/ttyS0 --baud 9600 --config happy.toml
  p2os-gateway /dev/ttyUSB0 --camera http://10.0.0.7/video
                                                       with the pictures of its IP camera
  p2os-gateway /dev/ttyS1 --radio                      a robot behind radio modems
  p2os-gateway /dev/ttyS0 --name a --laser /dev/ttyS1 /dev/ttyS2 --name b
                                                       two robots in one process; options follow the port of their
                                                       robot, and --bus, --wait, --force, --quiet, --json are for all

exit codes: 0 ended by a signal, 2 usage or configuration, 3 no such port, 4 not a port, 5 no permission, 6 port in use,
7 no robot answers, 8 something else answers, 9 unknown robot model, 11 another gateway has the name; with several
ports, that of the first robot that failed if all have failed"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `p2os-gateway`; return its exit code."""
    given = parse_arguments(sys.argv[1:] if argv is None else argv)
    sys.setswitchinterval(SWITCH_INTERVAL)
    failures: list[int] = []

    def fail(plan: RobotPlan, error: Exception) -> None:
        failures.append(_report_failure(plan.options, error))

    try:
        plans = [_plan(arguments, is_one_of_many=len(given) > 1) for arguments in given]
        serve_robots(plans, fail)
    except (ConfigError, GatewayError) as error:  # of the settings, before any robot is served
        return _fail(error, getattr(error, "exit_code", ExitCode.USAGE))
    return failures[0] if len(failures) == len(plans) else EXIT_OK


def parse_arguments(words: Sequence[str]) -> list[argparse.Namespace]:
    """Return the arguments of each robot; end the program with exit code 2 if they cannot be used."""
    parser = _parser()
    given = [parser.parse_args(group) for group in _by_robot(parser, words)]
    for arguments in given:
        if arguments.radio and arguments.baud not in (None, RADIO_BAUD):
            parser.error(f"radio modems know {RADIO_BAUD} bit/s only; leave out --baud, or --radio")
    for what in "port", "name":
        values = [value for arguments in given if (value := getattr(arguments, what)) is not None]
        for value in values:
            if values.count(value) > 1:
                parser.error(f"the {what} {value} is given for two robots")
    return given


def _by_robot(parser: argparse.ArgumentParser, words: Sequence[str]) -> list[list[str]]:
    """Split the command line into one for each robot: a port, the options after it, and those for all robots."""
    groups: list[list[str]] = []
    before: list[str] = []  # the first port
    shared: list[str] = []
    rest = deque(words)
    while rest:
        word = rest.popleft()
        if not word.startswith("-"):
            groups.append([word])
            continue
        is_flag = any(flag.startswith(word) for flag in FLAGS)
        option = [word] if is_flag or "=" in word or not rest else [word, rest.popleft()]
        is_shared = any(name.startswith(word.partition("=")[0]) for name in SHARED_OPTIONS)
        (shared if is_shared else groups[-1] if groups else before).extend(option)
    if len(groups) < 2:
        return [list(words)]
    if before:
        parser.error(
            f"{before[0]} is before the first port; with several ports, an option follows the port of its robot"
        )
    return [[*group, *shared] for group in groups]


def _plan(arguments: argparse.Namespace, *, is_one_of_many: bool) -> RobotPlan:
    """Return what the parsed command line says of one robot.

    Raises:
        ConfigError: The settings cannot be used.
        GatewayError: The address of an element cannot be one.
    """
    settings = Settings() if arguments.config is None else load_settings(arguments.config)
    settings = replace(settings, radio=settings.radio or arguments.radio)
    options = GatewayOptions(
        port=arguments.port,
        name=arguments.name,
        bus=arguments.bus,
        waits=arguments.wait,
        forces=arguments.force,
        is_quiet=arguments.quiet,
        is_json=arguments.json,
        is_one_of_many=is_one_of_many,
    )
    cables = [(kind, address) for kind in cable_kinds() if (address := getattr(arguments, kind.name)) is not None]
    for kind, address in cables:
        kind.check(address)
        settings = replace(settings, fitted=replace(settings.fitted, **kind.fitted))
    return RobotPlan(options, settings, arguments.baud, cables)


def _report_failure(options: GatewayOptions, error: Exception) -> int:
    """Print why a robot cannot be served any more; return the exit code for that."""
    if not isinstance(error, ConfigError | GatewayError):
        raise error
    sentence = str(error)
    if isinstance(error, PortBusy):
        from gateway.local_ports import holders  # here and not at the top: rarely needed

        if held := " and ".join(map(str, holders(options.port))):
            sentence = f"{sentence}; it is held by {held}"
    options.report_error(sentence)
    code = error.exit_code if isinstance(error, GatewayError) else ExitCode.USAGE
    if options.is_one_of_many and options.is_json:
        options.report_event(sentence, {"event": "ended", "reason": sentence, "exit_code": code})
    return code


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="p2os-gateway",
        description="Bring a robot on a port to the bus: odometry, sonar and more under NAME/; NAME/cmd_vel drives it.",
        epilog=EPILOG,
        usage="%(prog)s PORT [options] [PORT [options] ...]",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_version()
    parser.add_argument("port", metavar="PORT", help="a device, socket://HOST:PORT or rfc2217://HOST:PORT")
    parser.add_argument("--name", help="name of the robot on the bus [the robot's own name]")
    parser.add_argument("--baud", type=_baud, metavar="auto|N", help="connect at this rate only, bit/s [auto]")
    parser.add_argument("--radio", action="store_true", help="dial a radio modem, and send only what it carries")
    for kind in cable_kinds():
        parser.add_argument(f"--{kind.name}", metavar=kind.metavar, help=kind.help)
    parser.add_argument("--config", type=Path, metavar="FILE", help="read the settings of this robot from a TOML file")
    parser.add_argument(
        "--bus",
        default=default_bus(),
        metavar="PROFILE",
        help="profile of the bus: local[:NAME] (this machine only), lan, router, secure[:FOLDER OF KEYS], or a file "
        f"[%(default)s; {VARIABLE} changes it]",
    )
    parser.add_argument("--wait", action="store_true", help="search for port and robot until they appear")
    parser.add_argument(
        "--force", action="store_true", help="wait until another gateway of this name has ended, then take its place"
    )
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    parser.add_argument("--json", action="store_true", help="print events as JSON, one line each")
    return parser


def _baud(text: str) -> int | None:
    if text == "auto":
        return None
    rates = sorted(BAUD_CODES.values())
    if not text.isdecimal() or int(text) not in rates:
        raise argparse.ArgumentTypeError(f"{text!r} is no rate; use auto or one of {', '.join(map(str, rates))}")
    return int(text)


def _fail(error: Exception | str, code: int) -> int:
    print(f"p2os-gateway: {error}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())

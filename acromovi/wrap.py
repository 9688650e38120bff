"""`acromovi wrap`: run a program or a C library as an agent, described by a file."""

import argparse
import asyncio
import sys

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi wrap acts --name acts@happy
      the colour tracker ACTS, which runs already, as an agent of the robot happy
  acromovi wrap ./counter.toml --name counter@happy
      a file of your own; docs/wrappers.md shows how to write one
  acromovi ask acts@happy blobs
      ask it, from anywhere on the bus

The program starts and ends with its agent, and is started again when it ends by itself. Exit codes: 1 not possible
(the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="wrapper: a name in configs/wrappers, or a path")
    parser.add_argument("--name", metavar="AGENT", required=True, help="set the agent's name, such as acts@happy")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Host the agent until it is stopped or a signal is received."""
    from acromovi.alone import live_alone
    from acromovi.container import ending_in_time
    from agents.platform import AgentError, AgentName
    from agents.wrappers.wrapped import Wrapped
    from agents.wrappers.wrapper_file import WrapperFile
    from bus.session import ZenohBus

    try:
        agent = Wrapped(AgentName.parse(arguments.name), *WrapperFile.load(arguments.file))
        with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
            has_begun = asyncio.run(live_alone(bus, agent, "wrap", end))
    except AgentError as error:
        print(f"acromovi wrap: {error}", file=sys.stderr)
        return 1
    return end.code or int(not has_begun)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

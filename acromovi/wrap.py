"""`acromovi wrap`: make an agent of a program or a C library, as a file says."""

import argparse
import asyncio
import sys
from typing import TYPE_CHECKING

from acromovi.container import End, ending_in_time
from acromovi.options import add_bus

if TYPE_CHECKING:
    from agents.platform import Report
    from agents.wrappers.wrapped import Wrapped
    from bus.bus import Bus

EPILOG = """\
examples:
  acromovi wrap acts --name colours@happy
      the colour tracker ACTS, which runs already, as an agent of the robot happy
  acromovi wrap ./counter.toml --name counter@happy
      a file of your own; docs/wrappers.md shows how to write one
  acromovi ask colours@happy blobs
      ask it, from anywhere on the bus

The program starts and ends with its agent, and is started again when it ends by itself. Exit codes: 1 not possible
(the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("file", metavar="FILE", help="the wrapper: one of configs/wrappers, or a path")
    parser.add_argument("--name", metavar="AGENT", required=True, help="of the agent, such as colours@happy")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Let the agent live until a signal comes."""
    from agents.platform import AgentError, AgentName
    from agents.wrappers.wrapped import Wrapped
    from agents.wrappers.wrapper_file import load_wrapper
    from bus.session import ZenohBus

    try:
        agent = Wrapped(AgentName.parse(arguments.name), *load_wrapper(arguments.file))
        with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
            asyncio.run(_live(bus, agent, end))
    except AgentError as error:
        print(f"acromovi wrap: {error}", file=sys.stderr)
        return 1
    return end.code


async def _live(bus: "Bus", agent: "Wrapped", end: End) -> None:
    """Host it, in a container of its own."""
    from agents.platform import Container

    def report(report: "Report") -> None:
        why = "" if report.error is None else f": {report.error}"
        print(f"acromovi wrap: {report.agent}: {report.what}{why}", file=sys.stderr, flush=True)

    name = agent.name
    async with Container(bus, f"{name.local}-{name.platform}", report, platform=name.platform) as container:
        if not await container.start(agent):
            end.tell(1)
            return
        asked = ", ".join(agent.describe()["requests"]) or "nothing"
        print(f"{name} lives, and can be asked for {asked}; stop with Ctrl-C", flush=True)
        await end.wait()

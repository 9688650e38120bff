"""`acromovi promote`: make an application an agent of the upper layer."""

import argparse
import asyncio
import sys
from typing import TYPE_CHECKING

from acromovi.container import End, ending_in_time
from acromovi.options import add_bus
from acromovi.run import add_application, chosen

if TYPE_CHECKING:
    from agents.face.application import Application
    from agents.platform import Report
    from bus.bus import Bus

EPILOG = """\
examples:
  acromovi promote wander.py robot=happy
      the agent wander@apps, in a container of its own, until Ctrl-C
  acromovi ask wander@apps turns
      ask it, from anywhere on the bus, for a function that is marked with @request("turns")
  acromovi agent suspend wander@apps
      let it rest; also resume and stop

Exit codes: 0 it has ended, 1 it has failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by
SIGTERM.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    add_application(parser)
    parser.add_argument("--name", help="of the agent, such as night_watch or night_watch@lab (default: the file's)")
    add_bus(parser)


def run(options: argparse.Namespace) -> int:
    """Let the agent live until it ends, or a signal comes."""
    from agents import RobotError
    from agents.face.application import Application
    from agents.face.backstage import PLATFORM
    from agents.platform import AgentError, AgentName
    from bus.session import ZenohBus

    try:
        program = chosen(options)
        name = options.name or program.name
        with ending_in_time() as end, ZenohBus.open(options.bus) as bus:
            full_name = name if "@" in name else f"{name}@{bus.own_name or PLATFORM}"
            agent = Application(program, AgentName.parse(full_name), dict(options.arguments))
            asyncio.run(_live(bus, agent, end))
    except (RobotError, AgentError) as err:
        print(f"acromovi promote: {err}", file=sys.stderr)
        return 1
    return end.code


async def _live(bus: "Bus", agent: "Application", end: End) -> None:
    """Host the agent, in a container of its own."""
    from agents.platform import AlreadyThere, Container, Directory

    with Directory(bus) as directory:
        if await directory.find(agent.name) is not None:
            raise AlreadyThere(f"there is an agent {agent.name} already; give this one another --name")

    def report(report: "Report") -> None:
        why = "" if report.error is None else f": {report.error}"
        print(f"acromovi promote: {report.agent}: {report.what}{why}", file=sys.stderr, flush=True)

    async with Container(bus, agent.name.local, report, platform=agent.name.platform) as container:
        has_begun = await container.start(agent)
        if has_begun:
            asked = ", ".join(agent.describe()["requests"]) or "nothing"
            print(f"{agent.name} lives, and can be asked for {asked}; stop with Ctrl-C", flush=True)
        told = asyncio.ensure_future(end.wait())
        ended = asyncio.ensure_future(agent.ended.wait())
        await asyncio.wait([told, ended], return_when=asyncio.FIRST_COMPLETED)
        told.cancel()
        ended.cancel()
    if not end.code and (agent.has_failed or not has_begun):
        end.tell(1)

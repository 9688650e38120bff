"""`acromovi promote`: make an application an agent of the upper layer."""

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.options import add_bus
from acromovi.run import add_application, chosen
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.client.program import RunningApplication
    from agents.platform import AgentName

LOADER = "loader"
EPILOG = """\
examples:
  acromovi promote wander.py robot=happy
      the agent wander@apps, in a container of its own, until Ctrl-C
  acromovi promote wander.py robot=happy --into loader
      the same in the care of a team that runs (acromovi up TEAM --apps FOLDER): it lives on when this terminal is
      closed, and is started again when its process ends. wander.py must lie in FOLDER on the team's machine
  acromovi promote wander.py --into workshop
      in a container that was started with: acromovi container workshop --apps FOLDER
  acromovi ask wander@apps turns
      ask it, from anywhere on the bus, for a function that is marked with @request("turns")
  acromovi agent suspend wander@apps
      let it rest; also resume and stop

Exit codes: 0 it has ended, or lives where it was sent, 1 it has failed (the reason is on stderr), 2 wrong usage, 130
stopped by Ctrl-C, 143 by SIGTERM.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_application(parser)
    parser.add_argument(
        "--name", help="set the agent's name, such as night_watch or night_watch@lab [that of the file]"
    )
    parser.add_argument(
        "--into",
        metavar="PLACE",
        help="send it to a container, or to loader, the running team's (loader@TEAM with several teams)",
    )
    add_bus(parser)


def _run(options: argparse.Namespace) -> int:
    """Host the agent until it ends or a signal is received, or send it to another container."""
    from agents import RobotError
    from agents.platform import AgentError

    try:
        program = chosen(options)
        _named(program, options, None)  # before anything is begun
        return _send(program, options) if options.into else _live(program, options)
    except (RobotError, AgentError) as err:
        print(f"acromovi promote: {err}", file=sys.stderr)
        return 1


def _named(program: "RunningApplication", options: argparse.Namespace, own_name: str | None) -> "AgentName":
    """What its agent is called, after the owner of a key where the bus lets nobody else speak."""
    from agents.client.private_container import PLATFORM
    from agents.platform import AgentName

    name = options.name or program.name
    return AgentName.parse(name if "@" in name else f"{name}@{own_name or PLATFORM}")


def _live(program: "RunningApplication", options: argparse.Namespace) -> int:
    """Host it here."""
    from acromovi.alone import live_alone
    from acromovi.container import ending_in_time
    from agents.client.application import Application
    from bus.session import ZenohBus

    with ending_in_time() as end, ZenohBus.open(options.bus) as bus:
        agent = Application(program, _named(program, options, bus.own_name), dict(options.arguments))
        has_begun = asyncio.run(live_alone(bus, agent, "promote", end))
    return end.code or int(agent.has_failed or not has_begun)


def _send(program: "RunningApplication", options: argparse.Namespace) -> int:
    """Send it to a loader or a container."""
    from acromovi.sending import into_container, into_loader
    from agents.services.loaded import digest
    from bus.session import ZenohBus

    given = {"program": program.name, "arguments": dict(options.arguments)}
    given["sha256"] = digest(Path(str(program.module.__file__)))
    send = into_loader if options.into.partition("@")[0] == LOADER else into_container
    with ZenohBus.open(options.bus) as bus:
        name = _named(program, options, bus.own_name)
        container = send(bus, options.into, name, given)
    print(f"{name} lives in {container}; end it with: acromovi agent stop {name}")
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

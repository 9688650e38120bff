"""`acromovi promote`: make an application an agent of the upper layer."""

import argparse
import asyncio
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus
from acromovi.run import add_application, chosen
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.client.program import RunningApplication
    from agents.platform import AgentName
    from bus.bus import Bus

LOADER = "loader"
PATIENCE = 60.0  # s for a process to begin, and an application in it
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
    from agents.client.team import PLATFORM
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
    """Send it to a loader or a container. Only its name is sent; the program must be installed there."""
    from agents.services.loaded import digest
    from bus.session import ZenohBus

    given = {"program": program.name, "arguments": dict(options.arguments)}
    given["sha256"] = digest(Path(str(program.module.__file__)))
    send = _into_loader if options.into.partition("@")[0] == LOADER else _into_container
    with ZenohBus.open(options.bus) as bus:
        name = _named(program, options, bus.own_name)
        container = send(bus, options.into, name, given)
    print(f"{name} lives in {container}; end it with: acromovi agent stop {name}")
    return 0


def _into_loader(bus: "Bus", which: str, agent: "AgentName", given: Mapping[str, Any]) -> str:
    """Ask a team's loader to load an application.

    Args:
        bus: Where the team is.
        which: `loader@TEAM`, or `loader` for the only one there is.
        agent: What the application is to be called.
        given: Program, arguments and digest.
    Returns:
        The container where it lives.
    Raises:
        NotOnBus: There is no such loader, or several.
        Refused: The loader does not, or has failed; says why.
    """
    from acromovi.ask import ask
    from acromovi.known_agents import KnownAgents
    from agents.platform import AgentName
    from bus.errors import Refused

    loader = AgentName.parse(which) if "@" in which else _only_loader(bus)
    with KnownAgents(bus) as known:
        known.expect(loader)
    asked = {"application": given["program"], "arguments": given["arguments"], "sha256": given["sha256"]}
    outcome = asyncio.run(ask(bus, loader, "load", {**asked, "name": str(agent)}, PATIENCE))
    if not outcome.is_done:
        raise Refused(outcome.why)
    return str(outcome.result["container"])


def _into_container(bus: "Bus", which: str, agent: "AgentName", given: Mapping[str, Any]) -> str:
    """Ask a container to start an application.

    Raises:
        NotOnBus: There is none of this name.
        Refused: The container does not; says why.
    """
    from acromovi.known_containers import find_container, tell
    from agents.services.loaded import KIND

    there = find_container(bus, which)
    tell(bus, there, "start", name=str(agent), kind=KIND, properties=dict(given))
    return there.name


def _only_loader(bus: "Bus") -> "AgentName":
    from acromovi.known_agents import KnownAgents, NotOnBus
    from agents.services.loader import SERVICE

    with KnownAgents(bus) as known:
        found, _ = known.describe(SERVICE)
    if not found:
        raise NotOnBus(
            "no team here has a loader: start one with acromovi up TEAM --apps FOLDER, and see whether both use the "
            "same --bus"
        )
    if len(found) > 1:
        names = ", ".join(str(each.name) for each in found)
        raise NotOnBus(f"several teams have a loader; say whose, --into {found[0].name} for example, of {names}")
    return found[0].name


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

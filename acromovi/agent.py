"""`acromovi agent`: start, stop, suspend, resume, move or clone an agent."""

import argparse
import json
from typing import Any

from acromovi.options import add_bus, argument
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi agent start follow@happy follow:Follow speed=0.3 --in workshop
      an agent of the class Follow in follow.py, which is in a folder that the container was given with --apps; a class
      that comes with Acromovi is named alike: agents.components.generic:Generic
  acromovi agent suspend follow@happy
  acromovi agent resume follow@happy
  acromovi agent move follow@happy attic
      with what it keeps and the messages that wait for it; a class of your own needs the same --apps there
  acromovi agent clone follow@happy twin@happy --in attic
      a copy with what it keeps, under another name; messages that wait stay with the original
  acromovi agent stop follow@happy

With --json one line is printed: {"name": AGENT, "state": STATE, "container": NAME}

Exit codes: 0 done, 1 refused, or no such agent, container or kind (the reason is on stderr), 2 wrong usage.
"""
SUMMARIES = {
    "start": "start an agent in a container",
    "stop": "end an agent",
    "suspend": "let an agent rest: it does nothing, refuses requests, and keeps messages",
    "resume": "let a suspended agent go on",
    "move": "move an agent into another container, with its state",
    "clone": "start a copy of an agent under another name, with its state",
}


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="|".join(SUMMARIES), required=True)
    for name, summary in SUMMARIES.items():
        action = actions.add_parser(
            name,
            help=summary,
            description=f"{summary[0].upper()}{summary[1:]}.",
            epilog=EPILOG,
            formatter_class=parser.formatter_class,
            allow_abbrev=False,
        )
        action.add_argument("agent", metavar="NAME", help="name of the agent, such as follow@happy")
        if name == "start":
            action.add_argument("kind", metavar="KIND", help="module:Class, such as follow:Follow")
            action.add_argument(
                "properties", metavar="KEY=VALUE", nargs="*", default=(), type=argument, help="JSON, or else text"
            )
            action.add_argument(
                "--in", dest="container", metavar="CONTAINER", required=True, help="container of the agent"
            )
        if name == "move":
            action.add_argument("container", metavar="CONTAINER", help="container to move it to")
        if name == "clone":
            action.add_argument("clone", metavar="CLONE", help="name of the copy, such as twin@happy")
            action.add_argument("--in", dest="container", metavar="CONTAINER", help="container of the copy [the same]")
        action.add_argument("--json", action="store_true", help="print one line of JSON")
        add_bus(action)


def _run(arguments: argparse.Namespace) -> int:
    """Send the request to the container and print the result."""
    from acromovi.known_containers import find_container, home_of, tell
    from agents.platform.names import AgentName
    from bus.session import ZenohBus

    agent = AgentName.parse(arguments.agent)
    with ZenohBus.open(arguments.bus) as bus:
        given: dict[str, Any] = {"name": str(agent)}
        if arguments.action == "start":
            there = find_container(bus, arguments.container)
            given |= {"kind": arguments.kind, "properties": dict(arguments.properties)}
        else:
            there = find_container(bus, home_of(bus, agent))
        if arguments.action == "move":
            given |= {"to": find_container(bus, arguments.container).name}
        if arguments.action == "clone":
            to = find_container(bus, arguments.container) if arguments.container else there
            given |= {"as": str(AgentName.parse(arguments.clone)), "to": to.name}
        answer = {"container": there.name, **tell(bus, there, arguments.action, **given)}
    for_people = f"{answer['name']} is {answer['state']} in {answer['container']}"
    print(json.dumps(answer) if arguments.json else for_people)
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi introspect`: print the state of a running agent."""

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi introspect base@happy
  acromovi introspect base@happy --json

It shows where the agent lives and in which state, the messages that wait in its mailbox, its behaviours and how often
each has failed, the streams that it hears, and the conversations that it is answering. With --json it is one object:
{"name", "state", "kind", "container", "services", "requests", "properties", "malformed",
 "mailbox": {"waiting", "delivered", "dropped", "oldest": [...]}, "behaviours": [...], "streams": [...],
 "in_flight": [...], ...}

Exit codes: 0 done, 1 no such agent, or it does not answer (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("agent", metavar="AGENT", help="name of the agent, such as base@happy")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Ask the agent's container, and print what it says."""
    from acromovi.known_containers import find_container, home_of
    from agents.platform.names import AgentName
    from bus.session import ZenohBus

    agent = AgentName.parse(arguments.agent)
    with ZenohBus.open(arguments.bus) as bus:
        home = find_container(bus, home_of(bus, agent))
        asked = {"do": "introspect", "name": str(agent)}
        seen = bus.query(home.description_key, asked)[0].value
    print(json.dumps(seen, ensure_ascii=False) if arguments.json else "\n".join(_lines(seen)))
    return 0


def _lines(seen: Mapping[str, Any]) -> Iterator[str]:
    """Return the state of an agent as lines of text."""
    yield f"{seen['name']} is {seen['state']} in {seen['container']}, of the kind {seen['kind']}"
    for title, of_what in (("services", "services"), ("requests", "requests")):
        yield f"{title}: {', '.join(seen[of_what]) or 'none'}"
    for key, value in seen["properties"].items():
        yield f"property {key}: {json.dumps(value, ensure_ascii=False)}"
    box = seen["mailbox"]
    yield (
        f"mailbox: {box['waiting']} waiting, {box['delivered']} delivered, {box['dropped']} dropped for want of room, "
        f"{seen['malformed']} malformed"
    )
    yield from _rows(map(_said, box["oldest"]))
    yield "behaviours:" if seen["behaviours"] else "behaviours: none"
    yield from _rows(f"{each['name']} ({each['kind']}), {_failures(each)}" for each in seen["behaviours"])
    yield "streams:" if seen["streams"] else "streams: none"
    yield from _rows(f"{each['key']}, {each['skipped']} skipped, {_failures(each)}" for each in seen["streams"])
    yield "answering:" if seen["in_flight"] else "answering: nobody"
    yield from _rows(f"{_said(each)}{', agreed' if each['agreed'] else ''}" for each in seen["in_flight"])


def _rows(texts: Iterator[str] | Sequence[str]) -> Iterator[str]:
    return (f"  {text}" for text in texts)


def _said(message: Mapping[str, Any]) -> str:
    return f"{message['performative']} of {message['sender']}: {message['content'] or 'nothing'}"


def _failures(row: Mapping[str, Any]) -> str:
    count = row["failures"]
    return "no failures" if not count else f"{count} failure{'s' if count > 1 else ''}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

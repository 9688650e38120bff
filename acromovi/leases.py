"""`acromovi leases`: print the leases and their history."""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TextIO

from acromovi.options import add_bus, count
from acromovi.ps import table
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from acromovi.known_agents import KnownAgents
    from bus.bus import Bus

PATIENCE = 2.0  # s for the arbiter
EPILOG = """\
examples:
  acromovi leases                  who holds what, as the robots' gateways know it
  acromovi leases --audit 20       and the last that the arbiter has written down
  acromovi leases --json
  acromovi echo acromovi/agents/arbiter/results      the record as it grows, of the team acromovi

A lease on base@happy is the sole right to move the wheels of happy, one on happy that to move anything of it.

With --json it prints one object, with `audit` only where that is asked for:
{"leases": [{"element": NAME, "holder": NAME, "priority": N, "expires_in": S}, ...],
 "audit": [{"time": S, "event": EVENT, "holder": NAME, "element": NAME, "priority": N, ...}, ...]}

EVENT is granted, refused, renewed (the first time only), warned, preempted, expired, released, died (the holder has),
lost (the gateway knew it no more) or adopted (an arbiter before this one, or the gateway, had given it).

A gateway that does not answer is told on stderr. Exit codes: 0 also when nobody holds anything, 1 the bus cannot be
reached or there is no arbiter to ask for its record, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--audit", type=count, metavar="N", help="print the last N rows of the arbiter's record as well"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Query gateways and arbiters once and print the leases."""
    from acromovi.known_agents import KnownAgents
    from agents.services.gateway_leases import held_leases
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus, KnownAgents(bus) as known:
        known.meet()
        held, left_out = asyncio.run(held_leases(bus))
        if left_out:
            print(f"acromovi leases: {left_out}", file=sys.stderr)
        report = {"leases": [*held, *named(bus, known)]}
        if arguments.audit:
            report["audit"] = _audit(bus, known, arguments.audit)
    if arguments.json:
        print(json.dumps(report))
    else:
        show(report, sys.stdout)
    return 0


def named(bus: "Bus", known: "KnownAgents") -> list[dict[str, Any]]:
    """The leases on names that are no part of a robot, which the arbiters alone know; none where one may only look."""
    from acromovi.ask import ask
    from agents.services.leases import NAMED, SERVICE
    from bus.errors import NotAllowed

    found: list[dict[str, Any]] = []
    arbiters, _ = known.describe(SERVICE)
    for arbiter in arbiters:
        try:
            outcome = asyncio.run(ask(bus, arbiter.name, "leases", {}, PATIENCE))
        except NotAllowed:
            return []
        if outcome.is_done:
            found += [row for row in outcome.result if str(row["element"]).startswith(NAMED)]
        else:
            print(f"acromovi leases: {arbiter.name} is left out: {outcome.why}", file=sys.stderr)
    return [{key: row[key] for key in ("element", "holder", "priority", "expires_in")} for row in found]


def _audit(bus: "Bus", known: "KnownAgents", last: int) -> list[dict[str, Any]]:
    """The end of the arbiter's record.

    Raises:
        RequestNotDone: There is no arbiter, or it does not answer.
    """
    from acromovi.ask import ask
    from agents.platform.errors import RequestNotDone
    from agents.services.leases import SERVICE

    arbiters, _ = known.describe(SERVICE)
    if not arbiters:
        raise RequestNotDone("there is no arbiter whose record could be shown; acromovi up starts one with a team")
    rows: list[dict[str, Any]] = asyncio.run(ask(bus, arbiters[0].name, "audit", {"last": last}, PATIENCE)).value()
    return rows


def show(report: Mapping[str, Sequence[Mapping[str, Any]]], output: TextIO) -> None:
    """Print it for people."""
    lines = [
        (row["element"], row["holder"], str(row["priority"]), f"{row['expires_in']:.1f} s") for row in report["leases"]
    ]
    if lines:
        print(table([("ELEMENT", "HOLDER", "PRIORITY", "EXPIRES IN"), *lines]), file=output)
    else:
        print("nobody holds a lease; whoever asks first moves what he likes", file=output)
    if rows := report.get("audit"):
        print(file=output)
        print(table([("TIME", "EVENT", "ELEMENT", "HOLDER", "PRIORITY", ""), *map(_line, rows)]), file=output)


def _line(row: Mapping[str, Any]) -> tuple[str, ...]:
    """A row of the record, with whatever more it says at the end."""
    at = time.strftime("%H:%M:%S", time.localtime(row["time"]))
    known = {name: str(row[name]) for name in ("event", "element", "holder", "priority")}
    more = ", ".join(f"{name} {value}" for name, value in row.items() if name not in (*known, "time"))
    return (at, *known.values(), more)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi topics`: list the robots and the keys with messages."""

import argparse
import json
import sys
import time
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Any, TextIO

from acromovi.options import add_bus, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from bus.bus import Bus, Sample

EPILOG = """\
examples:
  acromovi topics
  acromovi topics --seconds 10 --json

With --json it prints one object:
{"robots": [NAME, ...], "topics": [{"key": KEY, "type": TYPE, "rate": HZ, "count": N}, ...]}

Exit codes: 0 also when nothing flows, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--seconds", type=seconds, default=3.0, metavar="S", help="listen for this time [%(default)g s]"
    )
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Listen for a while, then print the list."""
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        report = listen(bus, arguments.seconds)
    show(report, arguments.json, sys.stdout)
    return 0


@dataclass
class _Flow:
    """Messages counted on one key; times in s on one steady clock."""

    type_name: str
    first: float
    last: float
    count: int = 1

    @property
    def rate(self) -> float:
        """Messages a second, from the time between first and last; 0 after only one."""
        return (self.count - 1) / (self.last - self.first) if self.last > self.first else 0.0


class Tally:
    """Counts messages by key; the bus's thread counts while another reads."""

    def __init__(self) -> None:
        self._flows: dict[str, _Flow] = {}
        self._lock = Lock()

    def add(self, sample: "Sample", now: float) -> None:
        """Count one message that arrived at `now`."""
        from acromovi.echo import type_of

        with self._lock:
            flow = self._flows.get(sample.key)
            if flow is None:
                self._flows[sample.key] = _Flow(type_of(sample) or sample.encoding, now, now)
            else:
                flow.count += 1
                flow.last = now

    def rows(self) -> list[dict[str, Any]]:
        """One row a key, sorted by key, as `--json` prints them."""
        with self._lock:
            return [
                {"key": key, "type": flow.type_name, "rate": round(flow.rate, 2), "count": flow.count}
                for key, flow in sorted(self._flows.items())
            ]


def listen(bus: "Bus", duration: float) -> dict[str, Any]:
    """Listen to everything for `duration` s; the result is what `--json` prints."""
    from acromovi.presence import RobotPresence

    tally = Tally()
    presence = RobotPresence(bus)
    with bus.subscribe("**", lambda sample: tally.add(sample, time.monotonic())):
        time.sleep(duration)
    return {"robots": presence.robots, "topics": tally.rows()}


def show(report: dict[str, Any], as_json: bool, output: TextIO) -> None:
    """Print a report."""
    if as_json:
        print(json.dumps(report), file=output)
        return
    robots, rows = report["robots"], report["topics"]
    print(f"robots: {', '.join(robots) or 'none; start one with p2os-gateway PORT'}", file=output)
    if not rows:
        print("nothing flows", file=output)
        return
    key_width = max(len(row["key"]) for row in rows)
    type_width = max(len(row["type"]) for row in rows)
    for row in rows:
        rate = f"{row['rate']:.1f} Hz" if row["rate"] else f"{row['count']} in all"
        print(f"{row['key']:<{key_width}}  {row['type']:<{type_width}}  {rate:>9}", file=output)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

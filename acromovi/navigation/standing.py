"""`acromovi navigate state`: print the state of a robot's mission."""

import argparse
import json
from collections.abc import Iterator, Mapping
from typing import Any

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi navigate state happy
  acromovi navigate state happy --json
      {"mission": NAME, "state": STATE, "why": TEXT, "since": S, "goal": {...}, "sub_target": [X, Y], "travelled": M,
       "pose": [X, Y, HEADING], "frame": "odom"|"map", "on_map": [X, Y, HEADING]}

STATE is idle, turning, going, passing a door, backing, waiting, re-planning, lost, done, failed or cancelled.
Places are in odom; frame is that of the planning, and on_map the goal of a mission on the map.

Exit codes: 0 done, in any state, 1 the navigation does not run (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Request the state once; return the exit code."""
    from acromovi.navigation.components import RunningNavigation
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        told = RunningNavigation(bus, arguments.robot).ask("state")
    print(json.dumps(told) if arguments.json else "\n".join(lines(told)))
    return 0


def lines(told: Mapping[str, Any]) -> Iterator[str]:
    """Yield the state as lines of text."""
    if not told.get("mission"):
        yield "no mission yet"
        return
    why = f": {told['why']}" if told.get("why") else ""
    yield f"{told['mission']}: {told['state']}{why}, for {told.get('since') or 0.0:.0f} s"
    goal = told.get("goal") or {}
    if goal.get("x") is not None:
        yield f"goal         {_place(goal['x'], goal['y'], goal.get('heading'))}"
    if told.get("sub_target"):
        yield f"sub-target   {_place(*told['sub_target'])}"
    if told.get("pose"):
        yield f"robot        {_place(*told['pose'])}"
    yield f"travelled    {told.get('travelled') or 0.0:.1f} m"


def _place(x: float, y: float, heading: float | None = None) -> str:
    """Return a place in odom as text."""
    looks = f", heading {heading:.2f} rad" if heading is not None else ""
    return f"x {x:.2f} m, y {y:.2f} m{looks}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

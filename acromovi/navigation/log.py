"""`acromovi navigate log`: print the messages about a robot's missions."""

import argparse
import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator, Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

MAX_KNOWN = 1000  # messages that are recognized when the user interface sends them again after a reconnection
RETRY_PERIOD = 1.0  # s between two subscriptions after the user interface has died
EPILOG = """\
examples:
  acromovi navigate log happy              the stored messages
  acromovi navigate log happy --follow     and new ones, until Ctrl-C
  acromovi navigate log happy --json       a JSON object on each line:
      {"stamp": S, "component": NAME, "mission": NAME, "level": "info"|"warning"|"error", "what": TEXT}

Exit codes: 0 done, 1 the navigation does not run, 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--follow", action="store_true", help="print new messages until Ctrl-C")
    parser.add_argument("--json", action="store_true", help="print one JSON object on each line")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Print the messages; return the exit code."""
    from acromovi.navigation.components import RunningNavigation
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        interface = RunningNavigation(bus, arguments.robot).expect()
        asyncio.run(_show(bus, interface, arguments.follow, arguments.json))
    return 0


async def _show(bus: "Bus", interface: "AgentName", follow: bool, as_json: bool) -> None:
    """Print the stored messages; with `follow` also new ones, without end."""
    from acromovi.ask import asker
    from acromovi.navigation.components import REPLY_TIMEOUT

    def show_one(message: Mapping[str, Any]) -> None:
        print(json.dumps(message, ensure_ascii=False) if as_json else line(message), flush=True)

    async with asker(bus, interface) as agent:
        if follow:
            async for message in messages(agent, interface):
                show_one(message)
        for message in (await agent.request(interface, "messages", reply_within=REPLY_TIMEOUT)).value():
            show_one(message)


async def messages(agent: "Agent", interface: "AgentName") -> AsyncIterator[Mapping[str, Any]]:
    """Yield the stored messages and then new ones, without end and without repetition after a reconnection."""
    from agents.platform import RequestNotDone

    known: deque[Mapping[str, Any]] = deque(maxlen=MAX_KNOWN)  # not by the latest stamp, because clocks differ
    while True:
        try:
            async with agent.subscribe(interface, "log") as told:
                async for message in told:
                    if message not in known:
                        known.append(message)
                        yield message
        except RequestNotDone:
            await asyncio.sleep(RETRY_PERIOD)


def line(message: Mapping[str, Any]) -> str:
    """Return a message as text."""
    at = f"{datetime.fromtimestamp(message['stamp']):%H:%M:%S.%f}"[:-5]
    loud = "" if message["level"] == "info" else f"{message['level'].upper()}: "
    mission = f"{message['mission']}  " if message["mission"] else ""
    return f"{at}  {mission}{loud}{message['what']}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

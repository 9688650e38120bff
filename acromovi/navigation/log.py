"""`acromovi navigate log`: what a robot tells of its missions."""

import argparse
import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator, Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

KEPT = 1000  # messages that are known again when the face, back after it was cut off, sends what it kept once more
BACK = 1.0  # s between two tries to hear a face again that has died
EPILOG = """\
examples:
  acromovi navigate log happy              what is kept of the last missions
  acromovi navigate log happy --follow     and what comes, until Ctrl-C
  acromovi navigate log happy --json       a JSON object on each line:
      {"stamp": S, "component": NAME, "mission": NAME, "level": "info"|"warning"|"error", "what": TEXT}

Exit codes: 0 done, 1 nobody navigates the robot, 2 wrong usage, 130 stopped by Ctrl-C.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--follow", action="store_true", help="go on until Ctrl-C")
    parser.add_argument("--json", action="store_true", help="one JSON object on each line")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print it."""
    from acromovi.navigation.components import expect
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        face = expect(bus, arguments.robot)
        asyncio.run(show(bus, face, arguments.follow, arguments.json))
    return 0


async def show(bus: "Bus", face: "AgentName", follow: bool, as_json: bool) -> None:
    """Print what is kept, or with `follow` that and what comes."""
    from acromovi.ask import asker
    from acromovi.navigation.components import PATIENCE

    def show_one(message: Mapping[str, Any]) -> None:
        print(json.dumps(message, ensure_ascii=False) if as_json else line(message), flush=True)

    async with asker(bus, face) as agent:
        if follow:
            async for message in messages(agent, face):
                show_one(message)
        for message in (await agent.request(face, "messages", reply_within=PATIENCE)).value():
            show_one(message)


async def messages(agent: "Agent", face: "AgentName") -> AsyncIterator[Mapping[str, Any]]:
    """What is told of missions: what is kept, then what comes, for ever; nothing twice when the face is back."""
    from agents.platform import RequestNotDone

    known: deque[Mapping[str, Any]] = deque(maxlen=KEPT)  # not by the latest stamp: components have clocks of their own
    while True:
        try:
            async with agent.subscribe(face, "log") as told:
                async for message in told:
                    if message not in known:
                        known.append(message)
                        yield message
        except RequestNotDone:
            await asyncio.sleep(BACK)


def line(message: Mapping[str, Any]) -> str:
    """A message for people."""
    at = f"{datetime.fromtimestamp(message['stamp']):%H:%M:%S.%f}"[:-5]
    loud = "" if message["level"] == "info" else f"{message['level'].upper()}: "
    mission = f"{message['mission']}  " if message["mission"] else ""
    return f"{at}  {mission}{loud}{message['what']}"

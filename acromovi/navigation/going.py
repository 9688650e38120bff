"""`acromovi navigate go`: send a robot to a place."""

import argparse
import asyncio
import json
import sys
from collections.abc import Mapping
from contextlib import suppress
from math import isfinite
from typing import TYPE_CHECKING, Any

from acromovi.navigation.picture import picture_file, take
from acromovi.options import add_bus, seconds

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

LONG = 3600.0  # s; a mission ends by itself long before
LAST_LINES = 5.0  # s in which the rest of the log comes after the end; only a face that has died since needs so long
AWAY = 20.0  # s in which the face of the navigation is back after it has died; the mission goes on meanwhile
EPILOG = """\
examples:
  acromovi navigate go happy 6 2.5
  acromovi navigate go happy 6 2.5 --heading 1.57 --wait
  acromovi navigate go happy 0 0 --wait --picture back.svg
  acromovi navigate go happy 0 0 --wait --json

Places are in m in the frame `odom`. A mission that is under way is replaced. With --wait it prints what the robot tells
until the mission has ended; Ctrl-C ends the waiting and not the mission, which `acromovi navigate cancel` does.

With --json it prints one object: {"mission": NAME}, and with --wait how it ended:
{"mission": NAME, "state": "done"|"failed"|"cancelled"|"replaced", "why": TEXT, ...}

Exit codes: 0 begun, or with --wait done; 1 refused, not reached, too late, or nobody navigates the robot (the reason is
on stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("x", metavar="X", type=finite, help="m")
    parser.add_argument("y", metavar="Y", type=finite, help="m")
    parser.add_argument(
        "--heading", type=finite, metavar="RAD", help="where it is to look at the end (default: anywhere)"
    )
    parser.add_argument(
        "--tolerance", type=finite, metavar="M", help="how near is there (default: the navigation's own)"
    )
    parser.add_argument("--wait", action="store_true", help="wait until the mission has ended")
    parser.add_argument("--timeout", type=seconds, default=LONG, metavar="S", help="wait no longer (%(default)g)")
    parser.add_argument("--picture", type=picture_file, metavar="FILE", help="with --wait: draw it at the end")
    parser.add_argument("--json", action="store_true", help="print one JSON object, and no log")
    add_bus(parser)


def finite(text: str) -> float:
    """A number, and no infinite one."""
    value = float(text)
    if not isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number")
    return value


def run(arguments: argparse.Namespace) -> int:
    """Send it, and wait if that is wanted."""
    from acromovi.navigation.components import expect
    from bus.session import ZenohBus

    if arguments.picture and not arguments.wait:
        print("acromovi navigate go: --picture is drawn at the end; give --wait too", file=sys.stderr)
        return 2
    with ZenohBus.open(arguments.bus) as bus:
        face = expect(bus, arguments.robot)
        code = asyncio.run(go(bus, face, arguments))
        if arguments.picture is not None:
            code = max(code, take(bus, arguments.robot, arguments.picture, "go"))
    return code


async def go(bus: "Bus", face: "AgentName", arguments: argparse.Namespace) -> int:
    """Send it; the exit code.

    Raises:
        RequestNotDone: It was refused; says why.
    """
    from acromovi.ask import asker
    from acromovi.navigation.components import PATIENCE

    wanted = {"x": arguments.x, "y": arguments.y, "heading": arguments.heading, "tolerance": arguments.tolerance}
    async with asker(bus, face) as agent:
        goal = {name: value for name, value in wanted.items() if value is not None}
        begun = (await agent.request(face, "go", reply_within=PATIENCE, **goal)).value()
        if not arguments.wait:
            print(json.dumps(begun) if arguments.json else f"{begun['mission']} has begun; {_advice(arguments.robot)}")
            return 0
        told = _MissionLog(agent, face, begun["mission"])
        telling = None if arguments.json else asyncio.ensure_future(told.show())
        try:
            async with asyncio.timeout(arguments.timeout):
                ended = await end_of(agent, face, begun["mission"])
            if telling is not None:
                await told.until(ended.get("logged"))
        except TimeoutError:
            why = f"{begun['mission']} has not ended within {arguments.timeout:g} s; {_advice(arguments.robot)}"
            print(f"acromovi navigate go: {why}", file=sys.stderr)
            return 1
        finally:
            if telling is not None:
                telling.cancel()
                await asyncio.gather(telling, return_exceptions=True)
    return report(ended, arguments.json)


async def end_of(agent: "Agent", face: "AgentName", mission: str) -> Mapping[str, Any]:
    """How a mission ends. A face that has died meanwhile is waited for, since the mission goes on without it.

    Raises:
        RequestNotDone: There is nobody any more who would know.
    """
    from agents.platform import Ending

    now = asyncio.get_running_loop().time
    given_up_at = now() + AWAY
    while True:
        outcome = await agent.request(face, "wait", reply_within=LONG, mission=mission)
        if outcome.ending is not Ending.DIED or now() > given_up_at:
            ended: Mapping[str, Any] = outcome.value()
            return ended
        if outcome.agreed:  # it was there until now
            given_up_at = now() + AWAY
        await asyncio.sleep(1.0)


class _MissionLog:
    """Prints the messages about one mission."""

    def __init__(self, agent: "Agent", face: "AgentName", mission: str) -> None:
        self._agent = agent
        self._face = face
        self._mission = mission
        self._shown: set[float] = set()  # stamps
        self._more = asyncio.Event()

    async def show(self) -> None:
        """Print each message as it comes, until this is cancelled."""
        from acromovi.navigation.log import line, messages

        async for message in messages(self._agent, self._face):
            if message.get("mission") == self._mission:
                print(line(message), flush=True)
                self._shown.add(message["stamp"])
                self._more.set()

    async def until(self, stamp: float | None) -> None:
        """Wait until the message with this stamp is printed; None is that of no message."""
        with suppress(TimeoutError):  # the face has died since; the end of the mission is known all the same
            async with asyncio.timeout(LAST_LINES):
                while stamp is not None and stamp not in self._shown:
                    self._more.clear()
                    await self._more.wait()


def report(ended: Mapping[str, Any], as_json: bool) -> int:
    """Say how a mission ended; the exit code."""
    is_done = ended.get("state") == "done"
    if as_json:
        print(json.dumps(ended))
    elif is_done:
        print(f"done: {ended.get('why')}")
    if not is_done:
        print(f"acromovi navigate go: {ended.get('state')}: {ended.get('why')}", file=sys.stderr)
    return 0 if is_done else 1


def _advice(robot: str) -> str:
    return f"follow it with acromovi navigate watch {robot}, end it with acromovi navigate cancel {robot}"

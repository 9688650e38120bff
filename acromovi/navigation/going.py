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
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

MAX_MISSION_TIME = 3600.0  # s; a mission ends by itself long before
LOG_TIMEOUT = 5.0  # s for the rest of the log after the end; only a restarted user interface needs as long
RESTART_TIMEOUT = 20.0  # s for the user interface to restart after it has died; the mission continues meanwhile
EPILOG = """\
examples:
  acromovi navigate go happy 6 2.5
  acromovi navigate go happy "Lab 2" --wait
  acromovi navigate go happy 6 2.5 --map
  acromovi navigate go happy 6 2.5 --heading 1.57 --wait
  acromovi navigate go happy 0 0 --wait --picture back.svg
  acromovi navigate go happy 0 0 --wait --json

X and Y are m in the frame `odom`; with --map, m in the frame `map`. A name is that of a goal of the map. Both need a
robot that is localized: acromovi localize. An active mission is replaced. With --wait the messages about the mission
are printed until it has ended. Ctrl-C ends the waiting, not the mission; to end that, use `acromovi navigate cancel`.

With --json the output is one object, {"mission": NAME}, and with --wait the result:
{"mission": NAME, "state": "done"|"failed"|"cancelled"|"replaced", "why": TEXT, ...}

Exit codes: 0 begun, or with --wait done; 1 refused, not reached, timeout, or the navigation does not run (the reason is
on stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument(
        "place", metavar="PLACE", nargs="+", action=_Place, help="X and Y in m, or the name of a goal of the map"
    )
    parser.add_argument("--map", action="store_true", help="X, Y and the heading are in the frame map [odom]")
    parser.add_argument("--heading", type=finite, metavar="RAD", help="heading at the goal [any]")
    parser.add_argument(
        "--tolerance", type=finite, metavar="M", help="distance that counts as reached, at least 0.1 m [0.25 m]"
    )
    parser.add_argument("--wait", action="store_true", help="wait until the mission has ended")
    parser.add_argument(
        "--timeout", type=seconds, default=MAX_MISSION_TIME, metavar="S", help="maximum s to wait [%(default)g]"
    )
    parser.add_argument("--picture", type=picture_file, metavar="FILE", help="with --wait, draw the mission at the end")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of the messages")
    add_bus(parser)


def finite(text: str) -> float:
    """Return a finite number."""
    value = float(text)
    if not isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number")
    return value


def _run(arguments: argparse.Namespace) -> int:
    """Send the robot, and wait for the end if wanted; return the exit code."""
    from acromovi.navigation.components import RunningNavigation
    from bus.session import ZenohBus

    if arguments.picture and not arguments.wait:
        print("acromovi navigate go: --picture draws the end of the mission; add --wait", file=sys.stderr)
        return 2
    with ZenohBus.open(arguments.bus) as bus:
        interface = RunningNavigation(bus, arguments.robot).expect()
        code = asyncio.run(_go(bus, interface, arguments))
        if arguments.picture is not None:
            code = max(code, take(bus, arguments.robot, arguments.picture, "go"))
    return code


class _Place(argparse.Action):
    """Makes x and y, or the name of a goal, of the words of a place."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Store them as arguments of a request."""
        if len(values) == 1:
            setattr(namespace, self.dest, {"place": values[0]})
            return
        try:
            x, y = map(finite, values)
        except argparse.ArgumentTypeError as err:
            raise argparse.ArgumentError(self, str(err)) from err
        except ValueError as err:
            words = " ".join(f'"{word}"' for word in values)
            raise argparse.ArgumentError(self, f"give X and Y in m, or one name in quotes, not {words}") from err
        setattr(namespace, self.dest, {"x": x, "y": y})


async def _go(bus: "Bus", interface: "AgentName", arguments: argparse.Namespace) -> int:
    """Send the robot; return the exit code.

    Raises:
        RequestNotDone: The goal was refused.
    """
    from acromovi.ask import asker
    from acromovi.navigation.components import REPLY_TIMEOUT

    async with asker(bus, interface) as agent:
        frame = "map" if arguments.map and "place" not in arguments.place else None
        about = {"heading": arguments.heading, "tolerance": arguments.tolerance, "frame": frame}
        wanted = {**arguments.place, **about}
        goal = {name: value for name, value in wanted.items() if value is not None}
        begun = (await agent.request(interface, "go", reply_within=REPLY_TIMEOUT, **goal)).value()
        if not arguments.wait:
            print(json.dumps(begun) if arguments.json else f"{begun['mission']} has begun; {_advice(arguments.robot)}")
            return 0
        told = _MissionLog(agent, interface, begun["mission"])
        telling = None if arguments.json else asyncio.ensure_future(told.show())
        try:
            async with asyncio.timeout(arguments.timeout):
                ended = await _end_of(agent, interface, begun["mission"])
            if telling is not None:
                await told.until(ended.get("logged"))
        except TimeoutError:
            why = f"{begun['mission']} has not ended within {arguments.timeout:g} s; {_advice(arguments.robot)}"
            print(f"acromovi navigate go: {why}", file=sys.stderr)
            return 1
        finally:
            if telling is not None:
                telling.cancel()
                await asyncio.gather(telling, return_exceptions=True)  # it was cancelled, and only prints
    return _report(ended, arguments.json)


async def _end_of(agent: "Agent", interface: "AgentName", mission: str) -> Mapping[str, Any]:
    """Wait for the end of a mission, also while the user interface restarts, and return its state.

    Raises:
        RequestNotDone: The user interface has not restarted in time, or does not know the mission.
    """
    from agents.platform import Ending

    now = asyncio.get_running_loop().time
    given_up_at = now() + RESTART_TIMEOUT
    while True:
        outcome = await agent.request(interface, "wait", reply_within=MAX_MISSION_TIME, mission=mission)
        if outcome.ending is not Ending.DIED or now() > given_up_at:
            ended: Mapping[str, Any] = outcome.value()
            return ended
        if outcome.agreed:  # it ran until now
            given_up_at = now() + RESTART_TIMEOUT
        await asyncio.sleep(1.0)


class _MissionLog:
    """Prints the messages about one mission."""

    def __init__(self, agent: "Agent", interface: "AgentName", mission: str) -> None:
        self._agent = agent
        self._face = interface
        self._mission = mission
        self._shown: set[float] = set()  # stamps
        self._more = asyncio.Event()

    async def show(self) -> None:
        """Print each message, until this is cancelled."""
        from acromovi.navigation.log import line, messages

        async for message in messages(self._agent, self._face):
            if message.get("mission") == self._mission:
                print(line(message), flush=True)
                self._shown.add(message["stamp"])
                self._more.set()

    async def until(self, stamp: float | None) -> None:
        """Wait until the message with this stamp is printed; return at once for None."""
        with suppress(TimeoutError):  # the user interface has died; the end of the mission is known anyway
            async with asyncio.timeout(LOG_TIMEOUT):
                while stamp is not None and stamp not in self._shown:
                    self._more.clear()
                    await self._more.wait()


def _report(ended: Mapping[str, Any], as_json: bool) -> int:
    """Print how a mission ended; return the exit code."""
    is_done = ended.get("state") == "done"
    if as_json:
        print(json.dumps(ended))
    elif is_done:
        print(f"done: {ended.get('why')}")
    if not is_done:
        print(f"acromovi navigate go: {ended.get('state')}: {ended.get('why')}", file=sys.stderr)
    return 0 if is_done else 1


def _advice(robot: str) -> str:
    return f"to follow it: acromovi navigate watch {robot}; to end it: acromovi navigate cancel {robot}"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

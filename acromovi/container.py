"""`acromovi container`: a process in which agents live: a robot's, a team's, or whoever is started there."""

import argparse
import asyncio
import gc
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING, Any

from acromovi.command import argument
from acromovi.options import add_apps, add_bus
from configs.loader import ConfigError

if TYPE_CHECKING:
    from agents.platform import Container, Report

PROGRAM = "acromovi container"
GRACE = 1.8  # s for all agents to end; what has not ended then is cut off
MEETING_TIME = 1.0  # s in which sessions on one machine have met
LOOK_FOR_OTHERS = 2.0  # s to wait for a container of the same name that is slow to answer
SERVICES = "services"  # the name of the container with a team's services
EPILOG = """\
examples:
  acromovi container --robot happy
      the agents of the robot happy, one for each element that it has; it may come and go
  acromovi container --services acromovi
      the services of the team acromovi: monitor, subscription, arbiter, loader
  acromovi container --services acromovi --property arbiter.audit_file=leases.jsonl
      the same, and the arbiter appends its record to a file
  acromovi container workshop --apps examples
      an empty one; acromovi agent start NAME KIND --in workshop starts agents there, of kinds that Acromovi brings or
      that the folder has

With --json it prints one line once it serves: {"container": NAME}

It runs until stopped, and its agents end with it, within 2 s. Exit codes: 1 not possible (the reason is on stderr),
2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("name", metavar="NAME", nargs="?", help="an empty container of this name")
    which.add_argument("--robot", metavar="ROBOT", help="the container of a robot's agents")
    which.add_argument("--services", metavar="TEAM", help="the container of a team's services")
    parser.add_argument(
        "--property",
        metavar="SERVICE.KEY=VALUE",
        type=argument,
        action="append",
        default=[],
        help="what one of the services is given; a value is JSON, or text where it is no JSON; repeat for more",
    )
    add_apps(parser)
    parser.add_argument("--json", action="store_true", help="print one line of JSON once it serves")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Let agents live until a signal comes."""
    from agents.platform import Container, Kinds
    from bus.session import ZenohBus

    for module in _modules(arguments):
        import_module(module)  # now: once agents live here, it would hold them up
    gc.freeze()  # what was loaded stays to the end: no need to look through it, then least of all
    name = arguments.name or arguments.robot or SERVICES
    platform = arguments.robot or arguments.services
    with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
        container = Container(bus, name, reporter(PROGRAM), platform=platform, kinds=Kinds(arguments.apps))
        asyncio.run(live(container, arguments, end))
    return end.code


def reporter(program: str) -> "Callable[[Report], None]":
    """Says in a program's name what goes wrong with an agent: in one sentence where that is all there is to know."""
    from agents.face.errors import RobotError
    from agents.platform import AgentError
    from agents.platform.container import log_report
    from bus import BusError
    from configs import ConfigError

    def report(report: "Report") -> None:
        if report.error is None:
            print(f"{program}: {report.agent}: {report.what}", file=sys.stderr, flush=True)
        elif isinstance(report.error, RobotError | AgentError | BusError | ConfigError):
            print(f"{program}: {report.agent}: {report.what}: {report.error}", file=sys.stderr, flush=True)
        else:
            log_report(report)

    return report


def _modules(arguments: argparse.Namespace) -> Iterator[str]:
    """What its agents are made of."""
    if arguments.robot:
        yield "agents.components.robot_agents"
    if arguments.services:
        yield "agents.services.all_services"
    if arguments.apps:
        yield "agents.services.loaded"


class End:
    """Whether this program has been told to end, and how.

    code: the exit code.
    """

    def __init__(self) -> None:
        self.code = 0
        self._called = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None

    def tell(self, code: int) -> None:
        """End; from a signal handler or from the loop."""
        self.code = self.code or code
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._called.set)

    async def wait(self) -> None:
        """Wait until it has been told."""
        self._loop = asyncio.get_running_loop()
        if not self.code:
            await self._called.wait()


@contextmanager
def ending_in_time() -> Iterator[End]:
    """Let SIGINT and SIGTERM end this program in order, and by force when that takes too long.

    The handlers run even while an agent blocks the event loop.
    """
    end = End()

    def told(number: int, frame: FrameType | None) -> None:
        if not end.code:
            force = threading.Timer(GRACE, os._exit, (128 + number,))
            force.daemon = True
            force.start()
        end.tell(128 + number)

    before = {number: signal.signal(number, told) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield end
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


async def live(container: "Container", arguments: argparse.Namespace, end: End) -> None:
    """Have the agents live that are asked for, until the end."""
    async with container:
        tasks = [asyncio.ensure_future(leave_if_second(container, end))]
        if arguments.robot:
            tasks.append(asyncio.ensure_future(follow_robot(container, arguments.robot, end)))
        if arguments.services:
            await start_services(container, arguments.services, dict(arguments.property))
        if arguments.json:
            print(json.dumps({"container": container.name}), flush=True)
        else:
            print(f"the container {container.name} serves; stop with Ctrl-C", flush=True)
        await end.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def follow_robot(container: "Container", robot: str, end: End) -> None:
    """Keep the container's agents the same as the robot's elements."""
    from agents.components.robot_agents import RobotAgents
    from agents.platform.errors import in_words

    try:
        await RobotAgents(container, robot).run()
    except Exception as err:  # without it the container is of no use; whoever watches over it starts another
        print(f"acromovi container: {robot} cannot be followed: {in_words(err)}", file=sys.stderr)
        end.tell(1)


async def start_services(container: "Container", team: str, properties: Mapping[str, Any]) -> None:
    """Start the agents of a team's upper layer; one that fails is reported and holds up no other.

    Args:
        container: Where.
        team: Whose they are.
        properties: By `SERVICE.KEY`.
    Raises:
        ConfigError: There is no such service.
    """
    from agents.platform import AgentName

    kinds = import_module("agents.services.all_services").SERVICES
    given: dict[str, dict[str, Any]] = {local: {} for local in kinds}
    for name, value in properties.items():
        service, _, key = name.partition(".")
        if service not in kinds or not key:
            raise ConfigError(f"{name!r} is no property of a service; write SERVICE.KEY=VALUE, of {', '.join(kinds)}")
        given[service][key] = value
    services = [kind(AgentName(local, team), given[local]) for local, kind in kinds.items()]
    await asyncio.gather(*map(container.start, services))


async def leave_if_second(container: "Container", end: End) -> None:
    """End if there is a container of this name already: two would double every agent."""
    from agents.platform.talk import query
    from bus import BusError

    await asyncio.sleep(MEETING_TIME)  # else only this one answers
    try:
        found = await query(container.bus, f"*/containers/{container.name}/description", None, LOOK_FOR_OTHERS)
    except (BusError, TimeoutError):
        return  # someone who does not answer is frozen, and cannot be judged
    elder = min(found, key=lambda answer: (answer.value["since"], answer.value["identity"])).value
    if elder["identity"] != container.identity:
        why = f"there is a container {container.name} already, process {elder['process']}; give this one another name"
        print(f"acromovi container: {why}", file=sys.stderr)
        end.tell(1)

"""`acromovi container`: a process for agents: those of a robot, of a team, or any that are started there."""

import argparse
import asyncio
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING, Any

from acromovi.options import add_apps, add_bus, add_pairs
from acromovi.subcommand import Subcommand
from configs.loader import ConfigError
from configs.startup import uncollected

if TYPE_CHECKING:
    from agents.platform import Container, Report
    from agents.platform.names import ContainerName
    from bus import Bus

PROGRAM = "acromovi container"
ENDING = (signal.SIGINT, signal.SIGTERM)
GRACE = 1.8  # s for all agents to end; what has not ended then is cut off
MEETING_TIME = 1.0  # s in which sessions on one machine have met
LOOK_AGAIN = 0.5  # s, for the end of another container of the same name
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


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("name", metavar="NAME", nargs="?", help="start an empty container of this name")
    which.add_argument("--robot", metavar="ROBOT", help="start the container of a robot's agents")
    which.add_argument("--services", metavar="TEAM", help="start the container of a team's services")
    add_pairs(parser, "--property", "SERVICE.KEY=VALUE", "set a property of a service")
    add_apps(parser)
    parser.add_argument("--json", action="store_true", help="print one line of JSON once it serves")
    parser.add_argument(
        "--force", action="store_true", help="wait until another container of this name has ended, and take its place"
    )
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Host agents until a signal is received."""
    with uncollected():
        from agents.platform import Container, Kinds
        from agents.platform.names import ContainerName
        from bus.session import ZenohBus

        for module in _modules(arguments):
            import_module(module)  # now: once agents live here, it would hold them up
    name = arguments.name or arguments.robot or SERVICES
    platform = arguments.robot or arguments.services
    with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
        _check_may_serve(bus, ContainerName(name, platform or bus.own_name or name))
        await_name(bus, name, end, forces=arguments.force)
        if end.code:
            return end.code
        container = Container(bus, name, reporter(PROGRAM), platform=platform, kinds=Kinds(arguments.apps))
        asyncio.run(_live(container, arguments, end))
    return end.code


def _check_may_serve(bus: "Bus", called: "ContainerName") -> None:
    """Check that the key of a secure bus allows this container; done before its name is checked.

    Raises:
        NotAllowed: It does not.
    """
    from bus import JSON

    bus.publisher(called.reports_key, JSON).close()


def await_name(bus: "Bus", name: str, end: "EndRequest", *, forces: bool = False) -> None:
    """Check that no other container on the bus has this name, or wait until the name is free.

    Raises:
        NameTaken: There is one; the message says what to do.
    """
    from bus import NameTaken
    from bus.name_holder import check_name_free

    is_told = False
    while not end.code:
        try:
            check_name_free(bus, f"the container {name}", f"*/containers/{name}/description")
            return
        except NameTaken as err:
            if not forces:
                advice = "end that one, or give this one another name or another bus (--bus local:NAME)"
                raise NameTaken(f"{err}; {advice}. With --force it waits until the other has ended") from err
            if not is_told:
                print(f"{PROGRAM}: {err}; waiting until it has ended", file=sys.stderr, flush=True)
                is_told = True
            time.sleep(LOOK_AGAIN)


def reporter(program: str) -> "Callable[[Report], None]":
    """Return a function that reports an agent's errors under a program's name, in one sentence where possible."""
    from agents.client.errors import RobotError
    from agents.platform import AgentError
    from bus import BusError
    from configs import ConfigError

    def report(report: "Report") -> None:
        if report.error is None:
            print(f"{program}: {report.agent}: {report.what}", file=sys.stderr, flush=True)
        elif isinstance(report.error, RobotError | AgentError | BusError | ConfigError):
            print(f"{program}: {report.agent}: {report.what}: {report.error}", file=sys.stderr, flush=True)
        else:
            report.log()

    return report


def _modules(arguments: argparse.Namespace) -> Iterator[str]:
    """What its agents are made of."""
    if arguments.robot:
        yield "agents.components.robot_agents"
    if arguments.services:
        yield "agents.services.all_services"
    if arguments.apps:
        yield "agents.services.loaded"


class EndRequest:
    """Whether this program was asked to end, and how.

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
def ending_in_time() -> Iterator[EndRequest]:
    """Let SIGINT and SIGTERM end this program in order, or by force after a time.

    The handlers run even while an agent blocks the event loop.
    """
    end = EndRequest()

    def told(number: int, frame: FrameType | None) -> None:
        end.tell(128 + number)

    before = {number: signal.signal(number, told) for number in ENDING}
    try:
        with _cut_off_late():
            yield end
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _cut_off_late() -> Iterator[None]:
    """End this process `GRACE` seconds after SIGINT or SIGTERM, whatever it does then.

    Python runs a signal's handler between two steps of the main thread, which may have begun to sleep by then. So a
    thread waits for the byte that Python writes at once for every signal.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)

    def wait() -> None:
        for number in iter(lambda: os.read(reader, 1), b""):
            if number[0] in ENDING:
                time.sleep(GRACE)
                os._exit(128 + number[0])
        os.close(reader)

    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=wait, name="ending", daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writer)  # which ends the thread


async def _live(container: "Container", arguments: argparse.Namespace, end: EndRequest) -> None:
    """Host the requested agents until the end."""
    async with container:
        tasks = [asyncio.ensure_future(leave_if_second(container, end))]
        if arguments.robot:
            tasks.append(asyncio.ensure_future(_follow_robot(container, arguments.robot, end)))
        if arguments.services:
            await start_services(container, arguments.services, dict(arguments.property))
        for_people = f"the container {container.name} serves; stop with Ctrl-C"
        print(json.dumps({"container": container.name}) if arguments.json else for_people, flush=True)
        await end.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)  # each ends as cancelled


async def _follow_robot(container: "Container", robot: str, end: EndRequest) -> None:
    """Keep the container's agents the same as the robot's elements."""
    from agents.components.robot_agents import RobotAgents
    from agents.platform.errors import in_words

    try:
        await RobotAgents(container, robot).run()
    except Exception as err:  # without it the container is of no use; whoever watches over it starts another
        print(f"acromovi container: {robot} cannot be followed: {in_words(err)}", file=sys.stderr)
        end.tell(1)


async def start_services(container: "Container", team: str, properties: Mapping[str, Any]) -> None:
    """Start the agents of a team's upper layer; one that fails is reported and does not delay the others.

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


async def leave_if_second(container: "Container", end: EndRequest) -> None:
    """End if another container of this name started slightly earlier; two would duplicate every agent."""
    from bus import BusError, NameTaken
    from bus.name_holder import check_name_free

    await asyncio.sleep(MEETING_TIME)  # both have been seen by then
    where = f"*/containers/{container.name}/description"
    try:
        await asyncio.to_thread(
            check_name_free, container.bus, f"the container {container.name}", where, container.process
        )
    except NameTaken as err:
        print(f"{PROGRAM}: {err}", file=sys.stderr)
        end.tell(1)
    except BusError:
        return  # the bus is being closed


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

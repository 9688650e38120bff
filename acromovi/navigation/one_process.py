"""`acromovi navigate process`: run the components of one process."""

import argparse
import asyncio
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

from acromovi.navigation.wired import add_wiring, container_name, processes
from acromovi.options import add_bus
from acromovi.subcommand import Subcommand
from configs.loader import ConfigError
from configs.startup import uncollected

if TYPE_CHECKING:
    from acromovi.container import EndRequest
    from agents.platform import Container
    from apps.indoor_navigation.wiring import ComponentSpec

PROGRAM = "acromovi navigate process"
EPILOG = """\
example:
  acromovi navigate process happy reactive

The process runs until it is stopped. It is not restarted when it dies; `acromovi navigate up happy --process reactive`
does that. With --json the output is one line once the components run: {"container": NAME}

Exit codes: 1 it cannot run (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("process", metavar="PROCESS", help="a process of the wiring")
    add_wiring(parser)
    parser.add_argument("--json", action="store_true", help="print one line of JSON once the components run")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Run the components until a signal; return the exit code."""
    with uncollected():
        from acromovi.container import await_name, ending_in_time, reporter
        from agents.platform import Container
        from bus.session import ZenohBus

        here = processes(arguments)  # imports the components before data arrive from the bus
    if arguments.process not in here:
        raise ConfigError(f"the wiring has no process {arguments.process!r}; choose one of {', '.join(here)}")
    name = container_name(arguments.robot, arguments.process)
    with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
        await_name(bus, name, end)
        container = Container(bus, name, reporter(PROGRAM), platform=arguments.robot)
        asyncio.run(_live(container, arguments.robot, here[arguments.process], arguments.json, end))
    return end.code


async def _live(
    container: "Container", robot: str, parts: "Sequence[ComponentSpec]", as_json: bool, end: "EndRequest"
) -> None:
    """Run components until the end, or until one of them cannot start."""
    from acromovi.container import leave_if_second

    async with container:
        second = asyncio.ensure_future(leave_if_second(container, end))
        agents = [container.kinds.make(part.kind, part.agent(robot), part.properties) for part in parts]
        if not all(await asyncio.gather(*map(container.start, agents))):
            end.tell(1)  # the component and the reason were reported
        elif as_json:
            print(json.dumps({"container": container.name}), flush=True)
        else:
            print(f"{', '.join(part.local for part in parts)} of {robot} at work; stop with Ctrl-C", flush=True)
        await end.wait()
        second.cancel()
        await asyncio.gather(second, return_exceptions=True)  # it was cancelled


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

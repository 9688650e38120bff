"""`acromovi navigate process`: the components of one process, in this one."""

import argparse
import asyncio
import gc
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

from acromovi.navigation.wired import add_wiring, container_name, processes
from acromovi.options import add_bus
from configs.loader import ConfigError

if TYPE_CHECKING:
    from acromovi.container import EndRequest
    from agents.platform import Container
    from apps.indoor_navigation.wiring import ComponentSpec

PROGRAM = "acromovi navigate process"
EPILOG = """\
example:
  acromovi navigate process happy reactive

It runs until stopped and is not started again when it dies; `acromovi navigate up happy --process reactive` sees to
that. With --json it prints one line once its components are at work: {"container": NAME}

Exit codes: 1 not possible (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("process", metavar="PROCESS", help="one of those that the wiring names")
    add_wiring(parser)
    parser.add_argument("--json", action="store_true", help="print one line of JSON once it serves")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Let the components live until a signal comes."""
    from acromovi.container import await_name, ending_in_time, reporter
    from agents.platform import Container
    from bus.session import ZenohBus

    here = processes(arguments)  # loads what the components are made of, before the bus brings anything to do
    if arguments.process not in here:
        raise ConfigError(f"the wiring has no process {arguments.process!r}; choose one of {', '.join(here)}")
    gc.freeze()
    name = container_name(arguments.robot, arguments.process)
    with ending_in_time() as end, ZenohBus.open(arguments.bus) as bus:
        await_name(bus, name, end)
        container = Container(bus, name, reporter(PROGRAM), platform=arguments.robot)
        asyncio.run(live(container, arguments.robot, here[arguments.process], arguments.json, end))
    return end.code


async def live(
    container: "Container", robot: str, parts: "Sequence[ComponentSpec]", as_json: bool, end: "EndRequest"
) -> None:
    """Let components live until the end; if one of them cannot, that is now."""
    from acromovi.container import leave_if_second

    async with container:
        second = asyncio.ensure_future(leave_if_second(container, end))
        agents = [container.kinds.make(part.kind, part.agent(robot), part.properties) for part in parts]
        if not all(await asyncio.gather(*map(container.start, agents))):
            end.tell(1)  # which of them and why has been reported
        elif as_json:
            print(json.dumps({"container": container.name}), flush=True)
        else:
            print(f"{', '.join(part.local for part in parts)} of {robot} at work; stop with Ctrl-C", flush=True)
        await end.wait()
        second.cancel()
        await asyncio.gather(second, return_exceptions=True)

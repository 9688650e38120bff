"""`acromovi ask`: ask an agent to do something, as any other agent can."""

import argparse
import asyncio
import json
import sys
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus, argument, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName, Outcome
    from bus.bus import Bus

PATIENCE = 10.0  # s
READ = "read"  # the request that those may make who may only look: the answer is what the results' key gives
EPILOG = """\
examples:
  acromovi ask sonar@happy read
  acromovi ask base@happy move distance=0.5
  acromovi ask base@happy go_to x=1 y=0.5 --timeout 60
  acromovi ask arm@max move 'joints={"1": 0.5}' --json
  acromovi ask subscription@acromovi data agent=sonar@happy rate=2 --follow
      subscribe: one line for each value, until Ctrl-C

A value is JSON, or text where it is no JSON. The result is printed as JSON; with --json on one line. acromovi directory
says what an agent can be asked for, and what can be subscribed to.

Exit codes: 0 done, 1 refused, failed, not understood, too late, or no such agent (the reason is on stderr), 2 wrong
usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("agent", metavar="AGENT", help="name of the agent, such as base@happy")
    parser.add_argument("request", metavar="REQUEST", help="name of the request")
    parser.add_argument("arguments", metavar="KEY=VALUE", nargs="*", default=(), type=argument, help="arguments")
    parser.add_argument(
        "--timeout", type=seconds, default=PATIENCE, metavar="S", help="wait for the end [%(default)g s]"
    )
    parser.add_argument("--json", action="store_true", help="print the result as one line of JSON")
    parser.add_argument("--follow", action="store_true", help="subscribe: print each value when it arrives")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Ask once, and print the result."""
    from acromovi.known_agents import KnownAgents
    from agents.platform.conversations.outcome import Ending, Outcome
    from agents.platform.names import AgentName
    from bus.errors import NotAllowed
    from bus.session import ZenohBus

    if "reply_within" in dict(arguments.arguments):
        print("acromovi ask: how long to wait is said with --timeout", file=sys.stderr)
        return 2
    peer = AgentName.parse(arguments.agent)
    with ZenohBus.open(arguments.bus) as bus:
        with KnownAgents(bus) as known:
            known.expect(peer)
        if arguments.follow:
            asyncio.run(_follow(bus, peer, arguments.request, dict(arguments.arguments)))
            return 0
        try:
            outcome = asyncio.run(ask(bus, peer, arguments.request, dict(arguments.arguments), arguments.timeout))
        except NotAllowed:
            if arguments.request != READ:
                raise
            outcome = Outcome(Ending.DONE, bus.query(peer.results_key, timeout=arguments.timeout)[0].value)
    if not outcome.is_done:
        print(f"acromovi ask: {outcome.ending}: {outcome.why}", file=sys.stderr)
        return 1
    print(json.dumps(outcome.result, ensure_ascii=False, indent=None if arguments.json else 2))
    return 0


async def ask(bus: "Bus", peer: "AgentName", request: str, given: dict[str, Any], within: float) -> "Outcome":
    """Ask as an agent that lives for this one request.

    Raises:
        NotAllowed: A secure bus does not let this program ask agents.
    """
    async with asker(bus, peer) as agent:
        return await agent.request(peer, request, reply_within=within, **given)


async def _follow(bus: "Bus", peer: "AgentName", name: str, given: dict[str, Any]) -> None:
    """Subscribe as an agent that lives for this one subscription, and print each value on a line until it ends.

    Raises:
        NotAllowed: A secure bus does not let this program ask agents.
        RequestNotDone: It was refused, or has failed.
    """
    async with asker(bus, peer) as agent, agent.subscribe(peer, name, **given) as values:
        async for value in values:
            print(json.dumps(value, ensure_ascii=False), flush=True)


@asynccontextmanager
async def asker(bus: "Bus", peer: "AgentName") -> "AsyncIterator[Agent]":
    """An agent that exists while the block runs.

    Raises:
        NotAllowed: A secure bus does not let this program ask agents.
    """
    from agents.platform.agent import Agent
    from agents.platform.container.container import Container
    from agents.platform.names import PASSER_BY, AgentName

    bus.check_may_query(peer.acl_key)
    name = f"{PASSER_BY}{uuid.uuid4().hex[:6]}"
    async with Container(bus, name) as container:
        agent = Agent(AgentName(name, bus.own_name or "terminal"))
        await container.start(agent)
        yield agent


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

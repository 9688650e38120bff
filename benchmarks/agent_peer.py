"""The other side of the agents' benchmarks, in a process of its own: `python -m benchmarks.agent_peer KIND ...`.

Each kind says `ready` once it serves, and ends with its standard input.
"""

import asyncio
import json
import sys
from collections.abc import Callable, Coroutine
from typing import Any

from agents.platform import Agent, AgentName, Container, Kinds, Performative, Template, request
from agents.services.lease_client import find_arbiter, leased
from bus import ZenohBus, keys
from bus.messages import twist

VELOCITY_PERIOD_S = 0.1
INFORMS = Template.of(Performative.INFORM)


def command_of(kind: str, *arguments: str) -> list[str]:
    """The command line of one."""
    return [sys.executable, "-m", "benchmarks.agent_peer", kind, *arguments]


class Echo(Agent):
    """Answers at once."""

    @request("echo")
    async def echo(self, number: int) -> int:
        """The same number."""
        return number


class Counter(Agent):
    """Counts the informs of each sender, and whether each is one more than the last."""

    def __init__(self, name: AgentName) -> None:
        super().__init__(name)
        self.last: dict[str, int] = {}
        self.out_of_order = 0

    async def setup(self) -> None:
        """Count for ever."""
        self.add(self.count)

    async def count(self) -> None:
        """Take one inform after the other."""
        while True:
            message = await self.receive(INFORMS)
            sender, number = str(message.sender), int(message.content)
            self.out_of_order += number != self.last.get(sender, -1) + 1
            self.last[sender] = number

    @request("counted")
    async def counted(self) -> dict[str, Any]:
        """What has come so far."""
        return {"last": self.last, "out_of_order": self.out_of_order, "dropped": self.mailbox.state.dropped}


async def echo(platform: str) -> None:
    """One agent that answers."""
    with ZenohBus.open() as bus:
        async with Container(bus, f"echo-{platform}", platform=platform) as container:
            await container.start(Echo(AgentName("echo", platform)))
            await _serve()


async def counters(platform: str, number: str) -> None:
    """Some agents that count."""
    with ZenohBus.open() as bus:
        async with Container(bus, f"counters-{platform}", platform=platform) as container:
            for index in range(int(number)):
                await container.start(Counter(AgentName(f"counter{index}", platform)))
            await _serve()


async def crowd(platform: str, number: str) -> None:
    """Many agents in one container, with nothing to do."""
    with ZenohBus.open() as bus:
        async with Container(bus, f"crowd-{platform}", platform=platform) as container:
            for index in range(int(number)):
                await container.start(Agent(AgentName(f"idler{index}", platform)))
            await _serve()


async def sessions(profile: str, platform: str, number: str, agents: str) -> None:
    """Many participants on the bus, each with a container and a few agents."""
    opened = [ZenohBus.open(profile) for _ in range(int(number))]
    containers = [Container(bus, f"{platform}-{index}", platform=platform) for index, bus in enumerate(opened)]
    for index, container in enumerate(containers):
        for each in range(int(agents)):
            await container.start(Agent(AgentName(f"idler{index}-{each}", platform)))
    await _serve()
    for container in containers:
        await container.close()
    for bus in opened:
        bus.close()


async def holder(profile: str, name: str, element: str, speed: str) -> None:
    """One agent that leases a base and drives it, for ever."""
    base = AgentName.parse(element)
    with ZenohBus.open(profile) as bus:
        async with Container(bus, name) as container:
            agent = Agent(AgentName("driver", name))
            await container.start(agent)
            velocity = twist(float(speed), 0.0)
            async with leased(agent, element, arbiter=await _arbiter(agent)) as lease:
                with bus.publisher(keys.CMD_VEL.key(base.platform), keys.CMD_VEL.type_name) as wheels:
                    print(json.dumps({"ready": True}), flush=True)
                    while True:
                        wheels.put(velocity, lease.token.encode())
                        await asyncio.sleep(VELOCITY_PERIOD_S)


async def _arbiter(agent: Agent) -> AgentName:
    """An arbiter, and not the gateway in its place."""
    while (found := await find_arbiter(agent)) is None:
        await asyncio.sleep(0.05)
    return found


async def component(kind: str, name: str, properties: str) -> None:
    """One agent of any kind, given its properties in JSON."""
    agent = Kinds().make(kind, AgentName.parse(name), json.loads(properties))
    with ZenohBus.open() as bus:
        async with Container(
            bus, f"{agent.name.local}-{agent.name.platform}", platform=agent.name.platform
        ) as container:
            await container.start(agent)
            await _serve()


async def _serve() -> None:
    print(json.dumps({"ready": True}), flush=True)
    await asyncio.to_thread(sys.stdin.read)


KINDS: dict[str, Callable[..., Coroutine[Any, Any, None]]] = {
    "echo": echo,
    "counters": counters,
    "crowd": crowd,
    "sessions": sessions,
    "holder": holder,
    "component": component,
}

if __name__ == "__main__":
    asyncio.run(KINDS[sys.argv[1]](*sys.argv[2:]))

"""A gateway's leases on a bus in memory, an arbiter and agents who hold leases, in virtual time."""

import asyncio
import itertools
from collections.abc import Awaitable, Mapping
from contextlib import suppress
from typing import Any, TypeVar

from agents.platform import Agent, AgentName, Container, Outcome, Report, Request
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from bus import Bus, BusUnavailable, Conversation, MemoryBus, MemoryNetwork, Refused
from bus.aio import hand_over
from gateway.errors import CommandRefused
from gateway.lease import ROBOT, Leases

T = TypeVar("T")
ARBITER = AgentName("arbiter", "team")
TICK = 0.05  # s from one look at the clock to the next, as a gateway's SIPs have it


class Gateway:
    """The leases of one robot, as its gateway serves them.

    stopped: what had to stand still, with the time. delay: s until it answers what it has done.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, network: MemoryNetwork, robot: str) -> None:
        self.stopped: list[tuple[float, str]] = []
        self.delay = 0.0
        self._loop = loop
        self._robot = robot
        self._network = network
        self._bus: Bus | None = None
        self.start()

    def start(self) -> None:
        """Begin anew, knowing nothing of the past."""
        self.leases = Leases(map(f"{id(self)}-{{}}".format, itertools.count(1)).__next__, ["base", "gripper"])
        self._bus = MemoryBus(self._network)
        self._bus.converse(f"{self._robot}/lease", self._answer)
        self._bus.declare_alive(f"{self._robot}/alive")
        self.tell()

    def kill(self) -> None:
        if self._bus is not None:
            self._bus.close()
            self._bus = None

    def tell(self) -> None:
        if self._bus is not None:
            self._bus.put(f"{self._robot}/lease/state", self.leases.state(self._loop.time()))

    async def live(self) -> None:
        while True:
            await asyncio.sleep(TICK)
            self._stand(self.leases.expire(self._loop.time()))

    def moves(self, element: str, token: str) -> bool:
        """Whether a command with this token passes."""
        with suppress(CommandRefused):  # then it does not move
            self.leases.check(element, token)
            return True
        return False

    def _stand(self, names: list[str]) -> None:
        self.stopped += [(self._loop.time(), name) for name in names]
        if names:
            self.tell()

    def _answer(self, given: dict[str, Any], conversation: Conversation) -> None:
        try:
            answer = self._serve(given)
            hand_over(self._loop, self._loop.call_later, self.delay, self._reply, conversation, answer)
        except Refused as refusal:
            conversation.refuse(refusal.why)

    def _reply(self, conversation: Conversation, answer: dict[str, Any]) -> None:
        with suppress(BusUnavailable), conversation:  # a bus that a test has cut
            conversation.reply(answer)

    def _serve(self, given: dict[str, Any]) -> dict[str, Any]:
        now = self._loop.time()
        self._stand(self.leases.expire(now))
        try:
            match given:
                case {"do": "take", "holder": holder, "priority": priority, "seconds": seconds}:
                    what = given.get("element", ROBOT)
                    lease, token, names = self.leases.take(what, holder, priority, seconds, now)
                    self._stand(names)
                    return {"token": token, "element": lease.what, **lease.state(now)}
                case {"do": "renew", "token": token, "seconds": seconds}:
                    lease = self.leases.renew(token, seconds, now)
                    return {"element": lease.what, **lease.state(now)}
                case {"do": "release", "token": token}:
                    lease = self.leases.release(token)
                    self._stand([lease.what])
                    return {"element": lease.what, **lease.state(now)}
        except CommandRefused as refusal:
            raise Refused(str(refusal)) from refusal
        return self.leases.state(now)


class LeaseWorld:
    """The robot `happy`, an arbiter, and agents of processes of their own.

    reports: what went wrong anywhere, in words.
    """

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[str] = []
        self._buses: dict[AgentName, Bus] = {}
        self._containers: dict[AgentName, Container] = {}
        self.gateway = Gateway(loop, self.network, "happy")
        self._living = loop.create_task(self.gateway.live())

    def do(self, work: Awaitable[T]) -> T:
        """Let time pass until this is done."""

        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def run(self, seconds: float) -> None:
        self.loop.run_for(seconds)

    async def begin(self, agent: Agent) -> Agent:
        """Let an agent live, in a process of its own."""
        self._buses[agent.name] = MemoryBus(self.network)
        container = Container(self._buses[agent.name], f"of-{agent.name.local}", self._note)
        self._containers[agent.name] = container
        assert await container.start(agent)
        return agent

    def arbiter(self, name: AgentName = ARBITER, properties: Mapping[str, Any] | None = None) -> Agent:
        return self.do(self.begin(Arbiter(name, properties)))

    def holder(self, local: str) -> Agent:
        return self.do(self.begin(Agent(AgentName(local, "lab"))))

    def agent(self, name: AgentName) -> Agent:
        """One that has begun to live."""
        agent = self._containers[name].agent(name)
        assert isinstance(agent, Agent)
        return agent

    async def end(self, agent: AgentName) -> None:
        """End the process of an agent in good order."""
        await self._containers.pop(agent).close()

    def kill(self, agent: Agent) -> None:
        """Its process dies: nothing of it is heard any more."""
        self.kill_named(agent.name)

    def kill_named(self, agent: AgentName) -> None:
        self._buses[agent].close()

    def ask(self, agent: Agent, name: str, arbiter: AgentName = ARBITER, **arguments: Any) -> Outcome:
        """Let an agent ask the arbiter."""
        return self.do(agent.request(arbiter, name, **arguments))

    def begin_asking(self, agent: Agent, name: str, arbiter: AgentName = ARBITER, **arguments: Any) -> Request:
        """Let an agent ask the arbiter, without waiting for the end."""

        async def begun() -> Request:
            return agent.begin_request(arbiter, name, **arguments)

        return self.do(begun())

    def events(self, agent: Agent) -> list[str]:
        """What the record says has happened."""
        return [row["event"] for row in self.ask(agent, "audit").value()]

    def close(self) -> None:
        for container in self._containers.values():
            with suppress(Exception):  # of processes that have been killed
                self.do(container.close())
        self._living.cancel()
        self.gateway.kill()
        self.run(0.01)

    def _note(self, report: Report) -> None:
        self.reports.append(f"{report.agent}: {report.what}: {report.error}")

"""Restarts what has failed: agents by their container, frozen containers by their host.

An agent that fails while its container runs is restarted here, by the rules of `restarts`. A container whose process
has ended is restarted by the host (`acromovi up`), which notices it itself. A container that is frozen has a process
but does
not answer: the host is requested to restart it. An agent that was stopped on purpose is not restarted, since only a
container's report of a failure starts this.
"""

import asyncio
import json
import shlex
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agents.platform import AgentName, OneShot
from agents.platform.behaviours import Behaviour
from agents.platform.container.context import AgentEnd
from agents.platform.errors import in_words
from agents.platform.names import ContainerName
from agents.services.events import Level
from agents.services.loaded import KIND as APPLICATION
from agents.services.restarts import Restarts
from agents.services.streams import Tell
from agents.services.watching import Named
from bus import BusError, NoAnswer, Refused, TimedOut

FROZEN_AFTER = 1.0  # s without its token after which the host is queried about a container
START_TIME = 35.0  # s for a container to start an agent; its own limit for a setup is 30 s
ANSWER_TIME = 2.0  # s for anything else
RUNNING = "running"  # the state of a process in the host's answer

Ask = Callable[[str, Mapping[str, Any], float], Awaitable[dict[str, Any]]]


class Supervision:
    """Restarts failed agents and frozen containers, in the monitor's event loop."""

    def __init__(
        self,
        team: str,
        restarts: Restarts,
        is_there: Callable[[Named], bool],
        ask: Ask,
        tell: Tell,
        do: Callable[[Behaviour], object],
    ) -> None:
        """Start without tasks.

        Args:
            team: The team of the host.
            restarts: When agents are restarted.
            is_there: Returns whether an agent or a container is present.
            ask: Queries a key of the bus, with a timeout in s.
            tell: Called with each action and its subject.
            do: Starts a behaviour.
        """
        self.restarts = restarts
        self._team = team
        self._is_there = is_there
        self._ask = ask
        self._tell = tell
        self._do = do
        self._processes: dict[ContainerName, int] = {}
        self._under_way: set[AgentName | ContainerName] = set()

    @property
    def under_way(self) -> list[str]:
        """The agents and containers that are being restarted."""
        return sorted(map(str, self._under_way))

    def container_came(self, container: ContainerName) -> None:
        """Query a container's process, so that it can be distinguished from its successor."""
        self._do(OneShot(lambda: self._get_to_know(container), f"get to know {container}"))

    def container_gone(self, container: ContainerName) -> None:
        """Check whether a container whose token has disappeared is frozen."""
        self._begin(container, lambda: self._look_after(container))

    def agent_failed(self, agent: AgentName, container: ContainerName, report: Mapping[str, Any]) -> None:
        """Take a container's report that one of its agents has failed or was not set up."""
        match report:
            case {"ended": AgentEnd.NOT_SET_UP} if agent.platform != self._team:
                return  # whoever started it is told; only the team's own agents are started by nobody who would hear it
            case {"kind": str(kind), "properties": dict(properties)}:
                order = {"do": "start", "name": str(agent), "kind": kind, "properties": properties}
                self._begin(agent, lambda: self._start_again(agent, container, order))

    def _begin(self, whom: AgentName | ContainerName, work: Callable[[], Awaitable[None]]) -> None:
        if whom in self._under_way:
            return  # an attempt that failed is told of twice: by the answer, and by the report

        async def look_after() -> None:
            try:
                await work()
            finally:
                self._under_way.discard(whom)

        self._under_way.add(whom)
        self._do(OneShot(look_after, f"look after {whom}"))

    async def _start_again(self, agent: AgentName, container: ContainerName, order: Mapping[str, Any]) -> None:
        now = asyncio.get_running_loop().time
        what = f"{agent} has failed"
        while (pause := self.restarts.failed(agent, now())) is not None:
            attempt = self.restarts.attempts(agent)
            self._tell(agent, f"{what}; attempt {attempt} to start it again in {pause:.2g} s", Level.WARNING)
            await asyncio.sleep(pause)
            if self._is_there(agent):
                return  # another program was faster
            self.restarts.attempted(agent, now())
            try:
                await self._ask(container.control_key, order, START_TIME)
            except Refused as err:
                what = f"{agent} could not be started again, since {err.why}"
                continue
            except (BusError, TimeoutError) as err:
                what = f"{agent} is not started again: its container {container} does not answer"
                self._tell(agent, f"{what} ({in_words(err)})", Level.ERROR)
                return
            self._tell(agent, f"{agent} has been started again", Level.OK)
            return
        self._tell(agent, f"{what}, and is given up; correct it, and: {_advice(order, container)}", Level.ERROR)

    async def _get_to_know(self, container: ContainerName) -> None:
        try:
            answer = await self._ask(container.control_key, {"do": "list"}, ANSWER_TIME)
        except (BusError, TimeoutError):
            return  # an unknown process is never taken for a frozen one
        match answer:
            case {"process": int(process)}:
                self._processes[container] = process

    async def _look_after(self, container: ContainerName) -> None:
        known = self._processes.pop(container, None)
        await asyncio.sleep(FROZEN_AFTER)
        is_back = self._is_there(container)
        host = f"{self._team}/host/control"
        try:
            row = _row_of(container, await self._ask(host, {"do": "status"}, ANSWER_TIME))
            if row is None:
                return  # started by hand, and so for that hand to start again
            if row.get("state") == RUNNING and known is not None and row.get("pid") == known:
                if is_back:
                    return  # it was disconnected for a moment
                await self._ask(host, {"do": "restart", "container": container.name}, ANSWER_TIME)
                what = f"the container {container} is frozen (process {known}), and its host starts it anew"
            else:
                does = "has started" if is_back else "starts"
                what = f"the container {container} {_ending(row.get('why'))}; its host {does} it again"
            self._tell(container, what, Level.OK if is_back else Level.WARNING)
        except Refused as err:
            self._tell(container, f"the host does not start the container {container} again: {err.why}", Level.ERROR)
        except TimedOut:
            self._tell(container, f"the host of {self._team} does not answer; see to {container} by hand", Level.ERROR)
        except (NoAnswer, TimeoutError):
            return  # there is no host: everything was started by hand


def _advice(order: Mapping[str, Any], container: ContainerName) -> str:
    """Return the command that restarts an agent."""
    properties = order["properties"]
    if order["kind"] == APPLICATION:
        place = "loader" if "loader" in properties else container
        return f"acromovi promote {properties.get('program')}.py --into {place}"
    given = [shlex.quote(f"{name}={json.dumps(value)}") for name, value in properties.items()]
    return " ".join(["acromovi agent start", order["name"], order["kind"], *given, "--in", str(container)])


def _ending(why: object) -> str:
    """Return how a process has ended, by its host, as a part of a sentence."""
    return why if isinstance(why, str) and why.startswith("ended ") else f"ended ({why or 'nobody knows why'})"


def _row_of(container: ContainerName, status: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the host's row about the process of one container."""
    rows = status.get("processes")
    listed = rows if isinstance(rows, list) else []
    return next((row for row in listed if isinstance(row, dict) and row.get("container") == container.name), None)

"""Keeps the agents of a container consistent with the elements of its robot.

Tokens show which elements exist, the robot's description shows their properties. An element may have further agents
(`DERIVED`). An agent that was stopped by another program, or moved into another container, is not started until its
element comes back. What an agent packs is kept meanwhile.
"""

import asyncio
import logging
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

from agents.components.all_components import DERIVED, NEEDED, component_for
from agents.platform import AgentName, AlreadyThere, Container, Restart, UnknownAgent
from agents.platform.errors import NameNotValid
from bus import BusUnavailable, Refused
from bus.aio import hand_over, query
from bus.keys import DESCRIPTION, ELEMENT_ALIVE, robot_name
from configs.extras import missing, needs

DESCRIPTION_TIME = 2.0  # s
LOOK_AGAIN = 10.0  # s between two checks of the description, which may have changed
RETRY = Restart(first=0.25, longest=15.0)

log = logging.getLogger("agents")

Descriptions = dict[str, dict[str, Any]]


class RobotAgents:
    """Starts an agent for each element of a robot, and stops it when the element disappears."""

    def __init__(self, container: Container, robot: str) -> None:
        """Prepare it; `run` starts it.

        Args:
            container: The container of the agents.
            robot: The robot's name on the bus.
        Raises:
            KeyNotValid: The name is not valid for a robot.
        """
        self._container = container
        self._robot = robot_name(robot)
        self._present: set[str] = set()  # elements with a token
        self._derived: dict[str, Collection[str]] = {}  # further agents that can run here, of elements seen so far
        self._kept: dict[str, dict[str, Any]] = {}  # what agents had packed when their elements disappeared
        self._elsewhere: set[str] = set()  # elements with an agent, here or in another container
        self._served: dict[str, Mapping[str, Any]] = {}  # the description when the agent was started
        self._failures: dict[str, int] = {}  # to start an agent, in a row
        self._silences = 0  # in place of a description, in a row
        self._changed = asyncio.Event()

    async def run(self) -> None:
        """Run until cancelled; then the agents continue until the container stops them."""
        loop, bus = asyncio.get_running_loop(), self._container.bus

        def note(among: set[str], key: str, is_alive: bool) -> None:
            element = key.split("/")[2]
            (among.add if is_alive else among.discard)(element)
            self._changed.set()

        elements, agents = ELEMENT_ALIVE.key(self._robot), f"{self._robot}/agents/*/alive"
        with (
            bus.watch_alive(agents, lambda key, is_alive: hand_over(loop, note, self._elsewhere, key, is_alive)),
            bus.watch_alive(elements, lambda key, is_alive: hand_over(loop, note, self._present, key, is_alive)),
        ):
            while True:
                self._changed.clear()
                pause = await self._follow()
                with suppress(TimeoutError):  # nothing has changed: check again
                    async with asyncio.timeout(pause):
                        await self._changed.wait()

    async def _follow(self) -> float:
        """Start and stop agents; return after how many seconds to check again, even if no token changes."""
        wanted = self._wanted()
        await asyncio.gather(*(self._stop(element) for element in self._served.keys() - wanted))
        for element in self._failures.keys() - wanted:
            del self._failures[element]
        if not wanted:
            return LOOK_AGAIN
        described = await self._described()
        if described is None:
            self._silences += 1
            return RETRY.pause(self._silences)
        self._silences = 0
        await asyncio.gather(*(self._serve(element, described) for element in sorted(wanted)))
        return min((RETRY.pause(failures) for failures in self._failures.values()), default=LOOK_AGAIN)

    def _wanted(self) -> set[str]:
        """Return the names of the agents that are to run: those of the elements, and further ones."""
        for element in self._present & DERIVED.keys() - self._derived.keys():
            extra = NEEDED.get(element)
            lacking = missing(extra) if extra is not None else []
            self._derived[element] = () if lacking else DERIVED[element]
            if lacking:
                why = needs("their work", *lacking)
                log.info("%s has no agents of the %s's images: %s", self._robot, element, why)
        return self._present.union(*(self._derived.get(element, ()) for element in self._present))

    async def _serve(self, element: str, described: Descriptions) -> None:
        """Start the agent of an element, or adapt it to the present description."""
        if element not in described:
            self._fail(element)  # a token can come before the description
        elif element not in self._served:
            await self._start(element, described[element])
        elif described[element] != self._served[element]:
            await self._renew(element, described[element])

    async def _start(self, element: str, properties: dict[str, Any]) -> None:
        if element in self._elsewhere:
            return  # its agent was moved; its token shows when it has gone
        try:
            agent = component_for(element)(AgentName(element, self._robot), properties)
            is_active = await self._container.start(agent)
        except AlreadyThere:
            return  # another container was faster; its token shows when that agent has gone
        except NameNotValid as err:
            log.warning("no agent can serve %s of %s: %s", element, self._robot, err)
            is_active = False
        if is_active:
            if element in self._kept:
                agent.unpack(self._kept.pop(element))
            self._served[element] = properties
            self._failures.pop(element, None)
        else:
            self._fail(element)

    async def _renew(self, element: str, properties: dict[str, Any]) -> None:
        """Adapt the agent of an element whose description has changed, or restart it."""
        before, self._served[element] = self._served[element], properties
        try:
            agent = self._container.agent(AgentName(element, self._robot))
        except UnknownAgent:
            return  # another program has stopped or moved it
        if all(before.get(name) == properties.get(name) for name in ("streams", "commands")):
            agent.properties = properties
        else:
            await self._stop(element)
            await self._start(element, properties)

    async def _stop(self, element: str) -> None:
        self._served.pop(element, None)
        name = AgentName(element, self._robot)
        with suppress(UnknownAgent):  # another program has stopped or moved it
            if state := self._container.agent(name).pack():
                self._kept[element] = state
            await self._container.stop(name)

    async def _described(self) -> Descriptions | None:
        """Return the properties of each element's agent, by the element's name; None without a valid description."""
        try:
            (answer, *_) = await query(self._container.bus, DESCRIPTION.key(self._robot), None, DESCRIPTION_TIME)
        except BusUnavailable:
            raise
        except (TimeoutError, Refused):  # None says that it has not described itself; it is asked again
            return None
        return self.described(answer.value)

    @staticmethod
    def described(description: Mapping[str, Any]) -> Descriptions:
        """Return the properties of each element's agent, by the element's name; invalid rows are left out.

        An element that is described twice has the streams and commands of both.
        """
        rows: dict[str, dict[str, Any]] = {}
        elements = description.get("elements")
        for row in elements if isinstance(elements, list) else []:
            match row:
                case {"name": str(name), "streams": list(streams), "commands": list(commands)}:
                    first = rows.get(name, {"streams": [], "commands": []})
                    both = {"streams": [*first["streams"], *streams], "commands": [*first["commands"], *commands]}
                    rows[name] = {**first, **row, **both}
        found: Descriptions = {}
        agents = [(name, row) for element, row in rows.items() for name in (element, *DERIVED.get(element, ()))]
        for name, row in agents:
            try:
                found[name] = component_for(name).properties_of(description, row)
            except (LookupError, TypeError, ValueError) as err:
                log.warning("what the robot says of its %s makes no sense: %r", name, err)
        return found

    def _fail(self, element: str) -> None:
        self._failures[element] = self._failures.get(element, 0) + 1

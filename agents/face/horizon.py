"""Which agents and robots are in sight, and waiting a little for those that come late."""

import asyncio
import difflib
from collections.abc import Callable, Iterable

from agents.face.errors import NotThere
from agents.platform import AgentName, Directory
from agents.platform.talk import hand_over
from bus import Bus

MEETING_TIME = 3.0  # s in which whoever is there has been seen, on a loaded machine too
QUIET = 0.4  # s without anything new, after which all are taken to have been seen
NO_ROBOTS = "start a team with `acromovi up acromovi`, and see whether both use the same bus"
COMPONENT = "component"  # what the agents of robots' elements offer


class Horizon:
    """The agents in sight, kept up to date; all of it belongs to one event loop."""

    def __init__(self, bus: Bus) -> None:
        """Begin to look, in a running event loop."""
        self._loop = asyncio.get_running_loop()
        self._moved = asyncio.Event()
        self._last_change = self._opened = self._loop.time()
        self._directory = Directory(bus, lambda name, is_there: hand_over(self._loop, self._note))

    def close(self) -> None:
        """Look no more."""
        self._directory.close()

    def sees(self, agent: AgentName) -> bool:
        """Whether it lives."""
        return self._directory.knows(agent)

    async def element(self, agent: AgentName) -> None:
        """Wait until an element's agent is there.

        Raises:
            NotThere: It has not come; says which elements the robot has.
        """
        if await self._until(lambda: self.sees(agent)):
            return
        elements = await self.elements(agent.platform)
        if not elements:
            raise NotThere(f"{agent.platform} is not there any more; see `acromovi ps` for who is")
        raise NotThere(f"{agent.platform} has no {agent.local}; it has {_listed(elements)}")

    async def elements(self, robot: str) -> list[str]:
        """The names of a robot's elements, in the order of the alphabet; none when there is no such robot."""
        return [found.name.local for found in await self._directory.search(COMPONENT, robot)]

    async def robots(self, having: Iterable[str]) -> list[str]:
        """The robots that have all these elements, in the order of the alphabet, once all have had time to be seen."""
        await self._settled()
        return await self._robots(having)

    async def any_robot(self, having: Iterable[str]) -> str:
        """The first robot that has all these elements.

        Raises:
            NotThere: No robot has.
        """
        found = await self.robots(having)
        if found:
            return found[0]
        if others := await self._robots(()):
            raise NotThere(f"no robot has {_listed(list(having))}; there {_are(others)}")
        raise NotThere(f"there is no robot: {NO_ROBOTS}")

    async def robot(self, name: str, having: Iterable[str]) -> None:
        """Wait until a robot is there, and these of its elements.

        Raises:
            NotThere: It has not come; says which robots there are.
        """
        if await self._until(lambda: self._has_agents(name)) and await self.elements(name):
            for element in having:
                await self.element(AgentName(element, name))
            return
        others = await self._robots(())
        if not others:
            raise NotThere(f"there is no robot {name!r}, nor any other: {NO_ROBOTS}")
        near = difflib.get_close_matches(name, others, 1)
        meant = f"did you mean {near[0]!r}? There" if near else "there"
        raise NotThere(f"there is no robot {name!r}; {meant} {_are(others)}")

    async def _robots(self, having: Iterable[str]) -> list[str]:
        elements: dict[str, set[str]] = {}
        for found in await self._directory.search(COMPONENT):
            elements.setdefault(found.name.platform, set()).add(found.name.local)
        return sorted(robot for robot, has in elements.items() if has.issuperset(having))

    def _has_agents(self, platform: str) -> bool:
        return any(name.platform == platform for name in self._directory.names)

    async def _settled(self) -> None:
        """Wait until robots have been seen and nothing new comes, or until they ought to have been seen."""
        while (now := self._loop.time()) < self._opened + MEETING_TIME:
            if now - self._last_change >= QUIET and len({name.platform for name in self._directory.names}) > 1:
                return
            await asyncio.sleep(QUIET / 4)

    async def _until(self, condition: Callable[[], bool]) -> bool:
        deadline = self._loop.time() + MEETING_TIME
        while not condition():
            try:
                async with asyncio.timeout_at(deadline):
                    await self._moved.wait()
            except TimeoutError:
                return condition()
        return True

    def _note(self) -> None:
        """Somebody has come or gone."""
        self._last_change = self._loop.time()
        self._moved.set()
        self._moved = asyncio.Event()


def _listed(names: list[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last


def _are(names: list[str]) -> str:
    return f"{'is' if len(names) == 1 else 'are'} {_listed(names)}"

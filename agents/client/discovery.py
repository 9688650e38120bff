"""Discovery of agents and robots on the bus; it waits for those that start late or are being restarted."""

import asyncio
import contextlib
from collections.abc import Callable, Iterable
from functools import partial

from agents.client.errors import NotThere
from agents.platform import AgentName, Directory
from bus import Bus
from bus.aio import hand_over
from configs.suggestion import meant

MEETING_TIME = 3.0  # s in which all present agents have been seen, once the bus has met all programs
QUIET = 0.4  # s without a new agent, after which all are taken to have been seen
RETURN_TIME = 20.0  # s in which a robot or an element that disappeared is back after a restart, on a loaded machine too
FORGET_TIME = 60.0  # s for which a disappearance is kept for messages
NO_ROBOTS = "start a team with `acromovi up acromovi`, and see whether both use the same bus"
COMPONENT = "component"  # the service of the agents of elements


class Discovery:
    """The agents on the bus, kept up to date in one event loop."""

    def __init__(self, bus: Bus) -> None:
        """Start watching, in a running event loop."""
        self._bus = bus
        self._loop = asyncio.get_running_loop()
        self._moved = asyncio.Event()
        self._last_change = self._opened = self._loop.time()
        self._left: dict[AgentName, float] = {}  # agents that disappeared lately, and when
        self._directory = Directory(bus, lambda name, is_there: hand_over(self._loop, self._note, name, is_there))

    def close(self) -> None:
        """Stop watching."""
        self._directory.close()

    def sees(self, agent: AgentName) -> bool:
        """Return whether an agent is present."""
        return self._directory.knows(agent)

    async def element(self, agent: AgentName, within: float | None = None) -> None:
        """Wait until an element's agent is present.

        Args:
            agent: The agent of the element.
            within: s to wait; by default longer for an agent that has just disappeared than for one never seen.
        Raises:
            NotThere: It has not appeared; the message names the elements of the robot.
        """
        begun, moved = self._loop.time(), self._moved
        while not self.sees(agent):
            if not await self._is_set(moved, partial(self._end_of_wait, begun, within, self._left.get(agent))):
                raise await self._no_element(agent)
            moved = self._moved

    async def elements(self, robot: str) -> list[str]:
        """Return the names of a robot's elements, in alphabetical order; none when there is no such robot."""
        return [found.name.local for found in await self._directory.search(COMPONENT, robot)]

    async def robots(self, having: Iterable[str]) -> list[str]:
        """Return the robots with all these elements, in alphabetical order, once all have had time to appear."""
        await self._settled()
        return await self._robots(having)

    async def any_robot(self, having: Iterable[str], within: float | None = None) -> str:
        """Return the first robot with all these elements.

        Args:
            having: Names of elements.
            within: s to wait for one; by default only until all robots have had time to appear.
        Raises:
            NotThere: There is none.
        """
        end, moved = self._loop.time() + (within or 0.0), self._moved
        found = await self.robots(having)
        while not found:
            if not await self._is_set(moved, lambda: end):
                raise await self._none_has(having)
            moved = self._moved
            found = await self._robots(having)
        return found[0]

    async def robot(self, name: str, having: Iterable[str], within: float | None = None) -> None:
        """Wait until a robot and these of its elements are present.

        Args:
            name: The robot.
            having: Names of elements.
            within: s to wait; by default longer for a robot that has just disappeared than for one never seen.
        Raises:
            NotThere: It has not appeared; the message names the robots that are present.
        """
        begun, moved = self._loop.time(), self._moved
        while not (self._has_agents(name) and await self.elements(name)):
            if not await self._is_set(moved, partial(self._end_of_wait, begun, within, self._left_at(name))):
                raise await self._no_robot(name)
            moved = self._moved
        for element in having:
            rest = None if within is None else max(begun + within - self._loop.time(), 0.0)
            await self.element(AgentName(element, name), rest)

    async def _no_element(self, agent: AgentName) -> NotThere:
        elements = await self.elements(agent.platform)
        if not elements:
            return NotThere(f"{agent.platform} is not there any more; see `acromovi ps` for who is")
        has = f"it has {_listed(elements)}"
        if (left := self._left.get(agent)) is None:
            return NotThere(f"{agent.platform} has no {agent.local}; {has}")
        return NotThere(f"{agent.platform} has lost its {agent.local} {self._ago(left)}; {has}")

    async def _no_robot(self, name: str) -> NotThere:
        others = await self._robots(())
        there = f"there {_are(others)}" if others else ""
        if (left := self._left_at(name)) is not None:
            return NotThere(
                f"the robot {name!r} left {self._ago(left)} and has not come back; {there or 'no robot is there'}"
            )
        if not others:
            return NotThere(f"there is no robot {name!r}, nor any other: {NO_ROBOTS}")
        near = meant(name, others)
        advice = f"did you mean {near!r}? There {_are(others)}" if near else there
        return NotThere(f"there is no robot {name!r}; {advice}")

    async def _none_has(self, having: Iterable[str]) -> NotThere:
        if others := await self._robots(()):
            return NotThere(f"no robot has {_listed(list(having))}; there {_are(others)}")
        return NotThere(f"there is no robot: {NO_ROBOTS}")

    async def _robots(self, having: Iterable[str]) -> list[str]:
        elements: dict[str, set[str]] = {}
        for found in await self._directory.search(COMPONENT):
            elements.setdefault(found.name.platform, set()).add(found.name.local)
        return sorted(robot for robot, has in elements.items() if has.issuperset(having))

    def _has_agents(self, platform: str) -> bool:
        return any(name.platform == platform for name in self._directory.names)

    async def _settled(self) -> None:
        """Wait until robots have appeared and no new ones come, or until they should have appeared."""
        end = self._opened + MEETING_TIME
        while (now := self._loop.time()) < end or not self._bus.has_met_all:
            is_quiet = now - self._last_change >= QUIET and self._bus.has_met_all
            if is_quiet and len({name.platform for name in self._directory.names}) > 1:
                return
            await asyncio.sleep(QUIET / 4)

    def _left_at(self, platform: str) -> float | None:
        """Return when the last of a platform's agents disappeared; None if none has lately, or one is present."""
        if self._has_agents(platform):
            return None
        return max((left for name, left in self._left.items() if name.platform == platform), default=None)

    def _ago(self, left: float) -> str:
        return f"{self._loop.time() - left:.0f} s ago"

    def _end_of_wait(self, begun: float, within: float | None, left: float | None) -> float:
        """Return the end of a wait, in the loop's time.

        Args:
            begun: When the wait began.
            within: s to wait, if the caller gives it.
            left: When it disappeared, if it was present lately.
        """
        if within is not None:
            return begun + within
        if not self._bus.has_met_all:
            begun = self._loop.time()
        return max(begun + MEETING_TIME, 0.0 if left is None else left + RETURN_TIME)

    async def _is_set(self, moved: asyncio.Event, end: Callable[[], float]) -> bool:
        """Wait until an agent appears or disappears; return False if none has before `end`.

        Args:
            moved: `_moved` before the caller looked, so that no change is missed.
            end: In the loop's time; it may be later by then.
        """
        while (limit := end()) > self._loop.time():
            with contextlib.suppress(TimeoutError):  # nothing has moved until the limit
                async with asyncio.timeout_at(limit):
                    return await moved.wait()
        return False

    def _note(self, name: AgentName, is_there: bool) -> None:
        """Note that an agent has appeared or disappeared."""
        now = self._last_change = self._loop.time()
        self._left = {agent: left for agent, left in self._left.items() if now - left < FORGET_TIME and agent != name}
        if not is_there:
            self._left[name] = now
        self._moved.set()
        self._moved = asyncio.Event()


def _listed(names: list[str]) -> str:
    """Return `a`, `a and b`, or `a, b and c`."""
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last


def _are(names: list[str]) -> str:
    return f"{'is' if len(names) == 1 else 'are'} {_listed(names)}"

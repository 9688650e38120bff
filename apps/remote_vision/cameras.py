"""The cameras of the team: which robots have one, what their heads can do, and which vision agents they have."""

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from agents.client.discovery import Discovery
from agents.platform import AgentName, Description, Directory
from apps.remote_vision.viewing import image_words
from bus import Bus
from bus.aio import hand_over
from bus.bus import Closeable

CAMERA, HEAD = "camera", "ptz"
_SETTLE = 0.2
"""s after a change of the agents, in which others follow, until their descriptions are read."""


@dataclass(frozen=True, slots=True)
class CameraFacts:
    """What is known of the camera of a robot.

    agents: local names of all agents of the robot. properties: of its camera's agent. head: of its head's agent; empty
    without a head.
    """

    robot: str
    agents: frozenset[str]
    properties: Mapping[str, Any]
    head: Mapping[str, Any]

    @property
    def has_head(self) -> bool:
        """Whether a head can be moved."""
        return HEAD in self.agents


class TeamCameras(Closeable):
    """The cameras on a bus, kept up to date in one event loop.

    facts: by robot; a robot that has lost its camera is kept, since it may come back.
    changes: counts the changes, so that a page notices them.
    """

    def __init__(self, bus: Bus) -> None:
        """Start watching, in a running event loop."""
        self.facts: dict[str, CameraFacts] = {}
        self.changes = 0
        self._loop = asyncio.get_running_loop()
        self._discovery = Discovery(bus)
        self._reading: asyncio.Task[None] | None = None
        self._is_due = False
        self._directory = Directory(bus, lambda name, is_there: hand_over(self._loop, self._changed))

    def close(self) -> None:
        """Stop watching."""
        if self._reading is not None:
            self._reading.cancel()
        self._directory.close()
        self._discovery.close()

    async def expect(self, robot: str) -> None:
        """Wait until a robot has a camera.

        Raises:
            NotThere: It has none; the message says which robots and elements are there.
        """
        await self._discovery.robot(robot, (CAMERA,))
        await self._read()

    def has(self, robot: str, agent: str) -> bool:
        """Return whether an agent of a robot is present now."""
        return self._directory.knows(AgentName(agent, robot))

    def words(self, robot: str, silence: float) -> str:
        """Return why there is no image of a robot, after so many s without one."""
        is_there = any(name.platform == robot for name in self._directory.names)
        return image_words(robot, silence, is_there, self.has(robot, CAMERA))

    def _changed(self) -> None:
        self.changes += 1
        self._is_due = True
        if self._reading is None or self._reading.done():
            self._reading = asyncio.ensure_future(self._read_when_settled())

    async def _read_when_settled(self) -> None:
        while self._is_due:
            self._is_due = False
            await asyncio.sleep(_SETTLE)
            await self._read()

    async def _read(self) -> None:
        """Read the descriptions of all agents."""
        found: dict[str, dict[str, Description]] = {}
        for description in await self._directory.search():
            found.setdefault(description.name.platform, {})[description.name.local] = description
        for robot, agents in found.items():
            if CAMERA in agents:
                head = agents[HEAD].properties if HEAD in agents else {}
                self.facts[robot] = CameraFacts(robot, frozenset(agents), agents[CAMERA].properties, head)
            elif robot in self.facts:  # lens and head come back as they were
                known = self.facts[robot]
                self.facts[robot] = CameraFacts(robot, frozenset(agents), known.properties, known.head)
        self.changes += 1

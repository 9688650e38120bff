"""All that the pages share: the agent, the team's cameras, the streams, and the viewings."""

import asyncio
import secrets
from contextlib import AsyncExitStack
from typing import Any, Self

from agents.platform import Agent, Outcome
from apps.remote_vision.cameras import TeamCameras
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.streams import SharedStreams
from apps.remote_vision.transport import ImageTransport
from apps.remote_vision.viewing import ORIGINAL, Viewing
from bus import keys

_PATIENCE = 10.0  # s for a request to a vision agent


class RemoteVision:
    """The program behind the pages, for the time of a block.

    agent: asks all other agents. settings: of the application. team: the cameras. viewings: by ticket.
    """

    def __init__(self, agent: Agent, settings: RemoteVisionSettings) -> None:
        self.agent = agent
        self.settings = settings
        self.viewings: dict[str, Viewing] = {}
        self._count = 0
        self._open = AsyncExitStack()

    async def __aenter__(self) -> Self:
        self.team = self._open.enter_context(TeamCameras(self.agent.bus))
        self.streams = self._open.enter_context(SharedStreams(self.agent.bus, self.settings.images.linger_s))
        self.transport = ImageTransport(
            self.streams, self.viewings, self.settings.images, self.team.words, self.agent.home.wall_time
        )
        return self

    async def __aexit__(self, *error: object) -> None:
        await self._open.aclose()

    def begin_viewing(self, robot: str, address: str) -> Viewing:
        """Return the state of a new page.

        Args:
            robot: Whose camera it shows first.
            address: Of the browser.
        """
        self._count += 1
        viewing = Viewing(secrets.token_urlsafe(16), f"viewer {self._count} at {address}")
        viewing.seen_at = asyncio.get_running_loop().time()
        self.viewings[viewing.ticket] = viewing
        self.choose(viewing, robot)
        return viewing

    def end_viewing(self, viewing: Viewing) -> None:
        """Forget a page."""
        self.viewings.pop(viewing.ticket, None)

    def choose(self, viewing: Viewing, robot: str) -> None:
        """Show the camera of a robot, without a result."""
        viewing.robot = robot
        viewing.keys = {ORIGINAL: keys.CAMERA.key(robot)}
        viewing.shown.clear()

    async def ask(self, robot: str, agent: str, request: str, **arguments: Any) -> Outcome:
        """Have an agent of a robot do something."""
        return await self.agent.request(f"{agent}@{robot}", request, reply_within=_PATIENCE, **arguments)

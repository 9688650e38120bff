"""All that the pages share: the agent, the team's cameras, the streams, the viewings, and who steers which head."""

import asyncio
import secrets
import time
from contextlib import AsyncExitStack
from typing import Any, Self

from agents.platform import Agent, AgentError, Ending, Outcome
from agents.platform.errors import in_words
from apps.remote_vision.aiming import HeadPlace
from apps.remote_vision.cameras import CAMERA, HEAD, TeamCameras
from apps.remote_vision.operations import OperationChoice
from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.steering import HeadControl
from apps.remote_vision.streams import SharedStreams
from apps.remote_vision.transport import ImageTransport
from apps.remote_vision.viewing import ORIGINAL, RESULT, VISION, Viewing
from bus import BusError, keys

_PATIENCE = 10.0  # s for a request to a vision agent
_CHECK = 0.1  # s between two looks at who steers
_RETURN = 3.0  # s without a result after which its stream is requested again: the agent has been restarted


class RemoteVision:
    """The program behind the pages, for the time of a block.

    agent: asks all other agents. settings: of the application. team: the cameras. viewings: by ticket.
    """

    def __init__(self, agent: Agent, settings: RemoteVisionSettings) -> None:
        self.agent = agent
        self.settings = settings
        self.viewings: dict[str, Viewing] = {}
        self._heads: dict[str, HeadControl] = {}
        self._places: dict[str, HeadPlace] = {}
        self._requests: set[asyncio.Task[None]] = set()
        self._count = 0
        self._open = AsyncExitStack()

    async def __aenter__(self) -> Self:
        self.team = self._open.enter_context(TeamCameras(self.agent.bus))
        self.streams = self._open.enter_context(SharedStreams(self.agent.bus, self.settings.images.linger_s))
        self.transport = ImageTransport(
            self.streams, self.viewings, self.settings.images, self._words, self.agent.home.wall_time
        )
        self._tasks = [asyncio.ensure_future(self._follow_results())]
        return self

    async def __aexit__(self, *error: object) -> None:
        for task in (*self._tasks, *self._requests):
            task.cancel()
        # one that fails keeps no other from stopping
        await asyncio.gather(*(head.close() for head in self._heads.values()), return_exceptions=True)
        await self._open.aclose()

    def begin_viewing(self, robot: str, address: str) -> Viewing:
        """Return the state of a new page.

        Args:
            robot: Whose camera it shows first.
            address: Of the browser.
        """
        self._count += 1
        viewing = Viewing(secrets.token_urlsafe(16), f"viewer {self._count} ({address})")
        viewing.seen_at = asyncio.get_running_loop().time()
        self.viewings[viewing.ticket] = viewing
        self.choose_camera(viewing, robot)
        return viewing

    async def end_viewing(self, viewing: Viewing) -> None:
        """Forget a page; what it steered is stopped."""
        self.viewings.pop(viewing.ticket, None)
        for head in self._heads.values():
            if head.holder is viewing:
                await head.release("the page was closed")

    def choose_camera(self, viewing: Viewing, robot: str) -> None:
        """Show the camera of a robot, without a result."""
        viewing.robot = robot
        viewing.keys = {ORIGINAL: keys.CAMERA.key(robot)}
        viewing.choice = OperationChoice()
        viewing.shown.clear()

    def head(self, robot: str) -> HeadControl:
        """Return the control of a robot's head."""
        if robot not in self._heads:
            self._heads[robot] = HeadControl(self.agent, robot, self.settings.control, self.say)
            self._tasks.append(asyncio.ensure_future(self._watch(self._heads[robot])))
            self.agent.listen(f"{robot}/agents/{HEAD}/results", lambda result: self._hear_head(robot, result))
        return self._heads[robot]

    async def head_place(self, robot: str) -> HeadPlace | None:
        """Return where a head looks; None if that is not known."""
        if robot not in self._places:
            outcome = await self.ask(robot, HEAD, "read")
            place = HeadPlace.from_result(outcome.result) if outcome.is_done else None
            if place is not None:
                self._places.setdefault(robot, place)
        return self._places.get(robot)

    def known_place(self, robot: str) -> HeadPlace | None:
        """Return where a head was when it last reported."""
        return self._places.get(robot)

    async def show_result(self, viewing: Viewing, name: str, chain: list[dict[str, Any]] | str) -> None:
        """Show the results of a chain beside the image; what prevents it is told to the viewer.

        Args:
            viewing: The page.
            name: Of the operation or saved chain, for people.
            chain: Its steps, or its name.
        """
        viewing.choice.chain = chain
        viewing.choice.name = name
        await self._request_result(viewing, is_new=True)

    def hide_result(self, viewing: Viewing) -> None:
        """Show no result."""
        viewing.choice = OperationChoice()
        viewing.keys.pop(RESULT, None)
        viewing.shown.pop(RESULT, None)

    async def ask(self, robot: str, agent: str, request: str, **arguments: Any) -> Outcome:
        """Have an agent of a robot do something; what prevents the request is an outcome as well."""
        try:
            return await self.agent.request(f"{agent}@{robot}", request, reply_within=_PATIENCE, **arguments)
        except (AgentError, BusError) as err:  # arguments that are too large for a message, or a bus that is closed
            return Outcome(Ending.FAILED, why=in_words(err))

    def say(self, viewing: Viewing, words: str) -> None:
        """Show a viewer what has happened."""
        viewing.tell(time.strftime("%H:%M:%S"), words)

    async def _request_result(self, viewing: Viewing, *, is_new: bool = False) -> None:
        choice = viewing.choice
        choice.requested_at = asyncio.get_running_loop().time()
        outcome = await self.ask(viewing.robot, VISION, "stream", chain=choice.chain)
        if viewing.choice is not choice:  # another camera or operation has been chosen meanwhile
            return
        if outcome.is_done:
            viewing.keys[RESULT] = outcome.result["key"]
            if is_new:
                self.say(viewing, f"{choice.name}: shown")
        elif is_new:
            self.say(viewing, f"{choice.name}: {outcome.why}")

    async def _watch(self, head: HeadControl) -> None:
        """Look after the controller of a head, again and again. An error ends one look, and never the watch."""
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(_CHECK)
            try:
                await head.check(loop.time())
            except Exception as err:  # whatever it is, a silent controller must still be noticed
                self.agent.home.report(self.agent.name, f"the controller of the head of {head.robot}", err)

    async def _follow_results(self) -> None:
        """Request streams of results again that have ended, since their agent was restarted."""
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(_CHECK)
            now = loop.time()
            for viewing in list(self.viewings.values()):
                choice, shown = viewing.choice, viewing.shown.get(RESULT)
                is_missing = shown is None or now - shown.at > _RETURN
                if choice.name and is_missing and viewing.is_open and now - choice.requested_at > _RETURN:
                    choice.requested_at = now
                    if self.team.has(viewing.robot, VISION):
                        request = asyncio.ensure_future(self._request_result(viewing))
                        self._requests.add(request)  # the loop itself keeps no task alive
                        request.add_done_callback(self._requests.discard)

    async def _hear_head(self, robot: str, result: dict[str, Any]) -> None:
        if (place := HeadPlace.from_result(result)) is not None:
            self._places[robot] = place

    def _words(self, viewing: Viewing, place: str, silence: float) -> str:
        robot = viewing.robot
        if place == RESULT and self.team.has(robot, CAMERA):
            if not self.team.has(robot, VISION):
                return f"vision@{robot} is not there; the result returns by itself when it is back"
            return f"no result has come for {silence:.1f} s"
        return self.team.words(robot, silence)

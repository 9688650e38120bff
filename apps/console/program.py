"""All that the pages share: the agent, the robots, the events, who drives which robot, and the red button."""

import asyncio
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from starlette.websockets import WebSocket, WebSocketDisconnect

from agents.platform import Agent, AgentError, Directory, Ending, NameNotValid, Outcome
from agents.platform.errors import in_words
from apps.console.agent_watch import AgentWatch
from apps.console.applications import ApplicationRuns
from apps.console.driving import BASE, DriveCommand, DriveControl
from apps.console.emulator import EmulatorControl
from apps.console.floor import FloorPlan
from apps.console.map_feed import MapFeed
from apps.console.placing import FramePlaces
from apps.console.robots import RobotWatch
from apps.console.settings import ConsoleSettings
from apps.console.sniffer_feed import SnifferFeed
from apps.console.timeline import Timeline
from apps.console.visits import Visit, Visits
from apps.remote_vision.program import RemoteVision
from apps.remote_vision.settings import RemoteVisionSettings
from apps.web.access import Sessions
from bus import BusError, NotAllowed, keys
from bus.aio import query
from bus.keys import Topic
from configs.extras import missing

if TYPE_CHECKING:
    from apps.console.replay import Replay  # of the extra `recorder`

_PATIENCE = 10.0  # s for a request to an agent
_ANSWER = 2.0  # s for a command to a gateway
_CHECK = 0.05  # s between two looks at who drives
_LOOK = 0.25  # s between two looks at sessions and certificates whose time is over: until then a page drives on
_SAMPLE = 0.2  # s between two points of a path
_KNOWN_EVENTS = 200  # of the monitor, from before the console was started


@dataclass(frozen=True, slots=True)
class ConsoleInputs:
    """What the console is told at its start.

    floor: walls, as far as they are known. starts: where robots began, x, y and heading in the frame of the floor, by
    name: the origins of their frames odom. control: path of the emulator's control socket; empty without one. bus: its
    profile, for applications that are started. folder: where these write. folders: with applications, beside those of
    the product.
    """

    floor: FloorPlan = field(default_factory=FloorPlan)
    starts: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    control: str = ""
    bus: str = ""
    folder: str = "."
    folders: Sequence[Path] = ()


class Console:
    """The program behind the pages, for the time of a block.

    agent: asks all other agents. settings: of the application. inputs: of its start. look_only: why nothing
    can be commanded, in words; empty if the role on the bus permits it. replay: the recording that is shown; None for a
    live team. sessions: of those who have given the password; None where none is asked for. robots: the robots.
    timeline: the events. directory: the names of the agents. agents: their containers and states. sniffer: what they
    send each other. map: the map. vision: the cameras and their heads. can_aim: whether what aims a camera by its image
    is installed. emulator: the emulator; None without one. applications: those that run. visits: the pages that are
    open.
    """

    def __init__(
        self,
        agent: Agent,
        settings: ConsoleSettings,
        inputs: ConsoleInputs,
        look_only: str = "",
        replay: "Replay | None" = None,
        sessions: Sessions | None = None,
    ) -> None:
        self.agent, self.settings, self.inputs = agent, settings, inputs
        self.look_only, self.replay, self.sessions = look_only, replay, sessions
        self._timeline = Timeline(agent.home.wall_time)
        self.can_aim = not missing("vision")
        self.emulator = EmulatorControl(inputs.control) if inputs.control else None
        self.applications = ApplicationRuns(inputs.bus, inputs.folder, inputs.folders)
        self.visits = Visits(self._release_all_of, look_only)
        self._drives: dict[str, DriveControl] = {}
        self._open = AsyncExitStack()

    async def __aenter__(self) -> Self:
        bus = self.agent.bus
        if self.replay is None:
            self.robots = self._open.enter_context(RobotWatch(bus, self._timeline.tell))
        else:  # its events are read from the file
            self.robots = self._open.enter_context(RobotWatch(bus, lambda kind, about, what: None, self.replay.now))
        self.directory = self._open.enter_context(Directory(bus))
        self.agents = self._open.enter_context(AgentWatch(bus, self.directory))
        self.sniffer = SnifferFeed(bus)
        if self.replay is None:
            self.agent.listen("*/agents/monitor/results", self._hear_monitor, keep=64)
            self.agent.listen("*/navigation/user_interface/send/LogMessage", self._hear_mission, keep=64, keyed=True)
        self.vision = await self._open.enter_async_context(RemoteVision(self.agent, RemoteVisionSettings.load()))
        self.map = MapFeed(
            self.agent,
            self.robots,
            self.directory,
            self.inputs.floor,
            FramePlaces(self.inputs.starts, self.inputs.floor.map_file),
            self.emulator,
            self.settings.map,
            self.may_command,
            self.replay.missions if self.replay is not None else None,
        )
        tasks = [self._watch_drivers(), self._sample(), self.map.run()]
        tasks += [self._recall()] if self.replay is None else [self.replay.run(), self._begin_replay(self.replay)]
        # no behaviours of the agent: that can be suspended and stopped, and pages must end all the same
        tasks.append(self._again(_LOOK, self.visits.end_expired))
        if self.sessions is not None:
            self.sessions.on_end = self.visits.end_session
            tasks.append(self._again(_LOOK, self.sessions.end_old))
        self._tasks = [asyncio.ensure_future(each) for each in tasks]
        return self

    async def __aexit__(self, *error: object) -> None:
        for task in self._tasks:
            task.cancel()
        # one that fails keeps no other from stopping
        await asyncio.gather(*(drive.close() for drive in self._drives.values()), return_exceptions=True)
        await self.applications.close()
        await self._open.aclose()

    @property
    def may_command(self) -> bool:
        """Whether robots and agents can be commanded."""
        return not self.look_only

    @property
    def timeline(self) -> Timeline:
        """The events: of now, or those of the recording that is shown."""
        return self._timeline if self.replay is None else self.replay.timeline

    # Pages.

    def say(self, visit: Visit, words: str) -> None:
        """Show a page what has happened."""
        visit.tell(time.strftime("%H:%M:%S"), words)

    # Commands.

    def drive_of(self, robot: str) -> DriveControl:
        """Return the control of a robot's wheels."""
        if robot not in self._drives:
            self._drives[robot] = DriveControl(self.agent, robot, self.settings.drive, self.say)
        return self._drives[robot]

    async def serve_driver(self, browser: WebSocket, ticket: str) -> None:
        """Take the commands of one page until its browser is gone."""
        await browser.accept()
        visit = self.visits.get(ticket)
        if visit is None:
            await browser.close(4001, "this page is not known; load it again")
            return
        visit.sockets += 1
        try:
            while visit.ticket in self.visits:
                await browser.send_text(json.dumps(self._drive_reply(visit)))
                command = _command_of(await browser.receive_text())
                if command is not None and visit.robot and visit.ticket in self.visits:
                    self._take_command(visit, command)
            await browser.close(4001, "the session has ended")
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it was closed while a reply was made
            return
        finally:
            visit.sockets -= 1
            if not visit.sockets:
                await self._release_all_of(visit, "the page was closed, or its connection was lost")

    async def stop_all(self, look_only: str = "") -> dict[str, str]:
        """Stop all robots by their latched emergency stops; return what each of them answers, `stopped` or a reason.

        It needs no lease. Robots that have left the bus are not asked; see `away`.

        Args:
            look_only: Why the browser that asks may command nothing; empty if it may.
        """
        robots = [robot.name for robot in self.robots.robots.values() if robot.is_there]
        if look_only:
            return dict.fromkeys(robots, look_only)
        for drive in self._drives.values():
            drive.latch()
        replies = await asyncio.gather(*(self.command(robot, keys.ESTOP, on=True) for robot in robots))
        told = {robot: why or "stopped" for robot, why in zip(robots, replies, strict=True)}
        failed = {robot: why for robot, why in told.items() if why != "stopped"}
        words = f"all {len(robots)} robots stopped" if not failed else f"not stopped: {failed}"
        self.timeline.tell("e-stop", "console", words if robots else "no robot is there to stop")
        return told

    @property
    def away(self) -> list[str]:
        """Robots that have been on the bus and are not any more, so that nothing reaches them."""
        return sorted(robot.name for robot in self.robots.robots.values() if not robot.is_there)

    async def release_stop(self, robot: str) -> str:
        """Release a robot's emergency stop and switch its motors on; return why that failed, empty if it did not."""
        return await self.command(robot, keys.ESTOP, on=False) or await self.enable(robot, on=True)

    async def enable(self, robot: str, *, on: bool) -> str:
        """Switch a robot's motors, though a page drives it; return why that failed, empty if it did not."""
        drive = self._drives.get(robot)
        token = drive.token(BASE) if drive is not None else ""
        return await self.command(robot, keys.ENABLE, on=on, **({"token": token} if token else {}))

    async def command(self, robot: str, topic: Topic, **arguments: Any) -> str:
        """Send a command to a robot's gateway; return why it was not carried out, empty if it was."""
        try:
            await query(self.agent.bus, topic.key(robot), arguments, _ANSWER)
        except TimeoutError:
            return f"the gateway of {robot} has not answered within {_ANSWER:g} s"
        except BusError as err:
            return in_words(err)
        return ""

    async def ask(self, agent: str, request: str, *, within: float = _PATIENCE, **arguments: Any) -> Outcome:
        """Have an agent do something; what prevents the request is an outcome as well."""
        try:
            return await self.agent.request(agent, request, reply_within=within, **arguments)
        except (AgentError, BusError, NameNotValid) as err:  # too large for a message, or a bus that is closed
            return Outcome(Ending.FAILED, why=in_words(err))

    def begin_motion(self, visit: Visit, element: str, request: str, **arguments: Any) -> None:
        """Have an agent of the page's robot move something; the page is told the end.

        The motion ends when the page is gone, since its request is cancelled, and with this program, since the agent
        watches its heartbeat.
        """
        if not self.is_driver(visit):
            self.say(visit, f"{element} was not moved: take control first")
            return
        if token := self.drive_of(visit.robot).token(element):
            arguments["token"] = token

        async def follow() -> None:
            outcome = await self.ask(f"{element}@{visit.robot}", request, within=60.0, **arguments)
            words = "done" if outcome.is_done else f"{outcome.ending}: {outcome.why}"
            self.say(visit, f"{element} {request}: {words}")

        motion = asyncio.ensure_future(follow())
        visit.motions.add(motion)
        motion.add_done_callback(visit.motions.discard)

    def is_driver(self, visit: Visit) -> bool:
        """Return whether a page has control of its robot, and its browser is heard."""
        drive = self._drives.get(visit.robot)
        return drive is not None and drive.holder is visit and not drive.is_latched

    def why_not(self, visit: Visit, topic: Topic, robots: Iterable[str] | None = None) -> str:
        """Return why a page may not send a command; empty if it may."""
        for robot in robots if robots is not None else self.robots.names:
            try:
                self.agent.bus.check_may_query(topic.key(robot))
            except NotAllowed as err:
                return str(err)
        return visit.look_only

    # What goes on by itself.

    def _take_command(self, visit: Visit, command: DriveCommand) -> None:
        drive = self._drives.get(visit.robot)
        if drive is not None and drive.holder is visit:
            drive.drive(visit, command, asyncio.get_running_loop().time())

    def _drive_reply(self, visit: Visit) -> dict[str, Any]:
        drive = self._drives.get(visit.robot)
        mine = drive is not None and drive.holder is visit
        return {
            "tick": asyncio.get_running_loop().time(),
            "mine": mine,
            "latched": bool(mine and drive is not None and drive.is_latched),
        }

    async def _release_all_of(self, visit: Visit, why: str) -> None:
        for drive in self._drives.values():
            if drive.holder is visit:
                await drive.release(why)

    async def _watch_drivers(self) -> None:
        """Look after the drivers, again and again. An error ends one look, and never the watch."""
        loop = asyncio.get_running_loop()

        async def check() -> None:
            for drive in self._drives.values():
                robot = self.robots.robots.get(drive.robot)
                if robot is not None and robot.is_stopped:
                    drive.latch()
            await asyncio.gather(*(drive.check(loop.time()) for drive in self._drives.values()))

        await self._again(_CHECK, check)

    async def _sample(self) -> None:
        async def sample() -> None:
            self.robots.sample_paths()

        await self._again(_SAMPLE, sample)

    async def _again(self, period: float, action: Callable[[], Any]) -> None:
        while True:
            await asyncio.sleep(period)
            try:
                await action()
            except Exception as err:  # whatever it is, the next look must come
                self.agent.home.report(self.agent.name, "a periodic task of the console", err)

    async def seek(self, elapsed: float) -> None:
        """Go to a position of the recording that is shown, s since its first message."""
        if (replay := self.replay) is None:
            return
        await replay.seek(elapsed)
        if replay.history is not None:
            self.robots.replace_paths(replay.history.paths_until(round(replay.now() * 1e9)))

    async def _begin_replay(self, replay: "Replay") -> None:
        """Show the beginning and play; meanwhile read what happens in the whole recording."""
        await self.seek(0.0)
        replay.play()
        await replay.read_history()

    async def _recall(self) -> None:
        """Read what a monitor has noted before the console was started."""
        begun = self.agent.home.wall_time()
        for description in await self.directory.search(service="monitoring"):
            outcome = await self.ask(str(description.name), "events", last=_KNOWN_EVENTS)
            for event in outcome.result if outcome.is_done and isinstance(outcome.result, list) else []:
                if isinstance(event, Mapping) and event.get("time", begun) < begun:
                    self.timeline.hear_monitor(event)

    async def _hear_monitor(self, event: Any) -> None:
        if isinstance(event, Mapping):
            self.timeline.hear_monitor(event)

    async def _hear_mission(self, key: str, message: Any) -> None:
        if isinstance(message, Mapping):
            self.timeline.hear_mission(keys.split(key)[0], message)


def _command_of(text: str) -> DriveCommand | None:
    try:
        return DriveCommand.from_json(json.loads(text))
    except (ValueError, RecursionError):  # None says that it is no command
        return None

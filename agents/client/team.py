"""The team: all robots on a bus, for sequential programs."""

import asyncio
import atexit
import threading
import uuid
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Self, SupportsFloat

from agents.client.complaints import complain_in_a_sentence
from agents.client.discovery import Discovery
from agents.client.element import PATIENCE, ElementClient
from agents.client.errors import RobotError, Stopped, check_seconds
from agents.client.holding import ProgramLease
from agents.client.loop_thread import LAST_WORDS, LoopThread
from agents.client.robot import Robot
from agents.platform import Agent, AgentError, AgentName, Container, NameNotValid, UnknownAgent
from bus import Bus, BusError, NotAllowed, ZenohBus
from bus.bus import Closeable
from bus.keys import robot_name
from configs.defaults import default_bus
from configs.loader import ConfigError

PLATFORM = "apps"  # where agents live that belong to no robot
OPENING_TIME = 15.0  # s; only a machine that does nothing else needs so long


class Team(Closeable):
    """All robots on a bus.

        with Team() as team:
            robot = team.robot("happy")
            robot.base.move(1.0)

    At the end of the block, and in any case at the end of the program, its motions are stopped and its leases are
    released. All errors are `RobotError`.
    """

    def __init__(self, bus: Bus | str | None = None) -> None:
        """Join a bus.

        Args:
            bus: A profile as for `acromovi --bus`, or an open bus. None for the default.
        Raises:
            RobotError: It cannot be reached.
        """
        complain_in_a_sentence()
        own_container = _PrivateContainer(bus or default_bus())
        self._own_container: _PrivateContainer | None = own_container
        self._begin(own_container.loop_thread, own_container.loop_thread.call(_discover(own_container.loop_thread)))
        atexit.register(self.close)

    @classmethod
    def of(cls, thread: LoopThread, discovery: Discovery) -> Self:
        """Return a team for a program whose agent is in another container."""
        team = cls.__new__(cls)
        team._own_container = None
        team._begin(thread, discovery)
        return team

    @property
    def platform(self) -> str:
        """The platform of this program's agents: `apps`, or the owner of the key on a secure bus."""
        return self._thread.agent.name.platform

    def robots(self, having: str | tuple[str, ...] = ()) -> list[Robot]:
        """Return all robots, or those that have an element, or several, in alphabetical order."""
        return [self._robot(name) for name in self._thread.call(self._discovery.robots(_tuple(having)))]

    def robot(self, name: str = "", having: str | tuple[str, ...] = (), within: float | None = None) -> Robot:
        """Return one robot; wait for a robot that is starting or restarting.

        Args:
            name: Its name; without one, the first with these elements.
            having: An element that it must have, or several.
            within: s to wait for it. By default 3 s, and 20 s from its disappearance for a robot that was there.
        Raises:
            NotThere: It is not present; the message names the robots that are.
        """
        if not isinstance(name, str):
            raise RobotError(f"a robot's name is a text, not {name!r}")
        if within is not None:
            check_seconds("within", within)
        if not name:
            return self._robot(self._thread.call(self._discovery.any_robot(_tuple(having), within)))
        try:
            robot_name(name)
        except BusError as err:
            raise RobotError(str(err)) from err
        self._thread.call(self._discovery.robot(name, _tuple(having), within))
        return self._robot(name)

    def ask(self, agent: str, request: str, /, *, within: float = PATIENCE, **arguments: Any) -> Any:
        """Request something from any agent on the bus, and wait for the end: `team.ask("wander@apps", "state")`.

        Args:
            agent: Its name.
            request: What to do; `acromovi directory` lists the requests.
            within: s to wait.
            arguments: JSON values by name.
        Returns:
            The agent's result, made of JSON; objects whose keys are all whole numbers have these as `int`.
        Raises:
            RobotError: It was not done; the class tells why.
        """
        try:
            peer = AgentName.parse(agent)
        except NameNotValid as err:
            raise RobotError(str(err)) from err
        return ElementClient(self._thread, peer).ask(request, within=within, **arguments)

    @contextmanager
    def lease(self, name: str, priority: int = 0, seconds: float = 3.0, notice: float = 0.5) -> Iterator[ProgramLease]:
        """Hold a name during a block, which no other program holds meanwhile: `with team.lease("doorway"):`.

        For things that are no part of a robot and that programs must not use at the same time: a doorway, a task. The
        team's arbiter grants it; a program that does not take the lease is not hindered. For a part of a robot there
        is `robot.base.lease()`.

        Args:
            name: A name that the programs agree upon.
            priority: A holder of a lower one loses the lease.
            seconds: How long the lease lasts at most after this program has died or frozen.
            notice: s until the present holder loses it.
        Raises:
            Refused: Another program holds it, there is no arbiter, or the name is not valid; the message says which.
        """
        from agents.services.leases import NAMED  # late: few programs lease names

        lease = ProgramLease(self._thread, f"{NAMED}{name}")
        lease.take(priority, seconds, notice)
        try:
            yield lease
        finally:
            lease.release()

    @contextmanager
    def host(self, agent: Agent) -> Iterator[None]:
        """Run an agent of this program during a block, in the container of the program's own.

        For what a program cannot do with a `Team`: to hear streams, and to follow several conversations at a time. The
        agent ends with the block, and is frozen when the program is.

        Raises:
            RobotError: It cannot be started; its name may be taken.
        """
        container = self._thread.agent.home
        assert isinstance(container, Container)
        self._thread.moving[agent.name] = lambda: _stopped(container, agent)  # however the program ends
        try:
            if not self._thread.call(container.start(agent)):
                raise RobotError(f"the agent {agent.name} cannot be started; its container reports the reason")
            yield
        finally:
            if self._thread.moving.pop(agent.name, None) is not None:
                self._thread.last(_stopped(container, agent))

    def sleep(self, seconds: float) -> None:
        """Wait for so many s; what drives goes on driving.

        Raises:
            RobotError: It is not a number.
        """
        if not isinstance(seconds, SupportsFloat):
            raise RobotError(f"sleep takes a time in s, not {seconds!r}")
        self._thread.call(asyncio.sleep(seconds), attends=True)

    def every(self, period: float) -> Iterator[float]:
        """Yield every `period` seconds the s since the first time; missed times are skipped.

        The loop ends when the program is to end, and waits while it is suspended.

        Raises:
            RobotError: The period is not valid.
        """
        if not period > 0.0:
            raise RobotError(f"every takes a period of more than 0 s, not {period!r}")
        clock = self._thread.loop.time
        start, beat = clock(), 0
        while True:
            try:
                self.sleep(start + beat * period - clock())
            except Stopped:  # the program is to end, and so are its beats
                return
            yield clock() - start
            beat = max(beat + 1, int((clock() - start) / period))

    def close(self) -> None:
        """Stop its motions, release its leases, and leave the bus. Closing it twice has no effect."""
        own_container, self._own_container = self._own_container, None
        if own_container is None:
            return
        atexit.unregister(self.close)
        try:
            self._thread.last(self._thread.halt())
        finally:
            self._discovery.close()
            own_container.close()

    def _begin(self, thread: LoopThread, discovery: Discovery) -> None:
        self._thread = thread
        self._discovery = discovery
        self._robots: dict[str, Robot] = {}

    def _robot(self, name: str) -> Robot:
        return self._robots.setdefault(name, Robot(self._thread, self._discovery, name))


class _PrivateContainer:
    """The container of a plain script, on an event loop in a daemon thread, which ends with the program.

    loop_thread: runs the calls of the script by its agent `app-1f3a@apps`; on a secure bus `app-1f3a@anna`, after the
        owner of the key.
    """

    def __init__(self, bus: Bus | str) -> None:
        """Start the thread and the agent.

        Args:
            bus: A profile to open, or a bus that stays open afterwards.
        Raises:
            RobotError: The bus cannot be reached, or allows no program on it.
        """
        if not isinstance(bus, Bus | str):
            raise RobotError(f"a bus is a profile such as 'local', or an open bus, not {bus!r}")
        home = _opened(bus) if isinstance(bus, str) else bus
        self._own_bus = home if isinstance(bus, str) else None
        name = f"app-{uuid.uuid4().hex[:8]}"
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()
        self._container = Container(home, name)
        agent = Agent(AgentName(name, home.own_name or PLATFORM))
        self.loop_thread = LoopThread(agent, self._loop)
        try:
            self._join(agent)
        except (BusError, AgentError, TimeoutError) as err:
            self.close()
            why = str(err) or f"nothing has happened there for {OPENING_TIME:g} s"
            raise RobotError(f"the bus cannot be joined: {why}") from err

    def close(self) -> None:
        """End the agent, the thread and the bus."""
        with suppress(BusError, TimeoutError):  # it is left in any case
            self._run(self._end(), LAST_WORDS)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LAST_WORDS)
        if not self._thread.is_alive():
            self._loop.close()
        if self._own_bus is not None:
            self._own_bus.close()

    async def _end(self) -> None:
        """Close the container, and leave nothing in the loop: Ctrl-C may have come before a call was waited for."""
        try:
            await self._container.close()
        finally:
            left = asyncio.all_tasks() - {asyncio.current_task()}
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)  # each ends as cancelled

    def _join(self, agent: Agent) -> None:
        try:
            self._run(self._container.start(agent), OPENING_TIME)
        except NotAllowed:  # who may only look needs no agent that others see
            self._run(agent.look_on(self._container), OPENING_TIME)
            self.loop_thread.only_looks = True

    def _run(self, work: Coroutine[Any, Any, Any], within: float) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(within)


def _tuple(names: str | tuple[str, ...]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names


async def _stopped(container: Container, agent: Agent) -> None:
    """Stop an agent, unless it has ended."""
    with suppress(UnknownAgent):  # it has ended by itself
        await container.stop(agent.name)


async def _discover(thread: LoopThread) -> Discovery:
    """Start discovery in the event loop of a program's agent."""
    return Discovery(thread.agent.bus)


def _opened(profile: str) -> Bus:
    try:
        return ZenohBus.open(profile)
    except (BusError, ConfigError) as err:
        raise RobotError(str(err)) from err

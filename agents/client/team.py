"""The team: all robots on a bus, for sequential programs."""

import asyncio
import atexit
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self, SupportsFloat

from agents.client.complaints import complain_in_a_sentence
from agents.client.discovery import Discovery
from agents.client.element import PATIENCE, numbered, plain
from agents.client.errors import RobotError, Stopped, check_seconds, error_of
from agents.client.holding import ProgramLease
from agents.client.loop_thread import LoopThread
from agents.client.private_container import PrivateContainer
from agents.client.robot import Robot
from agents.platform import AgentName, NameNotValid
from bus import Bus, BusError
from bus.keys import robot_name
from configs.defaults import default_bus


class Team:
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
        own_container = PrivateContainer(bus or default_bus())
        self._own_container: PrivateContainer | None = own_container
        self._begin(own_container.loop_thread, own_container.loop_thread.call(look(own_container.loop_thread)))
        atexit.register(self.close)

    @classmethod
    def of(cls, thread: LoopThread, discovery: Discovery) -> Self:
        """Return a team for a program whose agent is in another container."""
        team = cls.__new__(cls)
        team._own_container = None
        team._begin(thread, discovery)
        return team

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
        check_seconds("within", within)
        given = {name: plain(value) for name, value in arguments.items()}
        outcome = self._thread.call(self._thread.agent.request(peer, request, reply_within=within, **given))
        if not outcome.is_done:
            raise error_of(outcome, agent, request)
        return numbered(outcome.result)

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

    def sleep(self, seconds: float) -> None:
        """Wait for so many s; what drives goes on driving.

        Raises:
            RobotError: It is not a number.
        """
        if not isinstance(seconds, SupportsFloat):
            raise RobotError(f"sleep takes a time in s, not {seconds!r}")
        self._thread.call(asyncio.sleep(seconds))

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
            except Stopped:
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

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _begin(self, thread: LoopThread, discovery: Discovery) -> None:
        self._thread = thread
        self._discovery = discovery
        self._robots: dict[str, Robot] = {}

    def _robot(self, name: str) -> Robot:
        return self._robots.setdefault(name, Robot(self._thread, self._discovery, name))


def _tuple(names: str | tuple[str, ...]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names


async def look(thread: LoopThread) -> Discovery:
    """Start discovery in the event loop of a program's agent."""
    return Discovery(thread.agent.bus)

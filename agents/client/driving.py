"""Driving on and on at one velocity: a stream of it, while the program is at work."""

import asyncio
import contextlib
from math import inf

import bus
from agents.client.errors import Failed, NotThere, RequestRefused, RobotError
from agents.client.holding import ProgramLease
from agents.client.loop_thread import LoopThread
from agents.client.wording import in_api_words
from agents.platform.errors import in_words
from bus import MessageError, Publisher, Sample, Subscription, keys, messages
from bus.aio import hand_over

LASTS = 0.5
"""Seconds from the first stall flag on, after which another one counts: a robot that only starts hard shows it once."""
APART = 2.0
"""Seconds between flags of one stall; the firmware takes the power off for a while and tries again."""


class Stall:
    """Of one robot, while it is driven in one direction. No clock: `now` is any steady time, s."""

    def __init__(self) -> None:
        self._first = self._last = -inf

    def hear(self, is_stalled: bool, now: float) -> bool:
        """Take the flags of both wheels, as one; return whether the robot is stalled for good."""
        if not is_stalled:
            return False
        if now - self._last > APART:
            self._first = now
        self._last = now
        return now - self._first >= LASTS


PERIOD = 0.1  # s; half a second of silence stops the robot
ANSWER_TIME = 2.0  # s for the gateway
SILENCE = 0.6  # s after a stop until the gateway obeys a stream again


class ContinuousDrive:
    """One robot that is driven so. All of it belongs to the event loop of the `LoopThread`."""

    def __init__(self, thread: LoopThread, robot: str) -> None:
        self._thread = thread
        self._robot = robot
        self._velocity = (0.0, 0.0)
        self._token = ""
        self._lease: ProgramLease | None = None
        self._task: asyncio.Task[None] | None = None
        self._obeyed_from = 0.0
        self._stall = Stall()
        self._stalled: tuple[float, float] | None = None  # the velocity at which it did, until that has been told

    async def go(self, linear: float, angular: float, lease: ProgramLease | None) -> None:
        """Drive so from now on, or until the lease is lost: m/s, rad/s.

        Raises:
            Failed: The robot has stalled since the last call, has been stopped, and is to go on in the same direction.
            LeaseLost: It is lost already, or about to be.
            Refused: The robot may not, or cannot; says why. It comes to rest, if it was driven by this.
            NotThere: Nobody drives it.
        """
        stalled, self._stalled = self._stalled, None
        if stalled is not None and _pushes_on(stalled, (linear, angular)):
            raise Failed(
                f"{self._robot} is stalled and was stopped: something blocks it at {stalled[0]:g} m/s, "
                f"{stalled[1]:g} rad/s; drive another way"
            )
        if not self._is_streaming:
            await asyncio.sleep(self._obeyed_from - self._thread.loop.time())
        try:
            token = lease.token if lease is not None else ""
            await self._ask(linear, angular, token)
        except RobotError:
            await self.end()
            raise
        if not self._is_streaming or not _pushes_on(self._velocity, (linear, angular)):
            self._stall = Stall()
        self._velocity, self._token, self._lease = (linear, angular), token, lease
        if not self._is_streaming:
            self._task = asyncio.ensure_future(self._stream())

    async def end(self) -> None:
        """Drive no more; the robot comes to rest."""
        self._stalled = None
        task, self._task = self._task, None
        if task is None or task.done():
            return
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):  # it was cancelled just now, as it is meant to be
            await task
        halt = messages.twist(0.0, 0.0)  # the stream may not have begun, and the robot drives as it was asked to
        self._thread.agent.bus.send(keys.CMD_VEL.key(self._robot), halt, self._token.encode())

    def has_stopped(self) -> None:
        """The robot has been told to stop, and will obey no stream until that has been silent for a while."""
        self._obeyed_from = self._thread.loop.time() + SILENCE

    @property
    def _is_streaming(self) -> bool:
        return self._task is not None and not self._task.done()

    async def _ask(self, linear: float, angular: float, token: str) -> None:
        """The first velocity is asked for, since a stream is not answered."""
        given = {"linear": linear, "angular": angular, **({"token": token} if token else {})}
        try:
            await self._thread.agent.query(keys.DRIVE.key(self._robot), given, ANSWER_TIME)
        except bus.Refused as err:
            raise RequestRefused(f"{self._robot} refuses to drive: {in_api_words(in_words(err), 'base')}") from err
        except TimeoutError as err:
            raise NotThere(f"nobody drives {self._robot}; see whether its p2os-gateway runs") from err

    async def _stream(self) -> None:
        publisher = self._thread.agent.bus.publisher(keys.CMD_VEL.key(self._robot), keys.CMD_VEL.type_name)
        with publisher as wheels, self._listen():
            while self._is_to_go_on:
                self._say(wheels, *self._velocity)
                await asyncio.sleep(PERIOD)
            self._say(wheels, 0.0, 0.0)

    @property
    def _is_to_go_on(self) -> bool:
        is_ours = self._lease is None or self._lease.is_held
        return self._thread.is_attended and is_ours and self._stalled is None

    def _listen(self) -> Subscription:
        """Hear the stall flags of the wheels."""
        key = keys.BUMPERS.key(self._robot)
        return self._thread.agent.bus.subscribe(key, self._take_flags, urgent=True)

    def _take_flags(self, sample: Sample) -> None:
        with contextlib.suppress(MessageError):  # the next one will be better
            flags = messages.decode(keys.BUMPERS.type_name, sample.payload)
            hand_over(self._thread.loop, self._hear_flags, bool(flags.stall_left or flags.stall_right))

    def _hear_flags(self, is_stalled: bool) -> None:
        is_driven = self._is_streaming and self._velocity != (0.0, 0.0)
        if is_driven and self._stall.hear(is_stalled, self._thread.loop.time()):
            self._stalled = self._velocity

    def _say(self, wheels: Publisher, linear: float, angular: float) -> None:
        wheels.put(messages.twist(linear, angular), self._token.encode())


def _pushes_on(before: tuple[float, float], now: tuple[float, float]) -> bool:
    """Whether a velocity, m/s and rad/s, goes the same way as one before: along, or round where it only turns."""
    if before[0] or now[0]:
        return before[0] * now[0] > 0.0
    return before[1] * now[1] > 0.0

"""Motions of the base: motions of the gateway, and steering on the odometry.

Steering publishes velocities at the rate of the odometry. Every half second a velocity is sent as a query instead,
since a stream has no refusals.
"""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from math import inf
from typing import Any, ClassVar, NoReturn

from agents.components.component import ElementAgent, failure, known
from agents.components.moving_request import OneAtATime
from agents.components.pose_control import Headway, PoseControlLimits, Velocity
from agents.components.troubles import Troubles
from agents.platform import AgentName, asker, on
from bus import Refused, keys
from bus.keys import Topic
from bus.messages import RobotState, heading, twist
from geometry import Pose2D

REPEAT = 0.2  # s; the gateway stops a robot whose stream of velocities has been silent for half a second
ASK_AGAIN = 0.5  # s between two velocities that are sent as queries
STANDING = PoseControlLimits(0.01, 0.02)  # m/s and rad/s, below which it stands
FOLLOWED = 1.0  # s for which poses are still decoded after the last one that a motion waited for
BLIND = 1.0  # s for which a robot is steered without odometry
TIME_TO_REST = 2.0  # s
MOST_TO_START = 0.8  # s until a robot moves after the command, also with a radio modem
NEWS_TIME = 0.1  # s within which the reason of a stop is known
UNBOUND = 5.0  # s of steering for an initiator without a heartbeat
HOLD = 0.55  # s after a stop in which the gateway ignores streams of velocities
MOST_ENDS = 16  # ends of motions that are kept


class Wheels(ElementAgent):
    """The part of the base's agent that moves it; `BaseAgent` has the requests."""

    source = keys.ODOM
    results: ClassVar[Mapping[str, str]] = {
        "x": "m in odom",
        "y": "m in odom",
        "heading": "rad in odom, counter-clockwise",
        "linear": "m/s forward",
        "angular": "rad/s counter-clockwise",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._troubles = Troubles("base")
        self._ends: dict[str, dict[str, Any]] = {}  # of motions, by their ids
        self._held_until = -inf  # s of the loop's time; until then a stop holds the robot
        self._followed_until = -inf  # s of the loop's time; until then every pose is news
        self._news = asyncio.Event()  # a pose, or the end of a motion, has come

    async def setup(self) -> None:
        """Subscribe to the odometry."""
        self.moving = OneAtATime(self.bus, self._halt, self.stop_robot)
        await super().setup()

    @property
    def is_eager(self) -> bool:
        """Whether a motion follows the poses."""
        assert self._loop is not None
        return self._loop.time() < self._followed_until

    def result(self, message: Any) -> dict[str, Any]:
        """Return pose and speed of an odometry message."""
        pose, speed = message.pose.pose, message.twist.twist
        return {
            "x": known(pose.position.x),
            "y": known(pose.position.y),
            "heading": known(heading(pose.orientation)),
            "linear": known(speed.linear.x),
            "angular": known(speed.angular.z),
        }

    def renew(self, result: Mapping[str, Any]) -> None:
        """Take a new pose."""
        super().renew(result)
        self._news.set()

    @on("command/result/*", keep=MOST_ENDS)
    async def _hear_end(self, end: dict[str, Any]) -> None:
        self._ends[str(end.get("id"))] = end
        while len(self._ends) > MOST_ENDS:
            del self._ends[next(iter(self._ends))]
        self._news.set()

    @on("state")
    async def _hear_state(self, state: RobotState) -> None:
        self._troubles.hear_faults(state.faults, self._now)

    @on("lease/state")
    async def _hear_lease(self, lease: dict[str, Any]) -> None:
        self._troubles.hear_lease(lease, self._now)

    @property
    def pose(self) -> Pose2D:
        """The pose of the robot in odom.

        Raises:
            Refused: It is not known.
        """
        match self.latest():
            case {"x": float(x), "y": float(y), "heading": float(heading)}:
                return Pose2D(x, y, heading)
        raise failure(f"{self.robot} has lost count of where it is")

    async def travel(self, topic: Topic, within: float, token: str, **arguments: float) -> dict[str, Any]:
        """Have the gateway carry out a motion; return the pose at its end.

        Args:
            topic: The command.
            within: s, longer than the timeout of the gateway.
            token: The token of a lease, or empty.
            arguments: Those of the command.
        Raises:
            Refused: It has not begun, or did not reach its goal.
        """

        async def follow(begun: Mapping[str, Any]) -> None:
            motion_id = str(begun["id"])
            try:
                await self._end_of(motion_id, within)
            except Refused:
                self._halt(token)
                raise
            await self._judge(self._ends.pop(motion_id))

        with self.commanding_motion() as heartbeat:
            self._ends.clear()  # a gateway that has been restarted uses the same ids again
            begin = partial(self.command, topic, **arguments, token=token, heartbeat=heartbeat)
            await self.moving.run(topic.suffix.rpartition("/")[2], token, begin, follow)
        return self.latest()

    async def steer(
        self,
        what: str,
        choose: Callable[[Pose2D], Velocity],
        within: float,
        token: str,
        late: str = "not there in time",
    ) -> dict[str, Any]:
        """Steer until the goal is reached; return the pose at the end.

        Args:
            what: The name of the motion, a word.
            choose: Returns the velocity for a pose.
            within: s that it may take.
            token: The token of a lease, or empty.
            late: The error when it takes longer; empty if that is the regular end.
        Raises:
            Refused: It has not begun, or has failed.
        """
        delay = max(0.0, self._held_until - self._now)

        async def begin() -> None:
            await self._ask_for(choose(self.pose), token)

        async def follow(begun: None) -> None:
            try:
                failed = await self._steer_on(choose, ends_at, token, late)
            except Refused:
                self._halt(token)
                raise
            self._halt(token)
            if failed:
                await self._give_up(failed)
            await self.come_to_rest()

        with self.commanding_motion() as heartbeat:
            if heartbeat is None and within > UNBOUND:
                within, late = UNBOUND, f"{what} was ended after {UNBOUND:g} s, since {asker()} has no heartbeat"
            ends_at = self._now + delay + within
            await self.moving.run(what, token, begin, follow, delay)
        return self.latest()

    async def come_to_rest(self) -> None:
        """Wait until the robot stands, or should stand."""
        until = self._now + TIME_TO_REST
        await self._next(REPEAT)  # the latest pose may still show it standing, or rolling
        while self._now < until and self._rolls:
            await self._next(REPEAT)

    async def stop_robot(self) -> None:
        """Stop the whole robot; afterwards the gateway ignores streams of velocities for a while.

        Raises:
            Refused: The gateway refuses, or there is none.
        """
        await self.command(keys.STOP)
        self._held_until = self._now + HOLD

    async def _steer_on(self, choose: Callable[[Pose2D], Velocity], ends_at: float, token: str, late: str) -> str:
        """Steer to the end; return the error, or an empty text."""
        asked_at, headway = self._now, Headway(self.pose, self._now)
        while not (velocity := choose(self.pose)).is_done:
            now = self._now
            if now >= ends_at:
                return late or self._not_moved(headway.stands_for(now), velocity)
            if now - self._heard_at >= BLIND:
                return f"no odometry for {now - self._heard_at:.1f} s"
            if headway.is_blocked(self.pose, self._rolls, velocity, now):
                return "blocked"
            if self.moving.is_changing:
                pass  # another request waits for the gateway's answer
            elif now - asked_at >= ASK_AGAIN:
                asked_at = now
                await self._ask_for(velocity, token)
            else:
                self._tell(velocity, token)
            await self._next(min(REPEAT, ends_at - now))
        return ""

    def _not_moved(self, seconds: float, told: Velocity) -> str:
        """Return the error of a robot that has not moved for this time at the end of a motion, or an empty text."""
        is_told = abs(told.linear) > STANDING.linear or abs(told.angular) > STANDING.angular
        return f"{self.robot} has not moved for {seconds:.1f} s" if is_told and seconds >= MOST_TO_START else ""

    async def _ask_for(self, velocity: Velocity, token: str) -> None:
        await self.command(keys.DRIVE, linear=velocity.linear, angular=velocity.angular, token=token)

    def _tell(self, velocity: Velocity, token: str) -> None:
        self.bus.put(keys.CMD_VEL.key(self.robot), twist(velocity.linear, velocity.angular), token.encode())

    def _halt(self, token: str) -> None:
        self.bus.send(keys.CMD_VEL.key(self.robot), twist(0.0, 0.0), token.encode())

    async def _end_of(self, motion_id: str, within: float) -> None:
        """Wait until the gateway has published the end of a motion, while poses come.

        Raises:
            Refused: No pose comes any more, or it takes too long.
        """
        ends_at = self._now + within
        while motion_id not in self._ends:
            if self._now >= ends_at:
                await self._give_up("not there in time")
            await self._next(self.fresh)
            self.latest()

    async def _judge(self, end: Mapping[str, Any]) -> None:
        """Raise unless the motion has reached its goal."""
        done, unit = end.get("done"), end.get("unit", "")
        after = f" after {done:.2f} {unit}".rstrip() if isinstance(done, float) else ""
        match end.get("result"):
            case "reached":
                return
            case "replaced":
                await asyncio.sleep(NEWS_TIME)  # a request that has replaced this one ends it, with its name
                raise Refused(f"another command took its place{after}")
            case "lost":
                raise Refused(f"the connection to {self.robot} was lost{after}")
            case "timeout":
                await self._give_up(f"not there in time{after}")
            case how:
                await self._give_up(str(end.get("text", f"{how}{after}")))

    async def _give_up(self, what: str) -> NoReturn:
        """Raise with the known reasons, which the robot may publish a moment later."""
        await asyncio.sleep(NEWS_TIME)
        reasons = self._troubles.reasons(self._now)
        raise Refused(f"{what}: {reasons}" if reasons else what)

    async def _next(self, within: float) -> None:
        """Wait for a pose or the end of a motion, at most for this time in s."""
        self._news.clear()
        self._followed_until = self._now + within + FOLLOWED
        with suppress(TimeoutError):  # no news is an answer as well
            async with asyncio.timeout(within):
                await self._news.wait()

    @property
    def _rolls(self) -> bool:
        now = self._latest or {"linear": 0.0, "angular": 0.0}
        return bool(abs(now["linear"]) > STANDING.linear or abs(now["angular"]) > STANDING.angular)

    @property
    def _now(self) -> float:
        return asyncio.get_running_loop().time()

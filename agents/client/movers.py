"""The clients of elements that move. The motions of a program stop when the program ends."""

import asyncio
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, Generic

from agents.client.driving import ContinuousDrive
from agents.client.element import PATIENCE, ElementClient, R, plain
from agents.client.errors import RequestTimedOut, RobotError
from agents.client.holding import ProgramLease
from agents.client.loop_thread import LoopThread
from agents.client.readings import ArmReading, BaseReading, GripperReading, PtzReading
from agents.platform import AgentName, Ending, Outcome, Performative
from bus import BusError, keys
from bus.keys import Topic
from geometry import Pose2D

MOTION = 300.0  # s for the longest motion; errors are reported earlier
STOP_TIME = 1.0  # s for the base's agent to obey a stop, and then for the gateway


class _Mover(ElementClient[R], Generic[R]):
    """An element that moves, and can be leased and stopped."""

    def __init__(self, thread: LoopThread, agent: AgentName) -> None:
        super().__init__(thread, agent)
        self._lease: ProgramLease | None = None

    @contextmanager
    def lease(self, priority: int = 0, seconds: float = 3.0, notice: float = 0.5) -> Iterator[ProgramLease]:
        """Hold the sole right to move this element during a block; its motion is stopped at the end of the block.

        Args:
            priority: A holder of a lower one loses the lease.
            seconds: How long the lease lasts at most after this program has died or frozen.
            notice: s until the present holder loses it.
        Raises:
            Refused: Another program holds it; the message says which.
            LeaseLost: In the block, by calls that move the element: a program of a higher priority has taken it, or is
                about to; `wanted_by` names it before.
        """
        before, lease = self._lease, ProgramLease(self._thread, self.agent)
        lease.take(priority, seconds, notice)
        self._lease = lease
        try:
            yield lease
        finally:
            if self in self._thread.moving:
                self._stop_at_once()
            self._lease = before
            lease.release()

    @property
    def _token(self) -> str:
        return self._lease.token if self._lease is not None else ""

    @property
    def _is_anothers(self) -> bool:
        """Whether the lease has been lost, which has stopped the element; its new holder may move it now."""
        return self._lease is not None and not self._lease.is_held

    @property
    def _right(self) -> dict[str, Any]:
        """The arguments of a request to stop."""
        token = self._lease.last_token if self._lease is not None else ""
        return {"token": token} if token else {}

    def stop(self) -> None:
        """Stop."""
        self.ask("stop", **self._right)

    def _move(self, request: str, /, **arguments: Any) -> R:
        """Request a motion, wait for its end, and return the reading then; an interrupted wait stops the motion."""
        if token := self._token:
            arguments["token"] = token
        self._thread.moving[self] = self._halt
        try:
            requested = self._requested(request, MOTION, arguments)
            result = self._result_of(request, self._thread.call(requested, attends=True))
        except RequestTimedOut:
            self._stop_at_once()
            raise
        except RobotError as err:
            self._thread.moving.pop(self, None)  # it has not begun, or has ended
            if self._lease is not None and (loss := self._lease.loss):
                raise loss from err
            raise
        except BaseException:  # Ctrl-C, or the program is to end
            self._stop_at_once()
            raise
        self._thread.moving.pop(self, None)
        return self._read(result)

    def _stop_at_once(self) -> None:
        self._thread.last(self._halt())
        self._thread.moving.pop(self, None)

    async def _halt(self) -> None:
        if not self._is_anothers:
            await self._thread.agent.request(self.agent, "stop", reply_within=1.0, **self._right)


class BaseClient(_Mover[BaseReading]):
    """Wheels and odometry.

    Poses are in the robot's frame `odom`. Its origin is where the robot stood when its gateway first connected, and its
    x axis points to where the robot faced then.
    """

    reading = BaseReading

    def __init__(self, thread: LoopThread, agent: AgentName) -> None:
        super().__init__(thread, agent)
        self._driving = ContinuousDrive(thread, agent.platform)

    def pose(self) -> Pose2D:
        """Return the pose by odometry: m, m, rad."""
        return self.read().pose

    def move(self, distance: float, speed: float | None = None) -> Pose2D:
        """Drive straight by a distance in m, backward if negative; return the pose at the end."""
        self._end_driving()
        return self._move("move", distance=distance, **_given(speed=speed)).pose

    def turn(self, angle: float) -> Pose2D:
        """Turn on the spot by an angle in rad, counter-clockwise; return the pose at the end."""
        self._end_driving()
        return self._move("turn", angle=angle).pose

    def heading(self, heading: float) -> Pose2D:
        """Turn to a heading, rad; return the pose at the end."""
        self._end_driving()
        return self._move("heading", heading=heading).pose

    def go_to(self, x: float, y: float, heading: float | None = None, speed: float | None = None) -> Pose2D:
        """Drive to a position, m and m, and turn to a heading there if one is given; return the pose at the end."""
        self._end_driving()
        return self._move("go_to", x=x, y=y, **_given(heading=heading, speed=speed)).pose

    def drive(self, linear: float, angular: float = 0.0, seconds: float | None = None) -> None:
        """Drive at m/s forward and rad/s counter-clockwise.

        Without `seconds` it returns at once, and the robot drives until the next call that moves it, until `stop`, or
        until the program ends or makes no call for a second. It also stops when a call other than a motion, `sleep` and
        `every`, such as a reading, lasts longer than a second.

        Raises:
            Failed: The robot is stalled. Without `seconds` it was stopped, and the next call to drive the same way
                raises this; a call to drive another way is obeyed.
        """
        if seconds is None:
            self._thread.moving[self] = self._halt
            try:
                self._thread.call(self._driving.go(plain(linear), plain(angular), self._lease), attends=True)
            except RobotError:
                self._thread.moving.pop(self, None)  # it is at rest, or moved by another program
                raise
        else:
            self._end_driving()
            self._move("drive", linear=linear, angular=angular, seconds=seconds)

    def stop(self) -> None:
        """Stop, and return when the robot stands. If its agents do not answer, its gateway stops it."""
        self._end_driving()
        self._order("stop", keys.STOP)
        self._thread.moving.pop(self, None)
        self._driving.has_stopped()

    def enable(self, on: bool = True) -> None:
        """Switch the motors."""
        self._move("enable", on=on)

    def estop(self, on: bool = True) -> None:
        """Stop at once, and block all motions until `estop(False)` and `enable()`."""
        self._order("estop", keys.ESTOP, on=on)

    def _end_driving(self) -> None:
        """End what `drive` without `seconds` has begun."""
        self._thread.call(self._driving.end())

    def _order(self, request: str, topic: Topic, **arguments: Any) -> None:
        """Have the agent obey, or the gateway if the agent does not.

        Raises:
            RobotError: Neither does; the error is that of the agent.
        """
        self._result_of(request, self._thread.call(self._obeyed(request, topic, arguments)))

    async def _obeyed(self, request: str, topic: Topic, arguments: Mapping[str, Any]) -> Outcome:
        conversation = self._thread.agent.initiator.conversation(
            Performative.REQUEST, self.agent, request, arguments, PATIENCE, PATIENCE
        )
        asking = asyncio.ensure_future(conversation.outcome())
        try:
            await asyncio.wait([asking], timeout=STOP_TIME)
            is_obeyed = asking.result().is_done if asking.done() else conversation.agreed
            if not is_obeyed:
                with suppress(BusError, TimeoutError):  # the agent's outcome tells more
                    key = topic.key(self.agent.platform)
                    return Outcome(Ending.DONE, await self._thread.agent.query(key, arguments, STOP_TIME))
            return await asking
        finally:
            asking.cancel()

    async def _halt(self) -> None:
        await self._driving.end()
        if self._is_anothers:
            return
        outcome = await self._thread.agent.request(self.agent, "stop", reply_within=1.0)
        if not outcome.is_done:  # its agent has gone; the gateway may be there
            await self._thread.agent.query(keys.STOP.key(self.agent.platform), timeout=0.5)
        self._driving.has_stopped()


class GripperClient(_Mover[GripperReading]):
    """A gripper: two paddles on a lift. Each motion returns the reading at its end."""

    reading = GripperReading

    def open(self) -> GripperReading:
        """Open the paddles."""
        return self._move("open")

    def close(self) -> GripperReading:
        """Close the paddles, until they hold something or meet; `holds` of the result tells which."""
        return self._move("close")

    def up(self) -> GripperReading:
        """Raise the lift."""
        return self._move("up")

    def down(self) -> GripperReading:
        """Lower the lift."""
        return self._move("down")

    def store(self) -> GripperReading:
        """Close and raise, for driving."""
        return self._move("store")

    def deploy(self) -> GripperReading:
        """Open and lower, for gripping."""
        return self._move("deploy")


class ArmClient(_Mover[ArmReading]):
    """An arm. Each motion returns the reading at its end."""

    reading = ArmReading

    def move(self, joints: Mapping[int, float] | Mapping[str, float], speed: float | None = None) -> ArmReading:
        """Move joints, by number, to angles, rad, at rad/s: `arm.move({1: 0.5})`."""
        return self._move("move", joints=dict(joints), **_given(speed=speed))

    def reach(
        self,
        x: float,
        y: float,
        z: float,
        speed: float | None = None,
        pitch: float | None = None,
        yaw: float | None = None,
    ) -> ArmReading:
        """Bring the tip of the gripper to a point in the robot's frame `base_link`, m, with joints at rad/s.

        x is ahead, y to the left, z above the floor: `arm.reach(0.45, 0.0, 0.3)`. The fingers stay as they are. With
        a pitch, the hand points so many rad below level, and its fingers part level; with a yaw also, so many rad to
        the left of the robot's front, else away from the arm's base. Without a pitch the direction of the hand is free.

        Raises:
            Refused: The point is out of reach, also in this direction, inside the robot or below the floor, or the arm
                would meet one of these on its way; the message says how far the nearest point is.
        """
        return self._move("reach", x=x, y=y, z=z, **_given(speed=speed, pitch=pitch, yaw=yaw))

    def home(self) -> ArmReading:
        """Send every joint home."""
        return self._move("home")

    def park(self) -> ArmReading:
        """Send every joint home, and let it rest there without power."""
        return self._move("park")

    def power(self, on: bool = True) -> ArmReading:
        """Switch its motors."""
        return self._move("power", on=on)


class PtzClient(_Mover[PtzReading]):
    """A pan-tilt-zoom head. Each motion returns the reading at its end."""

    reading = PtzReading

    def look(self, pan: float | None = None, tilt: float | None = None, zoom: float | None = None) -> PtzReading:
        """Turn the head, rad to the left and rad up, and zoom; an argument that is left out stays as it is."""
        return self._move("look", **_given(pan=pan, tilt=tilt, zoom=zoom))

    def centre(self) -> PtzReading:
        """Look straight ahead."""
        return self._move("centre")


def _given(**arguments: float | None) -> dict[str, Any]:
    """Return the arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}

"""Drives one robot on patrol: by missions of its indoor navigation, or along the shortest way on the map."""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import suppress
from math import dist, pi
from typing import Any

from agents.platform import Agent, AgentError, AgentName, Ending, Outcome
from agents.platform.directory import Directory
from apps.surveillance.algorithms.floor import PatrolFloor, is_reached
from apps.surveillance.patrol_senses import PatrolSenses
from apps.surveillance.settings import SurveillanceSettings
from bus import BusError
from geometry import Point, Pose2D

INTERFACE, BASE = "user_interface", "base"
LOOK = 0.25  # s between two looks at pose and goal
_ASK = 1.0  # s between two questions how the mission stands
_REPLY = 5.0  # s for an agent to answer
_LONGEST = 600.0  # s that a robot may be on its way to one place
_ARRIVING = 3.0  # s in which a goal reaches path planning
_LATER = 4.0  # times that a robot waits longer than one that makes way
_BLOCKED = "blocked"  # the beginning of the base's error when its wheels are stalled or it makes no headway
_BACK_OFF, _BACK_SPEED = 0.2, 0.1  # m and m/s of a robot that has run into something that its sensors do not show
_RETRIES = 3  # times that an agent may not answer in a row

Goal = Callable[[], Point | None]
"""Where to drive to now, m in `map`; None to stop."""


class PlaceNotReached(Exception):
    """The robot cannot get to a place; the message says why. is_traffic: another robot may be in the way."""

    def __init__(self, why: str, *, is_traffic: bool = False) -> None:
        super().__init__(why)
        self.is_traffic = is_traffic


class RobotNotAble(Exception):
    """The robot cannot patrol any more: it is lost, or another program drives it; the message says why."""


class RobotLost(RobotNotAble):
    """The robot is not localized; it may be so again in a moment."""


class PatrolDriver:
    """Drives a robot, in the event loop of its agent. A cancelled drive stops the robot."""

    def __init__(
        self,
        agent: Agent,
        directory: Directory,
        senses: PatrolSenses,
        floor: PatrolFloor,
        geometry: Mapping[str, Any],
        settings: SurveillanceSettings,
    ) -> None:
        """Prepare; nothing moves yet.

        Args:
            agent: Of the patrol.
            directory: Which agents there are.
            senses: Readings of the robot.
            floor: Of the map.
            geometry: Of the base: `length_front`, `length_rear` and `width`, m.
            settings: Of the application.
        """
        self._agent, self._directory, self._senses, self._floor = agent, directory, senses, floor
        self._settings = settings
        robot = agent.name.platform
        self._interface, self._base = AgentName(INTERFACE, robot), AgentName(BASE, robot)
        self._front, self._width = float(geometry["length_front"]), float(geometry["width"])
        self._rear = float(geometry["length_rear"])
        self._mission = ""
        self._robot = robot

    @property
    def navigates(self) -> bool:
        """Whether the robot has an indoor navigation that runs."""
        return self._directory.knows(self._interface)

    async def go(self, goal: Goal, tolerance: float) -> None:
        """Drive to a place, and return when the robot is there or the goal is None.

        A goal that moves by more than `replan_m` is followed.

        Args:
            goal: Where.
            tolerance: m from it that count as reached.
        Raises:
            PlaceNotReached: There is no way, or the navigation has given up.
            RobotNotAble: The robot is lost, or another program drives it.
        """
        drive = self._navigate if self.navigates else self._drive
        try:
            async with asyncio.timeout(_LONGEST):
                await drive(goal, tolerance)
        except TimeoutError as err:
            raise PlaceNotReached(f"it was not reached within {_LONGEST:g} s") from err
        finally:
            await self.stop()

    async def stop(self) -> None:
        """Stop what this object has begun; the robot stands afterwards also if it was on its way."""
        mission, self._mission = self._mission, ""
        if mission:
            with suppress(BusError, AgentError):  # it ends at its goal then, and the manager stops it besides
                await self._agent.request(self._interface, "cancel", reply_within=_REPLY)

    async def _navigate(self, goal: Goal, tolerance: float) -> None:
        sent: Point | None = None
        sent_at = asked_at = 0.0
        misses = 0
        loop = asyncio.get_running_loop()
        while (place := goal()) is not None:
            pose = self._trusted_pose()
            if is_reached(place, pose, 0.8 * tolerance):
                return
            if sent is None or dist(sent, place) > self._settings.follow.replan_m:
                await self._send(place, tolerance)
                sent = place
                sent_at = asked_at = loop.time()
            await asyncio.sleep(LOOK)
            if loop.time() - asked_at < _ASK:
                continue
            asked_at = loop.time()
            outcome = await self._agent.request(self._interface, "state", reply_within=_REPLY)
            misses = 0 if outcome.is_done else misses + 1
            if misses >= _RETRIES:
                raise RobotNotAble(f"its navigation does not answer: {outcome.why}")
            if outcome.is_done and self._has_ended(outcome.result, loop.time() - sent_at):
                return

    def _has_ended(self, told: Mapping[str, Any], since: float) -> bool:
        """Return whether the mission is done.

        Raises:
            PlaceNotReached: It has failed.
            RobotNotAble: Another program has cancelled or replaced it.
        """
        state, is_other = str(told.get("state")), told.get("mission") != self._mission
        if is_other and since < _ARRIVING:
            return False
        if is_other or state in ("cancelled", "replaced"):
            self._mission = ""  # another program wants the robot elsewhere
            raise RobotNotAble("another program drives it: its mission was " + ("replaced" if is_other else state))
        if state == "failed":
            self._mission = ""
            raise PlaceNotReached(str(told.get("why") or "the navigation has given up"))
        if state == "done":
            self._mission = ""
        return state == "done"

    async def _send(self, place: Point, tolerance: float) -> None:
        x, y = place
        there = {"x": x, "y": y, "tolerance": 0.7 * tolerance, "frame": "map"}
        before, self._mission = self._mission, "?"  # a drive that is cancelled now cancels this mission as well
        begun = await self._agent.request(self._interface, "go", reply_within=_REPLY, **there)
        if not begun.is_done:
            if begun.ending is not Ending.TIMED_OUT:  # after that, this mission may have begun
                self._mission = before  # it is still under way
            raise PlaceNotReached(begun.why)
        self._mission = str(begun.result["mission"])

    async def _drive(self, goal: Goal, tolerance: float) -> None:
        """Drive along the shortest way, straight from corner to corner, and wait while something is in the way."""
        blocked_since: float | None = None
        loop = asyncio.get_running_loop()
        while (place := goal()) is not None:
            pose = self._trusted_pose()
            if is_reached(place, pose, tolerance):
                return
            way = await asyncio.to_thread(self._floor.way, (pose.x, pose.y), place)
            if way is None:
                raise PlaceNotReached("the map has no way there")
            corner = next((each for each in way[1:] if dist(each, (pose.x, pose.y)) > 0.15), way[-1])
            why = self._barred(pose, corner) or await self._straight(corner, place, goal)
            if why.startswith(_BLOCKED):
                await self._back_off()
            if why:
                blocked_since = loop.time() if blocked_since is None else blocked_since
                other = self._senses.near_robot
                # Of two robots that stand before each other, one makes way at once, and the other waits for it.
                patience = self._settings.drive.blocked_s * (1.0 if not other or self._robot < other else _LATER)
                if loop.time() - blocked_since > patience:
                    raise PlaceNotReached(why, is_traffic=bool(other))
                await asyncio.sleep(LOOK)
            else:
                blocked_since = None

    async def _straight(self, corner: Point, place: Point, goal: Goal) -> str:
        """Have the base drive to a corner; return why it was stopped, empty if it has arrived."""
        origin = self._senses.odom_in_map
        assert origin is not None  # the robot is localized
        x, y = origin.locate(*corner)
        speed = self._settings.drive.speed_m_s
        going = self._agent.begin_request(self._base, "go_to", reply_within=_LONGEST, x=x, y=y, speed=speed)
        ending = asyncio.ensure_future(going.outcome())
        try:
            while not ending.done():
                await asyncio.wait([ending], timeout=0.1)
                pose = self._trusted_pose()
                target = goal()
                if target is None or dist(target, place) > self._settings.follow.replan_m:
                    return ""
                if why := self._barred(pose, corner):
                    return why
            return _judged(ending.result())
        finally:
            if not ending.done():
                await going.cancel()

    async def _back_off(self) -> None:
        """Drive back from what the robot has run into, or it could not turn there; stay if something is behind it."""
        if self._senses.in_the_way(pi, self._rear + _BACK_OFF, self._width):
            return
        back = {"distance": -_BACK_OFF, "speed": _BACK_SPEED}
        _judged(await self._agent.request(self._base, "move", reply_within=_REPLY, **back))

    def _barred(self, pose: Pose2D, corner: Point) -> str:
        """Return why the robot must not drive straight to a corner now; empty if it may."""
        reach = min(self._settings.drive.gap_m, dist(corner, (pose.x, pose.y))) + self._front
        return self._senses.in_the_way(pose.bearing_to(*corner), reach, self._width)

    def _trusted_pose(self) -> Pose2D:
        pose = self._senses.pose
        if pose is None:
            raise RobotLost(self._senses.trouble)
        return pose


def _judged(outcome: Outcome) -> str:
    """Return why the base has not driven to a corner; empty if it has.

    Raises:
        RobotNotAble: Another program drives it, or it cannot drive.
    """
    if outcome.is_done:
        return ""
    if outcome.ending is Ending.FAILED and "replaced by" not in outcome.why:
        return outcome.why
    raise RobotNotAble(f"its base does not drive: {outcome.why}")

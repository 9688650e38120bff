"""Robots and people that are played for patrols in virtual time, and the agents by which the robots are known."""

import asyncio
import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import atan2, cos, dist, hypot, inf, pi, sin
from pathlib import Path
from typing import Any

from agents.platform import Agent, AgentName, request
from apps.surveillance.algorithms.floor import PatrolFloor
from bus import Refused
from geometry import Point, Pose2D, wrap_angle
from p2os_emu.world.people import HIP, STEP_LENGTH

PICTURE = b"a picture"
SPEED, TURN = 0.4, 0.8  # m/s and rad/s of the played robots
STEP = 0.1  # s of the motion
LASER = Pose2D(0.02, 0.0, 0.0)
ORIGIN = Pose2D(2.0, -1.0, 0.7)
"""Of odom in map, so that nobody takes one for the other."""


@dataclass(slots=True)
class PlayedIntruder:
    """A person who walks along a way at a constant speed, m/s, from a time on, s, stands at its end, and is gone again.

    lasts: s for which the person is there.
    """

    way: Sequence[Point]
    begins: float
    speed: float = 0.8
    lasts: float = inf

    def pose(self, now: float) -> Pose2D | None:
        """Return where the person is, and walks to; None before the beginning and after the end."""
        if not self.begins <= now < self.begins + self.lasts:
            return None
        rest = (now - self.begins) * self.speed
        heading = 0.0
        for a, b in pairwise(self.way):
            length, heading = dist(a, b), atan2(b[1] - a[1], b[0] - a[0])
            if rest < length:
                return Pose2D(a[0] + rest * cos(heading), a[1] + rest * sin(heading), heading)
            rest -= length
        return Pose2D(*self.way[-1], heading)

    def place(self, now: float) -> Point | None:
        """Return where the person is; None before the beginning and after the end."""
        pose = self.pose(now)
        return None if pose is None else (pose.x, pose.y)

    def legs(self, now: float) -> Sequence[Point]:
        """Return where the legs are; none before the beginning and after the end."""
        pose = self.pose(now)
        if pose is None:
            return ()
        walked = min((now - self.begins) * self.speed, sum(dist(a, b) for a, b in pairwise(self.way)))
        stride = 0.5 * STEP_LENGTH * sin(pi * walked / STEP_LENGTH)
        return [pose.transform(side * stride, side * HIP) for side in (1.0, -1.0)]


@dataclass(slots=True)
class PlayedRobot:
    """The truth of one robot.

    way: corners that are still ahead. path: where it was, each second. barred: places, m. stalls: how often its wheels
    are still going to be blocked. backed: m that it was told to drive back. started: ms, of its localization. map: on
    which that is; empty for the map of the course.
    """

    name: str
    pose: Pose2D
    way: list[Point] = field(default_factory=list)
    mission: str = ""
    state: str = "none"
    driven: float = 0.0
    is_lost: bool = False
    is_dead: bool = False
    barred: list[Point] = field(default_factory=list)
    stalls: int = 0
    backed: float = 0.0
    started: int = 1
    map: str = ""
    error: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    path: list[Pose2D] = field(default_factory=list)

    def step(self, seconds: float) -> None:
        """Drive on."""
        while self.way and seconds > 1e-9:
            x, y = self.way[0]
            away, off = hypot(x - self.pose.x, y - self.pose.y), self.pose.bearing_to(x, y)
            if away < 0.02:
                self.way.pop(0)
                continue
            if abs(off) > 0.02:
                turned = min(abs(off), TURN * seconds)
                seconds -= turned / TURN
                heading = wrap_angle(self.pose.heading + (turned if off > 0.0 else -turned))
                self.pose = Pose2D(self.pose.x, self.pose.y, heading)
                continue
            gone = min(away, SPEED * seconds)
            seconds -= gone / SPEED
            self.driven += gone
            heading = atan2(y - self.pose.y, x - self.pose.x)
            self.pose = Pose2D(self.pose.x + gone * cos(heading), self.pose.y + gone * sin(heading), heading)
        if not self.way and self.state == "active":
            self.state = "done"


class PlayedBase(Agent):
    """The agent of the base: it drives straight to a place in odom."""

    services = ("component", "base")

    def __init__(self, robot: PlayedRobot, geometry: Mapping[str, float]) -> None:
        super().__init__(AgentName("base", robot.name), {"geometry": dict(geometry)})
        self._robot = robot

    @request("go_to")
    async def go_to(self, x: float, y: float, speed: float) -> dict[str, Any]:
        """Drive straight to a place in odom, m; a cancelled request stops the robot."""
        if self._robot.stalls > 0:
            self._robot.stalls -= 1
            await asyncio.sleep(STEP)  # it has agreed, and fails
            raise Refused("blocked: the left wheel is stalled")
        self._robot.way = [ORIGIN.transform(x, y)]
        try:
            while self._robot.way:
                await asyncio.sleep(STEP)
        finally:
            self._robot.way = []
        return {}

    @request("move")
    async def move(self, distance: float, speed: float) -> dict[str, Any]:
        """Drive a distance, m, backward if negative."""
        pose = self._robot.pose
        x, y = pose.transform(distance, 0.0)
        self._robot.pose, self._robot.backed = Pose2D(x, y, pose.heading), self._robot.backed - distance
        await asyncio.sleep(abs(distance) / speed)
        return {}


class PlayedMotion(Agent):
    """The agent of motion tracking, of which the description and the results are used."""

    services = ("images", "motion")


class PlayedCamera(Agent):
    """The agent of the camera; all its pictures are the same."""

    @request("picture")
    async def picture(self) -> dict[str, Any]:
        """Return the picture."""
        return {"format": "jpeg", "width": 1, "height": 1, "data": base64.b64encode(PICTURE).decode()}


class PlayedLocalization(Agent):
    """Answers as the localization of a robot that knows its pose."""

    def __init__(self, robot: PlayedRobot, file: Path) -> None:
        super().__init__(AgentName("localization", robot.name), {"laser": {"x": LASER.x, "y": 0.0, "heading": 0.0}})
        self._robot, self._file = robot, file

    @request("state")
    async def state_of_localization(self) -> dict[str, Any]:
        """Return the state and the file of the map."""
        robot = self._robot
        state, file = "searching" if robot.is_lost else "localized", robot.map or str(self._file)
        return {"state": state, "map": file, "started": robot.started, "reason": None}


class PlayedNavigation(Agent):
    """Answers as the user interface of the indoor navigation."""

    def __init__(self, robot: PlayedRobot, floor: PatrolFloor) -> None:
        super().__init__(AgentName("user_interface", robot.name))
        self._robot, self._floor, self._missions = robot, floor, 0

    @request("go")
    async def go(self, x: float, y: float, tolerance: float, frame: str) -> dict[str, Any]:
        """Begin a mission to a place in map, m."""
        assert frame == "map"
        robot, place = self._robot, (x, y)
        if robot.is_lost:
            raise Refused(f"{robot.name} is not localized")
        self._missions += 1
        robot.mission = f"m{self._missions}"
        way = self._floor.way((robot.pose.x, robot.pose.y), place)
        if any(dist(place, each) < 0.1 for each in robot.barred):
            way = None
        robot.state, robot.way = ("failed", []) if way is None else ("active", list(way[1:]))
        return {"mission": robot.mission}

    @request("state")
    async def state_of_mission(self) -> dict[str, Any]:
        """Return the state of the mission."""
        return {"mission": self._robot.mission, "state": self._robot.state, "why": "no way"}

    @request("cancel")
    async def cancel(self) -> dict[str, Any]:
        """Stop the robot."""
        self._robot.way, self._robot.state = [], "cancelled"
        return {"mission": self._robot.mission}

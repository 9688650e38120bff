"""The agent of the base: the pose of the robot, and all requests that move it.

Every request that moves the robot ends in one of three ways: it is done, and its result is the pose at the end; it
fails, with the reason; or it is cancelled, or its initiator dies, and the robot stops. A newer request that the gateway
accepts ends the older one, as with the gateway's commands; a lease gives the sole right to move the base.
"""

from collections.abc import Mapping
from math import isfinite, pi
from typing import Any

from agents.components.pose_control import PoseControlLimits, PoseGoal, Velocity
from agents.components.wheels import Wheels
from agents.platform import agree, asker, request
from bus import Refused, keys
from geometry import Pose2D

SPEED = PoseControlLimits(0.4, 0.8)  # m/s and rad/s, where the request has no speed
SLOWEST = PoseControlLimits(0.05, 0.05)  # m/s and rad/s from which the gateway computes its timeout
PATIENCE = 15.0  # s added to that timeout
FARTHEST = 1000.0  # m; a position farther away is taken for a typing error


class BaseAgent(Wheels):
    """The base. Poses are in `<robot>/odom`."""

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the properties, with size and limits of the robot."""
        about = super().properties_of(robot, element)
        size = {name: value for name, value in dict(robot["geometry"]).items() if name != "sonar"}
        return {**about, "limits": robot["limits"], "geometry": size}

    @request("drive", agrees_itself=True)
    async def drive(self, linear: float, angular: float = 0.0, seconds: float = 1.0, token: str = "") -> dict[str, Any]:
        """Drive at a velocity in m/s and rad/s, within the robot's limits, for a time in s."""
        _check(linear=linear, angular=angular)
        _check_above_zero(seconds=seconds)
        return await self.steer("drive", lambda pose: Velocity(linear, angular), seconds, token, late="")

    @request("move", agrees_itself=True)
    async def move(self, distance: float, speed: float | None = None, token: str = "") -> dict[str, Any]:
        """Drive a distance in m, backward if negative, at a speed in m/s if one is given."""
        _check(distance=distance)
        if speed is None:
            within = PATIENCE + abs(distance) / SLOWEST.linear
            return await self.travel(keys.MOVE, within, token, distance=distance)
        limits, start = _limits(speed), self.pose
        within = PATIENCE + 2.0 * abs(distance) / speed
        return await self.steer("move", lambda pose: limits.along(start, distance, pose), within, token)

    @request("turn", agrees_itself=True)
    async def turn(self, angle: float, token: str = "") -> dict[str, Any]:
        """Turn by an angle in rad, counter-clockwise, more than a full turn if so asked."""
        _check(angle=angle)
        return await self.travel(keys.TURN, PATIENCE + abs(angle) / SLOWEST.angular, token, angle=angle)

    @request("heading", agrees_itself=True)
    async def turn_to(self, heading: float, token: str = "") -> dict[str, Any]:
        """Turn in the shorter direction to a heading in odom, rad."""
        _check(heading=heading)
        return await self.travel(keys.HEADING, PATIENCE + pi / SLOWEST.angular, token, heading=heading)

    @request("go_to", agrees_itself=True)
    async def go_to(
        self, x: float, y: float, heading: float | None = None, speed: float | None = None, token: str = ""
    ) -> dict[str, Any]:
        """Drive to a position in odom, m, and turn there to a heading, rad, if given. It avoids no obstacles."""
        _check(x=x, y=y, heading=heading or 0.0)
        goal, limits, is_there = PoseGoal(x, y, heading), _limits(speed), False
        distance = goal.distance(self.pose)
        if distance > FARTHEST:
            raise Refused(f"({x:g}, {y:g}) is {distance:.0f} m away; name a place within {FARTHEST:g} m")

        def choose(pose: Pose2D) -> Velocity:
            nonlocal is_there
            velocity, is_there = limits.towards(goal, pose, is_there)
            return velocity

        within = PATIENCE + 3.0 * distance / limits.linear
        return await self.steer("go_to", choose, within, token)

    @request("stop", agrees_itself=True)
    async def stop(self) -> dict[str, Any]:
        """Stop the whole robot, also arm and gripper, and answer when it stands. No lease is needed."""
        await self.stop_robot()
        agree()  # an initiator without this in time stops the robot by the gateway
        self.moving.end(f"stopped by {asker()}")
        await self.come_to_rest()
        return self.latest()

    @request("enable", agrees_itself=True)
    async def enable(self, on: bool, token: str = "") -> dict[str, Any]:
        """Switch the motors."""
        await self.command(keys.ENABLE, on=on, token=token)
        self.moving.end(f"the motors were switched {'on' if on else 'off'} by {asker()}")
        return self.latest()

    @request("estop", agrees_itself=True)
    async def estop(self, on: bool) -> dict[str, Any]:
        """Stop as fast as possible, until `on` is false and the motors are enabled. No lease is needed."""
        await self.command(keys.ESTOP, on=on)
        if on:
            self.moving.end(f"the e-stop was pressed by {asker()}")
        return self.latest()


def _check(**numbers: float) -> None:
    for name, value in numbers.items():
        if not isinstance(value, int | float) or isinstance(value, bool) or not isfinite(value):
            raise Refused(f"{name} must be a finite number, not {value!r}")


def _check_above_zero(**numbers: float) -> None:
    _check(**numbers)
    for name, value in numbers.items():
        if value <= 0.0:
            raise Refused(f"{name} must be more than 0, not {value:g}")


def _limits(speed: float | None) -> PoseControlLimits:
    """Return the limits for a requested speed, m/s."""
    if speed is None:
        return SPEED
    _check_above_zero(speed=speed)
    return PoseControlLimits(speed, SPEED.angular)

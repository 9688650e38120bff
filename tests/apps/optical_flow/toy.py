"""A robot in a rectangular room, with exact columns in place of images."""

from dataclasses import replace
from math import cos, sin

import numpy as np

from apps.optical_flow.columns import Floats, FlowColumns
from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.sight import FlowReadings
from apps.optical_flow.wanderer import Wanderer, WanderOrders
from geometry import Pose2D, Twist2D

SETTINGS = FlowSettings.load()
BEARINGS = np.radians(np.linspace(28.0, -28.0, 16))
INTERVAL = 0.3


def columns(stamp: float, rates: Floats | float, motion: float = 20.0) -> FlowColumns:
    """Columns with the same flow everywhere."""
    count = len(BEARINGS)
    every = np.full(count, rates) if isinstance(rates, float) else rates
    return FlowColumns(stamp, INTERVAL, BEARINGS, every, np.full(count, 0.002), np.full(count, motion))


class ToyRobot:
    """Obeys at once, in a room from (0, 0) to a corner.

    Fields can be changed while it drives. has_images: whether images come. is_frozen: they do not change. is_blank:
    nothing has a texture. trouble: of the images. touches: of the bumpers.
    """

    def __init__(self, length: float = 6.0, depth: float = 5.0, pose: Pose2D | None = None) -> None:
        self.size = length, depth
        self.pose = pose or Pose2D(length / 2.0, depth / 2.0, 0.3)
        self.wanderer = Wanderer(SETTINGS)
        self.time = 0.0
        self.has_images, self.is_frozen, self.is_blank = True, False, False
        self.trouble, self.touches = "", False
        self.is_rear: bool | None = None
        self.twist = Twist2D()
        self.orders: list[WanderOrders] = []

    @property
    def gap(self) -> float:
        """Of the circle of half the robot's width to the nearest wall, m."""
        x, y = self.pose.x, self.pose.y
        return min(x, y, self.size[0] - x, self.size[1] - y) - SETTINGS.robot.width_m / 2.0

    def run(self, seconds: float) -> WanderOrders:
        """Let time pass; returns the last orders."""
        for _ in range(round(seconds / SETTINGS.period_s)):
            self.step()
        return self.orders[-1]

    def step(self) -> WanderOrders:
        """Let one period pass."""
        dt = SETTINGS.period_s
        turned = self.pose.heading + self.twist.angular * dt / 2.0
        x, y = self.pose.x + self.twist.linear * dt * cos(turned), self.pose.y + self.twist.linear * dt * sin(turned)
        self.pose = Pose2D(x, y, self.pose.heading + self.twist.angular * dt)
        self.time += dt
        seen = self._seen() if self.has_images and not self.trouble else None
        self.orders.append(
            self.wanderer.step(
                FlowReadings(
                    self.time, self.time, self.pose, self.twist, seen, self.trouble, self.touches, self.is_rear
                )
            )
        )
        self.twist = replace(self.orders[-1].twist)
        return self.orders[-1]

    def _seen(self) -> FlowColumns:
        if self.is_frozen or self.is_blank:
            return columns(self.time, np.nan, 0.0)
        if self.twist.linear < 0.01:
            return columns(self.time, np.nan, 30.0 if self.twist.angular or self.twist.linear else 0.0)
        rates = np.array([self.twist.linear / self._depth(float(bearing)) for bearing in BEARINGS])
        return columns(self.time, rates)

    def _depth(self, bearing: float) -> float:
        """Return the distance of the wall along the optical axis, m."""
        eye = self.pose.compose(Pose2D(SETTINGS.robot.camera_m))
        dx, dy = cos(eye.heading + bearing), sin(eye.heading + bearing)
        ways = [
            ((self.size[axis] if part > 0.0 else 0.0) - at) / part
            for axis, at, part in ((0, eye.x, dx), (1, eye.y, dy))
            if abs(part) > 1e-9
        ]
        return float(max(0.02, min(ways) * cos(bearing)))

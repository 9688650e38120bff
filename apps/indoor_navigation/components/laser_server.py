"""The way to the robot's laser scanner."""

import asyncio
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.platform import Cyclic, Restart, on
from apps.indoor_navigation.algorithms.pose_history import PoseHistory
from apps.indoor_navigation.component import Component, Role, hears
from apps.indoor_navigation.data import Floats, LaserRead, RobotOdometry
from bus import BusUnavailable, Refused, keys
from bus.messages import NS_PER_S, LaserScan, stamp_ns

ANSWER_TIME = 2.0  # s for the gateway to say where the scanner is
LOOK_AGAIN = 1.0  # s between two tries

log = logging.getLogger("navigation")


@dataclass(frozen=True, slots=True)
class LaserParameters:
    """no_scan: s of silence after which the scanner is missed."""

    no_scan: float


class LaserServer(Component):
    """Any scanner that a robot's gateway publishes: each scan with the pose that the robot had then."""

    role = Role.HARDWARE
    gives = (LaserRead,)
    parameters_type = LaserParameters

    async def setup(self) -> None:
        """Look for the scanner."""
        self._history = PoseHistory()
        self._mount: tuple[float, float, float] | None = None
        self._is_there = asyncio.Event()
        self._heard_at = float("-inf")
        self.add(Cyclic(self._know_scanner), Restart())

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """The robot says where it is."""
        self._history.add(odometry)

    @on("scan")
    async def look(self, scan: LaserScan) -> None:
        """The scanner has seen something. The pose is that of the middle beam."""
        self._heard_at = asyncio.get_running_loop().time()
        self._is_there.set()
        stamp = stamp_ns(scan.header) / NS_PER_S
        ranges = filled(np.asarray(scan.ranges, np.float64))
        robot = self._history.at(stamp + scan.time_increment * len(scan.ranges) / 2.0)
        if robot is None or self._mount is None or ranges is None:
            return
        pose = (robot.x, robot.y, robot.heading)
        angles = scan.angle_min, scan.angle_increment
        self.push(LaserRead(stamp, pose, self._mount, *angles, scan.range_max, ranges))

    async def _know_scanner(self) -> None:
        """Learn where the scanner is on the robot, whenever it has come or come back."""
        await self._is_there.wait()
        try:
            self._mount = _mounted(await self.query(keys.DESCRIPTION.key(self.robot), {}, ANSWER_TIME))
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            log.info("%s: %s has not said where its laser is: %r", self.name, self.robot, err)
        else:
            await self._missed()
        await asyncio.sleep(LOOK_AGAIN)

    async def _missed(self) -> None:
        """Wait until nothing has been heard of the scanner for too long, and say so."""
        loop = asyncio.get_running_loop()
        while (silence := loop.time() - self._heard_at) < self.parameters.no_scan:
            await asyncio.sleep(self.parameters.no_scan - silence)
        self._is_there.clear()
        why = f"the laser of {self.robot} has not been heard for {silence:.1f} s; see whether it is switched on"
        self.home.report(self.name, why, None)


def _mounted(told: Mapping[str, Any]) -> tuple[float, float, float]:
    """From a robot's description: where its laser is, x, y and heading in the robot's frame.

    Raises:
        LookupError, TypeError, ValueError: It makes no sense, or there is no laser.
    """
    for element in told["elements"]:
        if element["name"] == "laser":
            place = element["geometry"]
            return float(place["x"]), float(place["y"]), float(place["heading"])
    raise LookupError(f"{told['name']} has no laser")


def filled(ranges: Floats) -> Floats | None:
    """Replace NaN, which means no measurement, by the shorter of the nearest measured ranges on either side, m.

    A wall may be too dark to be measured, so a beam without a measurement never counts as free. None where no beam
    has a measurement.
    """
    missing = np.isnan(ranges)
    if missing.all():
        return None
    if not missing.any():
        return ranges
    places = np.flatnonzero(~missing)
    after = np.minimum(np.searchsorted(places, np.arange(len(ranges))), len(places) - 1)
    before = np.maximum(np.searchsorted(places, np.arange(len(ranges)), side="right") - 1, 0)
    return np.where(missing, np.minimum(ranges[places[before]], ranges[places[after]]), ranges)

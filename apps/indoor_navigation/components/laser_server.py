"""The component that reads the robot's laser scanner."""

import asyncio
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.pose_history import PoseHistory
from apps.indoor_navigation.component import DESCRIPTION_TIMEOUT, Component, Role, hears, reads
from apps.indoor_navigation.data import Floats, LaserRead, Pose, RobotOdometry
from bus import BusUnavailable, Refused, keys
from bus.messages import NS_PER_S, LaserScan, stamp_ns

RETRY_PERIOD = 1.0  # s between two queries for the description

log = logging.getLogger("navigation")


@dataclass(frozen=True, slots=True)
class LaserParameters:
    """no_scan: s without a scan after which the scanner is reported as lost."""

    no_scan: float


class LaserServer(Component):
    """Pushes each scan of the gateway with the pose that the robot had at that time."""

    role = Role.HARDWARE
    gives = (LaserRead,)
    parameters_type = LaserParameters

    async def setup(self) -> None:
        """Begin to look for the scanner."""
        self._history = PoseHistory()
        self._mount: Pose | None = None
        self._is_there = asyncio.Event()
        self._heard_at = float("-inf")
        self.add(Cyclic(self._know_scanner), Restart())

    def woken(self, slept: float) -> None:
        """Forget the poses: the robot may have been pushed."""
        self._history = PoseHistory()

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """Take the pose of the robot."""
        self._history.add(odometry)

    @reads("scan")
    async def look(self, scan: LaserScan) -> None:
        """Push a scan, with the pose of the robot at its middle beam."""
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
        """Query the scanner's place on the robot whenever the scanner has begun to publish."""
        await self._is_there.wait()
        try:
            self._mount = _mounted(await self.query(keys.DESCRIPTION.key(self.robot), {}, DESCRIPTION_TIMEOUT))
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            log.info("%s: %s has not described its laser: %r", self.name, self.robot, err)
        else:
            await self._missed()
        await asyncio.sleep(RETRY_PERIOD)

    async def _missed(self) -> None:
        """Wait until scans have been missing for too long, and report it; return when they are back after a sleep."""
        loop, began = asyncio.get_running_loop(), self.woke_at
        while (silence := loop.time() - max(self._heard_at, self.woke_at)) < self.parameters.no_scan:
            await asyncio.sleep(self.parameters.no_scan - silence)
            await self.awake()
            if began < self.woke_at < self._heard_at:
                return  # the laser may have been moved since it was described
        self._is_there.clear()
        why = f"the laser of {self.robot} has published no scan for {silence:.1f} s; check whether it is switched on"
        self.home.report(self.name, why, None)


def _mounted(description: Mapping[str, Any]) -> Pose:
    """Return x, y and heading of the laser in the robot's frame, from the robot's description.

    Raises:
        LookupError, TypeError, ValueError: The description is invalid, or there is no laser.
    """
    for element in description["elements"]:
        if element["name"] == "laser":
            place = element["geometry"]
            return float(place["x"]), float(place["y"]), float(place["heading"])
    raise LookupError(f"{description['name']} has no laser")


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

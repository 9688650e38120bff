"""The laser of a simulator on the bus: sweeps from the robot's own line."""

from collections.abc import Iterable, Mapping
from math import inf, nan
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import NS_PER_S, LaserScan, TransformStamped, header, placed
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.elements.simulated_laser.element import FIRST_BEARING, LAST_BEARING, SimulatedLaserScanner
from gateway.events import SweepReceived

NEAREST = 0.01
"""m; simulators write 0 where there is no reading."""
FARTHEST = 32.0
"""m; what MobileSim's laser sees. A simulator writes its own farthest range where nothing was near enough."""


class _SimulatedLaserAdapter(BusAdapter[SweepReceived]):
    """Publishes `<robot>/scan` in `<robot>/laser`, which sits where the robot's model has its laser.

    Ranges follow REP 117: `inf` where nothing was near enough, NaN where there is no reading.
    """

    name = "laser"
    element = SimulatedLaserScanner
    streams = (keys.SCAN,)
    events = (SweepReceived,)

    def __init__(self, robot: RobotContext) -> None:
        super().__init__(robot)
        self._frame = frame(robot.name, "laser")
        self._base = frame(robot.name, "base_link")

    def messages(self, event: SweepReceived, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return a scan for each sweep."""
        yield keys.SCAN, self._scan(event, stamp)

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Return `<robot>/laser` in `<robot>/base_link`."""
        if self.is_present():
            mount = self._model.laser
            yield placed(header(stamp, self._base), self._frame, mount.x, mount.y, mount.heading)

    def describe(self) -> Mapping[str, Any]:
        """Return geometry and range."""
        mount = self._model.laser
        beams = self._driver.lookup(SimulatedLaserScanner).beams
        return {
            "type": "simulated",
            "frame": self._frame,
            "geometry": {"x": mount.x, "y": mount.y, "z": 0.0, "heading": mount.heading, "flipped": False},
            "angle_min": FIRST_BEARING,
            "angle_max": LAST_BEARING,
            "angle_increment": (LAST_BEARING - FIRST_BEARING) / max(1, beams - 1),
            "beams": beams,
            "range_max": FARTHEST,
        }

    def _scan(self, sweep: SweepReceived, stamp: int) -> LaserScan:
        ranges = np.array(sweep.ranges, np.float32)
        ranges[ranges >= FARTHEST] = inf
        ranges[ranges < NEAREST] = nan
        return LaserScan(
            header=header(stamp - round(sweep.age * NS_PER_S), self._frame),
            angle_min=sweep.first_bearing,
            angle_max=sweep.first_bearing + (len(ranges) - 1) * sweep.step,
            angle_increment=sweep.step,
            time_increment=0.0,  # a simulator looks everywhere at once
            scan_time=sweep.period,
            range_min=NEAREST,
            range_max=FARTHEST,
            ranges=ranges,
            intensities=np.array(sweep.reflectances, np.float32),
        )


ADAPTERS = (_SimulatedLaserAdapter,)

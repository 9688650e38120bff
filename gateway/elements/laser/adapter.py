"""The laser scanner on the bus: scans in a frame of its own, whose z axis points up however the scanner hangs."""

from collections.abc import Iterable, Mapping
from math import pi, radians
from typing import Any

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import NS_PER_S, LaserScan, TransformStamped, header, placed
from gateway.cables.cable import ElementCable
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.elements.laser.driver import NAME, LaserDriver
from gateway.events import LaserScanned
from p2os.accessories.lms import MIRROR_PERIOD

NEAREST = 0.01
"""m; a hand on the window is measured too."""
FARTHEST = 80.0
"""m; the range of the scanner at best, whatever its values could represent."""


class LaserAdapter(BusAdapter[LaserScanned]):
    """Publishes `<robot>/scan` in `<robot>/laser`.

    Ranges follow REP 117: `inf` where nothing was near enough, NaN where there is no measurement. The stamp is the time
    of the first beam. Angles rise counter-clockwise: what a flipped scanner sends from left to right is turned round.
    """

    name = NAME
    streams = (keys.SCAN,)
    events = (LaserScanned,)

    def __init__(self, robot: RobotContext, cable: ElementCable) -> None:
        super().__init__(robot, cable)
        self._laser: LaserDriver = cable.driver
        mount, own = robot.model.laser, robot.settings.laser
        self._frame = frame(robot.name, "laser")
        self._base = frame(robot.name, "base_link")
        self._x = mount.x if own.x_m is None else own.x_m
        self._y = mount.y if own.y_m is None else own.y_m
        self._z = own.z_m
        self._heading = mount.heading if own.heading_deg is None else radians(own.heading_deg)
        self._is_flipped = mount.flipped if own.flipped is None else own.flipped

    def messages(self, event: LaserScanned, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return the scan."""
        yield keys.SCAN, self._scan(event, stamp)

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Return `<robot>/laser` in `<robot>/base_link`."""
        transform = placed(header(stamp, self._base), self._frame, self._x, self._y, self._heading)
        transform.transform.translation.z = self._z
        yield transform

    def describe(self) -> Mapping[str, Any]:
        """Return geometry and range."""
        variant = self._laser.variant
        return {
            "type": self._laser.type,
            "frame": self._frame,
            "geometry": {
                "x": self._x,
                "y": self._y,
                "z": self._z,
                "heading": self._heading,
                "flipped": self._is_flipped,
            },
            "angle_min": variant.first_bearing,
            "angle_max": -variant.first_bearing,
            "angle_increment": variant.resolution,
            "beams": variant.beams,
            "range_max": self._range_max,
        }

    @property
    def _range_max(self) -> float:
        return min(FARTHEST, self._laser.configuration.max_range)

    def _scan(self, event: LaserScanned, stamp: int) -> LaserScan:
        scan, variant, configuration, age, period = event
        ranges = scan.ranges(configuration.flag_bits).astype(np.float32)
        flags = scan.flags(configuration.flag_bits).astype(np.float32)
        angle_min = variant.first_bearing + scan.first * variant.resolution
        angle_max = angle_min + (len(ranges) - 1) * variant.resolution
        if self._is_flipped:
            ranges, flags = ranges[::-1].copy(), flags[::-1].copy()
            angle_min, angle_max = -angle_max, -angle_min
        return LaserScan(
            header=header(stamp - round(age * NS_PER_S), self._frame),
            angle_min=angle_min,
            angle_max=angle_max,
            angle_increment=variant.resolution,
            # Of the mirror; the beams between the degrees, from further turns, are not distinguished.
            time_increment=MIRROR_PERIOD * variant.resolution / (2 * pi),
            scan_time=period,
            range_min=NEAREST,
            range_max=self._range_max,
            ranges=ranges,
            intensities=flags,
        )


ADAPTERS = (LaserAdapter,)

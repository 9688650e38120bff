"""The agent of the laser scanner."""

from collections.abc import Mapping
from math import atan2, cos, sin
from typing import Any, ClassVar

import numpy as np

from agents.components.component import ElementAgent, known
from bus import keys
from bus.messages import LaserScan


class LaserAgent(ElementAgent):
    """Scans, from right to left. `bearing` is where the nearest echo is, seen from the robot."""

    source = keys.SCAN
    results: ClassVar[Mapping[str, str]] = {
        "angle_min": "rad of the first beam, in the laser's frame",
        "angle_increment": "rad from beam to beam",
        "ranges": "m of each beam, null where nothing was measured",
        "nearest": "m, null where there is nothing",
        "bearing": "rad in base_link, of the nearest",
    }

    def result(self, message: LaserScan) -> dict[str, Any]:
        """The scan."""
        ranges = np.asarray(message.ranges, np.float64)
        missing = np.flatnonzero(~np.isfinite(ranges))
        listed = np.round(ranges, 3).tolist()
        for beam in missing:
            listed[beam] = None
        nearest = bearing = None
        if len(missing) < len(ranges):
            first = int(np.argmin(np.where(np.isfinite(ranges), ranges, np.inf)))
            nearest = known(ranges[first], 3)
            bearing = self._bearing(message.angle_min + first * message.angle_increment, ranges[first])
        return {
            "angle_min": known(message.angle_min, 6),
            "angle_increment": known(message.angle_increment, 6),
            "ranges": listed,
            "nearest": nearest,
            "bearing": bearing,
        }

    def _bearing(self, angle: float, distance: float) -> float | None:
        place = self.properties.get("geometry", {})
        angle += place.get("heading", 0.0)
        x, y = place.get("x", 0.0) + distance * cos(angle), place.get("y", 0.0) + distance * sin(angle)
        return known(atan2(y, x))

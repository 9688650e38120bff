"""The component that finds the door-like exits in each scan."""

from typing import Any

from apps.indoor_navigation.algorithms.doors import find_doors
from apps.indoor_navigation.algorithms.opening import DoorParameters
from apps.indoor_navigation.component import Component, Role, answers_query, hears
from apps.indoor_navigation.data import DLEData, LaserRead
from bus import Refused


class DLEDetecting(Component):
    """Pushes the exits of each scan, and answers the query `doors` with those of the last scan."""

    role = Role.DELIBERATIVE
    gives = (DLEData,)
    parameters_type = DoorParameters

    async def setup(self) -> None:
        """Begin without a scan."""
        self._last: DLEData | None = None

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """Find the exits, in less than a millisecond, and push them, also where there are none."""
        self._last = DLEData(scan.stamp, scan.pose, find_doors(scan, self.parameters))
        self.push(self._last)

    @answers_query("doors")
    def doors(self) -> dict[str, Any]:
        """Return the exits of the last scan as `DLEData`."""
        if self._last is None:
            raise Refused(f"{self.name} has received no scan yet; check whether the laser is switched on")
        return self._last.to_json()

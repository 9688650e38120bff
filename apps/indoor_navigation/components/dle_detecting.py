"""Where one can leave: the door-like exits of each scan."""

from typing import Any

from apps.indoor_navigation.algorithms.doors import find_doors
from apps.indoor_navigation.algorithms.opening import DoorParameters
from apps.indoor_navigation.component import Component, Role, answers_query, hears
from apps.indoor_navigation.data import DLEData, LaserRead
from bus import Refused


class DLEDetecting(Component):
    """Pushes the exits of each scan as it comes, and those of the last one to whoever asks."""

    role = Role.DELIBERATIVE
    gives = (DLEData,)
    parameters_type = DoorParameters

    async def setup(self) -> None:
        """Nothing has been seen yet."""
        self._last: DLEData | None = None

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """Find the exits; it takes less than a millisecond. One in which there are none is told, too."""
        self._last = DLEData(scan.stamp, scan.pose, find_doors(scan, self.parameters))
        self.push(self._last)

    @answers_query("doors")
    def doors(self) -> dict[str, Any]:
        """The exits of the last scan, as `DLEData`."""
        if self._last is None:
            raise Refused(f"{self.name} has heard no scan yet; see whether the laser is switched on")
        return self._last.to_json()

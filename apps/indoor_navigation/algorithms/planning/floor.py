"""The map of a building as the first knowledge of the grid, in the frame `map`.

Sensors correct it: a wall that rays pass is gone after a few of them, and what stands on free floor of the map is
added. Only forbidden cells stay, since no sensor shows them.
"""

from base64 import b64decode
from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any
from zlib import decompress, error

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import OCCUPIED, PASSED, Area
from apps.indoor_navigation.data import Bools
from geometry import Pose2D
from maps.occupancy import FREE, OccupancyGrid

ON_MAP = 2 * OCCUPIED  # evidence of a wall of the map; three rays that pass remove it
ROUNDING = 1e-6  # of cells


@dataclass(frozen=True, eq=False)
class FloorMap:
    """grid: of the building, with axes along those of map. forbidden: cells that no robot may enter."""

    grid: OccupancyGrid
    forbidden: Bools

    @classmethod
    def of_json(cls, told: Mapping[str, Any]) -> "FloorMap":
        """Build from what the localization's request `floor` returns.

        Raises:
            ValueError: It is not a map.
        """
        try:
            shape = int(told["rows"]), int(told["columns"])
            cells = np.frombuffer(decompress(b64decode(told["cells"])), np.int8).reshape(shape)
            forbidden = np.frombuffer(decompress(b64decode(told["forbidden"])), np.uint8).reshape(shape) > 0
            origin = Pose2D(float(told["x"]), float(told["y"]))
            return cls(OccupancyGrid(cells, float(told["resolution"]), origin), forbidden)
        except (LookupError, TypeError, ValueError, error) as err:
            raise ValueError(f"this is not a map of the localization: {err!r}") from err

    def area(self, resolution: float) -> Area:
        """Return the grid's first knowledge, in cells with this edge, m."""
        grid = self.grid
        x, y = (resolution * floor(each / resolution + ROUNDING) for each in (grid.origin.x, grid.origin.y))
        rows = ceil((grid.origin.y + grid.height - y) / resolution - ROUNDING)
        columns = ceil((grid.origin.x + grid.width - x) / resolution - ROUNDING)
        area = Area.of(x, y, resolution, np.zeros((rows, columns), np.int8))
        middles = np.stack(
            np.meshgrid(x + (np.arange(columns) + 0.5) * resolution, y + (np.arange(rows) + 0.5) * resolution), axis=-1
        )
        is_free = grid.values_at(middles.reshape(-1, 2)) == FREE
        area.evidence[is_free.reshape(rows, columns)] = PASSED
        occupied = self._on(area, grid.is_occupied())
        area.evidence[occupied], area.fixed[occupied] = ON_MAP, True
        area.forbidden[self._on(area, self.forbidden)] = True
        return area

    def _on(self, area: Area, chosen: Bools) -> Bools:
        """Return the cells of an area that touch chosen cells of the map."""
        found = np.zeros(area.evidence.shape, bool)
        parts = ceil(self.grid.resolution / area.resolution)
        steps = (np.arange(parts) + 0.5) / parts - 0.5
        for right in steps * self.grid.resolution:
            for up in steps * self.grid.resolution:
                places = self.grid.centres(chosen) + np.array((right, up))
                at = np.floor((places - (area.x, area.y)) / area.resolution + ROUNDING).astype(np.intp)
                at = np.clip(at, 0, np.array(found.shape[::-1]) - 1)
                found[at[:, 1], at[:, 0]] = True
        return found

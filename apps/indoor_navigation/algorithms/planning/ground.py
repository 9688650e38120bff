"""What a metre costs a robot at each place and heading: the floor, and the room about its outline."""

from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.clearance import Clearance
from apps.indoor_navigation.algorithms.planning.terrain import (
    BARRED,
    NO_HINTS,
    START_COST,
    CostParameters,
    Hints,
    Terrain,
    distances,
    floor_costs,
    nearness,
)
from apps.indoor_navigation.data import Bools, Floats, Place, Pose

COARSE = 2  # cells of the grid along the edge of a cell of the flat terrain
START_RANGE = 0.3  # m around the robot within which it may be as near to obstacles as it is
# Cells of the grid that the room may lack, because of the errors of sensors and odometry: for a new plan, and for the
# present one, so that a plan that was found is not given up for the noise of the next scan.
MAX_LACK, MAX_LACK_KEPT = 0.2, 0.5
WORSE = 0.02  # m that the room near the start may be less than at the start
HELD_WORSE = 0.002  # likewise, where it was held up
# Where the robot was held up lately there is less room than the grid says: so far around it, m, a plan needs so much
# room, m, or not less than where the robot is.
HELD_RANGE, HELD_ROOM = 1.0, 0.04


class Ground(NamedTuple):
    """What a metre costs.

    floor: cost of a metre in each cell of the area, without obstacles. robot: its pose. room: m about it there. lack:
    cells of the grid that the room may lack. held: places where the robot was held up lately.
    """

    area: Area
    floor: Floats
    clearance: Clearance
    parameters: CostParameters
    outline: Outline
    robot: Pose
    room: float
    lack: float = MAX_LACK
    held: tuple[Place, ...] = ()

    @classmethod
    def of(
        cls,
        area: Area,
        outline: Outline,
        parameters: CostParameters,
        robot: Pose,
        *,
        hints: Hints = NO_HINTS,
        standing: Bools | None = None,
        hope: float = 0.0,
        held: tuple[Place, ...] = (),
    ) -> "Ground":
        """Return the costs of an area.

        Args:
            area: The grid.
            outline: Of the robot.
            parameters: The costs.
            robot: Its pose.
            hints: Knowledge beside the grid.
            standing: Cells with obstacles that do not go away; by default all obstacles.
            hope: Cost of the others.
            held: Places where the robot was held up lately.
        """
        floor = floor_costs(area, parameters, hints)
        if standing is None:
            standing = area.occupied
        elif hope > 0.0:
            others = distances(area.occupied & ~standing, outline.width / 2.0, area.resolution)
            floor[others < outline.width / 2.0] += hope
        clearance = Clearance(area, standing, outline, parameters.comfort)
        room = float(clearance.room(*(np.array([each]) for each in robot))[0])
        return cls(area, floor, clearance, parameters, outline, robot, room, held=held)

    def costs(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return the cost of a metre at poses in odom, arrays of one shape; BARRED where the robot does not fit."""
        room = self.clearance.room(x, y, heading)
        costs = nearness(room, self.parameters, self.lack * self.area.resolution)
        for held_x, held_y in self.held:
            costs[(np.hypot(x - held_x, y - held_y) < HELD_RANGE) & (room < HELD_ROOM)] = BARRED
        needed, worse = (HELD_ROOM, HELD_WORSE) if self.held else (0.0, WORSE)
        least = self.room - worse
        if least < needed:
            is_start = (np.hypot(x - self.robot[0], y - self.robot[1]) < START_RANGE) & (room >= least)
            costs[is_start] = np.minimum(costs[is_start], START_COST)
        return np.minimum(costs + self._floor(x, y), BARRED)

    def _floor(self, x: Floats, y: Floats) -> Floats:
        height, width = self.floor.shape
        rows = np.minimum(np.maximum((y - self.area.y) / self.area.resolution, 0.0), height - 1.0).astype(np.intp)
        columns = np.minimum(np.maximum((x - self.area.x) / self.area.resolution, 0.0), width - 1.0).astype(np.intp)
        return np.asarray(self.floor[rows, columns])

    def for_present_plan(self) -> "Ground":
        """Return the same for a plan that is driven already: it may lead through a little less room."""
        return self._replace(lack=MAX_LACK_KEPT)

    def flat(self) -> Terrain:
        """Return the least cost that any heading has in the cells of a coarser grid."""
        edge = COARSE * self.area.resolution
        room = _pooled(self.clearance.distances) - self.outline.width / 2.0
        # Between two hits on a far wall lies a gap that nobody has looked through; it must be as wide as the robot.
        inaccuracy = self.area.resolution * (1.0 - _pooled(self.area.unknown))
        cost = np.minimum(nearness(room, self.parameters, inaccuracy) + _pooled(self.floor), BARRED)
        area = Area.of(self.area.x, self.area.y, edge, np.zeros(cost.shape, np.int8))
        terrain = Terrain(area, cost)
        self._let_out(terrain, self.robot[:2])
        return terrain

    def _let_out(self, terrain: Terrain, robot: Place) -> None:
        """Unbar the cells around the robot."""
        rows, columns = terrain.cost.shape
        x = terrain.area.x + (np.arange(columns) + 0.5) * terrain.area.resolution
        y = terrain.area.y + (np.arange(rows)[:, None] + 0.5) * terrain.area.resolution
        near = np.hypot(x - robot[0], y - robot[1]) < START_RANGE + terrain.area.resolution
        terrain.cost[near & (terrain.cost >= BARRED)] = START_COST

    def is_barred(self, place: Place) -> bool:
        """Return whether the robot does not fit at a place with any heading."""
        headings = np.linspace(-np.pi, np.pi, 16, endpoint=False)
        x, y = np.full(16, place[0]), np.full(16, place[1])
        return bool(self.costs(x, y, headings).min() >= BARRED)

    def is_occupied(self, place: Place) -> bool:
        """Return whether an obstacle is seen at a place."""
        return bool(self.area.occupied[self.area.cell(*place)])


def _pooled(values: Floats | Bools) -> Floats:
    """Return the mean of each COARSE x COARSE values."""
    rows, columns = (-(-size // COARSE) for size in values.shape)
    missing = (0, rows * COARSE - values.shape[0]), (0, columns * COARSE - values.shape[1])
    padded = np.pad(values, missing, mode="edge")
    return np.asarray(padded.reshape(rows, COARSE, columns, COARSE).mean(axis=(1, 3)))

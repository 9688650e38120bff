"""What readings show that the map, the team and known furniture do not explain: from echoes to things, in `map`."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from apps.surveillance.algorithms.floor import PatrolFloor
from apps.surveillance.settings import MemberSettings, ScanChangeSettings, SonarChangeSettings
from geometry import Point, Pose2D
from maps.building_map import BuildingMap
from maps.localization.likelihood_field import LikelihoodField

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Cells = NDArray[np.int64]

_FIELD_CELL = 0.05  # m
_SAMPLE, _BEFORE_END = 0.08, 0.2  # m along a beam, and before its end, where the floor counts as free
_OFTEN = 4  # times that floor is seen free until it is known to be
_GONE = 30  # times without an echo between, until furniture is known to be gone
_THIN = 0.015  # m that a beam adds to the width of what it meets, at most
_FEW = 2  # echoes of a thing at least, as of a leg; a single one may be a corner that a beam touches
_SLOW_TURN = 0.2  # rad/s; a scan of a robot that turns faster does not tell exactly where the floor is free
_ABOUT = 2  # cells about furniture in which echoes are those of the furniture
_MARGIN = 1  # cells about a cell that were free as well, if it was


@dataclass(frozen=True, slots=True)
class UnexplainedThing:
    """Echoes that belong together and that nothing explains, by their middle, m in `map`.

    is_solid: there is as much of it as of a person; a leg beside a door is less, as those of a chair are.
    """

    x: float
    y: float
    is_solid: bool = True


@dataclass(frozen=True, slots=True)
class NearRobot:
    """A robot of the team, which is no intruder: where it was last heard of, m in `map`, and how long ago, s."""

    x: float
    y: float
    age: float

    def radius(self, settings: MemberSettings) -> float:
        """The radius about that place in which it may be now, m."""
        return min(settings.radius_most_m, settings.radius_m + settings.speed_m_s * max(0.0, self.age))


class SeenFloor:
    """What one robot has seen of the floor: where it was free, and where something stood when it was seen first.

    Something that stands where the floor was never free is furniture. Something where it was free has come since then.
    """

    def __init__(self, floor: PatrolFloor) -> None:
        self._floor = floor
        shape = floor.grid.cells.shape
        self._free: NDArray[np.int8] = np.zeros(shape, np.int8)  # how often a cell was seen free, up to a limit
        self._furniture: Bools = np.zeros(shape, np.bool_)

    def fits(self, floor: PatrolFloor) -> bool:
        """Whether another floor has the same cells."""
        return self._floor.grid.cells.shape == floor.grid.cells.shape

    def note_free(self, start: Point, ends: Floats) -> None:
        """Note that beams (m in `map`, shape (n, 2)) have passed the floor up to their ends."""
        ways = ends - start
        lengths = np.hypot(ways[:, 0], ways[:, 1])
        counts = np.maximum(0, ((lengths - _BEFORE_END) / _SAMPLE).astype(np.int64))
        which = np.repeat(np.arange(len(ends)), counts)
        along = (np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)) * _SAMPLE
        points: Floats = np.array(start) + (along / np.maximum(lengths[which], 1e-9))[:, np.newaxis] * ways[which]
        cells = np.zeros(self._free.shape, np.bool_)
        cells[self._floor.cells_of(points)] = True
        self._free[cells & (self._free < _GONE)] += 1
        self._furniture &= ~(cells & (self._free >= _GONE))

    def expect(self, points: Floats) -> None:
        """Expect something to stand at points, m in `map`, from now on."""
        cells = self._floor.cells_of(points)
        self._furniture[cells] = True
        self._free[cells] = 0

    def is_expected(self, points: Floats, margin: int = _MARGIN) -> Bools:
        """Which points are at furniture, or where the floor was never seen free; those become furniture.

        Args:
            points: m in `map`, shape (n, 2).
            margin: Cells about a point that must have been free as well.
        """
        rows, columns = self._floor.cells_of(points)
        near = self._furniture[self._about(rows, columns, _ABOUT)].any(axis=1)
        # Beams that pass a surface closely show the cells before it as free; those within it never were.
        free = self._free[self._about(rows, columns, margin)].min(axis=1)
        new = ~near & (free < _OFTEN)
        self._furniture[rows[new], columns[new]] = True
        stands = self._furniture[rows, columns]
        self._free[rows[stands], columns[stands]] = 0
        expected: Bools = near | new
        return expected

    def _about(self, rows: Cells, columns: Cells, reach: int) -> tuple[Cells, Cells]:
        """Rows and columns of the cells about each of some cells, shape (n, cells)."""
        height, width = self._free.shape
        up, right = (each.reshape(-1) for each in np.mgrid[-reach : reach + 1, -reach : reach + 1])
        return np.clip(rows[:, np.newaxis] + up, 0, height - 1), np.clip(columns[:, np.newaxis] + right, 0, width - 1)


class MapComparison:
    """Compares readings with a map."""

    def __init__(
        self,
        map_: BuildingMap,
        floor: PatrolFloor,
        scan: ScanChangeSettings,
        sonar: SonarChangeSettings,
        member: MemberSettings,
    ) -> None:
        """Prepare the distances from the walls.

        Args:
            map_: Of the building.
            floor: Of the same map.
            scan, sonar, member: Settings.
        Raises:
            ValueError: The map shows no walls.
        """
        self._field = LikelihoodField(map_, _FIELD_CELL)
        self._floor = floor
        self._scan, self._sonar, self._member = scan, sonar, member

    def in_scan(
        self,
        pose: Pose2D,
        ends: Floats,
        origin: Point,
        increment: float,
        turn_rate: float,
        robots: Sequence[NearRobot],
        seen: SeenFloor | None = None,
    ) -> list[UnexplainedThing]:
        """Find what a laser scan shows beside the map.

        Args:
            pose: Of the robot when it was made.
            ends: Echoes in the robot's frame, m, shape (n, 2), in the order of the beams.
            origin: Of the beams, likewise.
            increment: From beam to beam, rad.
            turn_rate: Of the robot then, rad/s.
            robots: Of the team, without this one.
            seen: The floor as it was seen before, which this scan is added to; without it, nothing is furniture.
        Returns:
            Nothing where the map explains so little that the pose is in doubt.
        """
        scan = self._scan
        ranges = np.hypot(*(ends - origin).T)
        ends, ranges = ends[ranges < scan.range_m], ranges[ranges < scan.range_m]
        if not len(ends):
            return []
        points, start = in_map(pose, ends), pose.transform(*origin)
        # The farther a wall, the more an error of the heading displaces its echoes.
        margin = scan.wall_m + ranges * (scan.angle_rad + scan.turn_s * abs(turn_rate))
        odd = self._field.distances_at(points) > np.minimum(margin, 0.9)
        if np.count_nonzero(odd) > scan.doubt * len(odd):
            return []
        odd &= self._floor.is_free(points)
        odd[odd] = ~self._blocked(start, points[odd])
        odd &= self._no_robot(points, robots)
        if seen is not None:
            odd[odd] = ~seen.is_expected(points[odd])
            if abs(turn_rate) < _SLOW_TURN:
                seen.note_free(start, points[~odd])
        things = []
        for echoes in _groups(points[odd], scan.gap_m):
            extent = float(np.hypot(*np.ptp(echoes, axis=0)))
            if len(echoes) >= _FEW and extent <= scan.width_m:
                is_solid = len(echoes) >= scan.echoes and _solid(echoes - start, abs(increment)) >= scan.solid_m
                x, y = echoes.mean(axis=0).tolist()
                things.append(UnexplainedThing(x, y, is_solid))
        return things

    def in_sonar(
        self, pose: Pose2D, arcs: Floats, robots: Sequence[NearRobot], seen: SeenFloor | None = None
    ) -> list[UnexplainedThing]:
        """Find what echoes of the sonar show beside the map.

        Args:
            pose: Of the robot; the discs are near its middle, compared with the width of their cones.
            arcs: Where each echo may come from, m in the robot's frame, shape (echoes, places, 2).
            robots: Of the team, without this one.
            seen: As for `in_scan`.
        """
        sonar, start = self._sonar, (pose.x, pose.y)
        things: list[UnexplainedThing] = []
        for arc in arcs:
            middle = arc[len(arc) // 2]
            if np.hypot(*middle) > sonar.range_m:
                continue
            places, at = in_map(pose, arc), in_map(pose, middle[np.newaxis])
            is_odd = bool((self._field.distances_at(places) > sonar.wall_m).all() and self._floor.is_free(at).all())
            is_odd = is_odd and not self._blocked(start, places).any() and bool(self._no_robot(places, robots).all())
            if seen is not None:
                is_odd = is_odd and not seen.is_expected(at, 0).any()
                if not is_odd:
                    seen.note_free(start, at)
            if is_odd:
                things.append(UnexplainedThing(float(at[0, 0]), float(at[0, 1])))
        return things

    def _blocked(self, start: Point, ends: Floats) -> Bools:
        """Which beams would have had to pass through a wall; then the pose is wrong, or the wall is made of glass."""
        _, blocked = self._field.explained(np.broadcast_to(start, ends.shape), ends, self._scan.wall_m)
        return blocked

    def _no_robot(self, points: Floats, robots: Sequence[NearRobot]) -> Bools:
        """Which points are away from all robots of the team."""
        clear = np.ones(len(points), np.bool_)
        for each in robots:
            clear &= np.hypot(points[:, 0] - each.x, points[:, 1] - each.y) > each.radius(self._member)
        return clear


def in_map(pose: Pose2D, points: Floats) -> Floats:
    """Return points of the robot's frame (m, shape (n, 2)) in the frame of its pose."""
    c, s = np.cos(pose.heading), np.sin(pose.heading)
    x, y = points[:, 0], points[:, 1]
    placed: Floats = np.stack((pose.x + c * x - s * y, pose.y + s * x + c * y), axis=1)
    return placed


def _groups(points: Floats, gap: float) -> list[Floats]:
    """Points in groups of neighbours that are not farther apart than a gap, m."""
    if not len(points):
        return []
    breaks = np.flatnonzero(np.hypot(*np.diff(points, axis=0).T) > gap) + 1
    return list(np.split(points, breaks))


def _solid(echoes: Floats, increment: float) -> float:
    """Width of what stands in the beams, m: without the gaps between, through which beams pass.

    A person has two legs; a chair has four as well, but they are thin.

    Args:
        echoes: From the laser, m, shape (n, 2), in the order of the beams.
        increment: From beam to beam, rad.
    """
    bearings = np.unwrap(np.arctan2(echoes[:, 1], echoes[:, 0]))
    apart = np.hypot(echoes[:-1, 0], echoes[:-1, 1]) * increment
    is_next = np.abs(np.diff(bearings)) < 1.5 * increment
    ends = np.append(apart[~is_next], np.hypot(*echoes[-1]) * increment)  # of each run, one beam that is half covered
    return float(apart[is_next].sum() + np.minimum(0.5 * ends, _THIN).sum())

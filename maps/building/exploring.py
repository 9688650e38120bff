"""Exploration: which frontier each robot of a team drives to next, doors first, until all rooms have been seen.

It decides only. Driving is the indoor navigation's: it is asked to go to a place, and says how that ended.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import dist

import numpy as np

from geometry import Point, Pose2D
from maps.building.frontiers import Frontier, frontiers
from maps.occupancy import UNKNOWN, OccupancyGrid

DOOR_BONUS = 3.0
"""m that a door may be farther than another frontier, and still comes first."""
LENGTH_BONUS = 1.0
"""m likewise for each m of a frontier, up to `LONGEST`."""
LONGEST = 3.0
SAME = 0.7
"""m between two frontiers that are the same one."""
TAKEN = 2.5
"""m from the goal of another robot within which a frontier is that robot's."""
MOST_MISSIONS = 2
"""Missions to a frontier that fail, or from which it is not seen, before it is given up."""
MOST_FAILURES = 3
"""Missions to a frontier that fail before it is given up where no other one is left; who barred a door may be gone."""
SHARED_BONUS = 4.0
"""m that a frontier nearer to another robot counts as farther away."""
LATE = 90.0
"""s after which a mission to a frontier is given up."""


class MissionStanding(StrEnum):
    """How the mission that a robot was last sent on stands."""

    NONE = "none"
    ACTIVE = "active"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class RobotSight:
    """What is known of one robot: its map, where it is in it, m and rad, and its mission."""

    grid: OccupancyGrid
    pose: Pose2D
    mission: MissionStanding


@dataclass(frozen=True, slots=True)
class ExploringOrder:
    """What a robot is to do: go to a pose in its own map, m and rad; or cancel what it does, without a pose."""

    goal: Pose2D | None


@dataclass(slots=True)
class _Member:
    """What is remembered of one robot.

    frontier: which it was sent to. looked_at, failures: middles of frontiers that were still there when it had reached
    them, and to which a mission failed; m in its own map.
    """

    frontier: Frontier | None = None
    began: float = 0.0
    looked_at: list[Point] = field(default_factory=list)
    failures: list[Point] = field(default_factory=list)
    is_finished: bool = False

    def left(self, found: Sequence[Frontier]) -> list[Frontier]:
        """Return those of the frontiers of the present map that are worth a mission."""
        tried = [(each, _times(self.failures, each), _times(self.looked_at, each)) for each in found]
        fresh = [each for each, failed, seen in tried if failed + seen < MOST_MISSIONS]
        return fresh or [each for each, failed, seen in tried if not seen and failed < MOST_FAILURES]


class Explorer:
    """Sends robots to frontiers."""

    def __init__(self, radius: float) -> None:
        """Begin. radius: m that each robot needs to either side of its middle."""
        self._radius = radius
        self._members: dict[str, _Member] = {}

    @property
    def is_finished(self) -> bool:
        """Whether no robot has a frontier left."""
        return bool(self._members) and all(member.is_finished for member in self._members.values())

    def targets(self) -> dict[str, Point]:
        """Return the frontiers that robots drive to, m in the maps of each."""
        return {name: each.frontier.middle for name, each in self._members.items() if each.frontier is not None}

    def decide(
        self, now: float, sights: Mapping[str, RobotSight], frames: Mapping[str, Pose2D] | None = None
    ) -> dict[str, ExploringOrder]:
        """Decide anew.

        Args:
            now: s, of any clock.
            sights: Of all robots that are there, by their names.
            frames: Where the maps of robots lie in one common frame, of those for which it is known.
        Returns:
            Orders for those robots that are to do something else than they do.
        """
        frames = frames or {}
        orders: dict[str, ExploringOrder] = {}
        offers: list[tuple[float, str, Frontier]] = []
        teams = {name: _Team(name, sights, frames) for name in sights}
        for name, sight in sights.items():
            member = self._members.setdefault(name, _Member())
            was_active = member.frontier is not None and sight.mission is MissionStanding.ACTIVE
            self._look(now, member, sight)
            left = member.left(frontiers(teams[name].grid(), (sight.pose.x, sight.pose.y), self._radius))
            member.is_finished = not left
            if member.frontier is not None and any(_is_of(each, member.frontier.middle) for each in left):
                continue  # it drives there, and there is still something to see
            member.frontier = None
            if was_active:
                orders[name] = ExploringOrder(None)  # unless there is something else to see
            offers += [(_cost(each) + teams[name].penalty(each), name, each) for each in left]
        for _, name, frontier in sorted(offers, key=lambda offer: offer[0]):
            member = self._members[name]
            if member.frontier is None and not self._is_taken(teams[name], frontier):
                member.frontier, member.began = frontier, now
                orders[name] = ExploringOrder(Pose2D(*frontier.goal, frontier.facing))
        return orders

    def _look(self, now: float, member: _Member, sight: RobotSight) -> None:
        """Forget a frontier to which the mission has ended, and note how it ended; it may be none any more."""
        is_late = now - member.began > LATE
        if member.frontier is not None and (is_late or sight.mission is not MissionStanding.ACTIVE):
            is_reached = sight.mission is MissionStanding.DONE
            (member.looked_at if is_reached else member.failures).append(member.frontier.middle)
            member.frontier = None

    def _is_taken(self, team: "_Team", frontier: Frontier) -> bool:
        """Whether another robot drives to about there."""
        others = ((name, self._members[name].frontier) for name in team.others if name in self._members)
        return any(
            target is not None and dist(team.own_point(name, target.middle), frontier.middle) < TAKEN
            for name, target in others
        )


class _Team:
    """One robot's view of the others whose maps lie in the same frame."""

    def __init__(self, name: str, sights: Mapping[str, RobotSight], frames: Mapping[str, Pose2D]) -> None:
        self._sight = sights[name]
        known = [other for other in sights if name in frames and other in frames and other != name]
        self.others = {other: sights[other] for other in known}
        self._frames = {other: frames[other].relative_to(frames[name]) for other in known}

    def own_point(self, name: str, point: Point) -> Point:
        """Take a point of another robot's map to the own one."""
        return self._frames[name].transform(*point)

    def grid(self) -> OccupancyGrid:
        """The own grid, and where it is unknown, what the others have seen."""
        own = self._sight.grid
        if not self.others:
            return own
        grid = _wide_enough(own, [self._corners(name) for name in self.others])
        cells = grid.cells.copy().reshape(-1)
        unknown = np.flatnonzero(cells == UNKNOWN)
        centres = grid.centres(np.ones(grid.cells.shape, np.bool_))
        for name, other in self.others.items():
            back = Pose2D().relative_to(self._frames[name])
            c, s = np.cos(back.heading), np.sin(back.heading)
            points = centres[unknown]
            points = np.stack(
                (back.x + c * points[:, 0] - s * points[:, 1], back.y + s * points[:, 0] + c * points[:, 1]), axis=1
            )
            seen = other.grid.values_at(points)
            cells[unknown] = seen
            unknown = unknown[seen == UNKNOWN]
        return replace(grid, cells=cells.reshape(grid.cells.shape))

    def penalty(self, frontier: Frontier) -> float:
        """Metres that a frontier counts as farther away because another robot is nearer to it."""
        for name, other in self.others.items():
            if dist(self.own_point(name, (other.pose.x, other.pose.y)), frontier.middle) < 0.7 * frontier.way:
                return SHARED_BONUS
        return 0.0

    def _corners(self, name: str) -> list[Point]:
        grid = self.others[name].grid
        corners = (grid.origin.transform(x, y) for x in (0.0, grid.width) for y in (0.0, grid.height))
        return [self.own_point(name, corner) for corner in corners]


def _wide_enough(grid: OccupancyGrid, corners: list[list[Point]]) -> OccupancyGrid:
    """The grid with unknown cells around it, as far as other grids reach."""
    every = np.array([corner for own in corners for corner in own])
    low = np.floor((every.min(axis=0) - (grid.origin.x, grid.origin.y)) / grid.resolution)
    high = np.ceil((every.max(axis=0) - (grid.origin.x, grid.origin.y)) / grid.resolution)
    left, below = (int(max(0.0, -each)) for each in low)
    right, above = (int(max(0.0, each - size)) for each, size in zip(high, grid.cells.shape[::-1], strict=True))
    cells = np.pad(grid.cells, ((below, above), (left, right)), constant_values=UNKNOWN)
    origin = Pose2D(grid.origin.x - left * grid.resolution, grid.origin.y - below * grid.resolution)
    return OccupancyGrid(cells, grid.resolution, origin)


def _cost(frontier: Frontier) -> float:
    return frontier.way - DOOR_BONUS * frontier.is_door - LENGTH_BONUS * min(frontier.length, LONGEST)


def _is_of(frontier: Frontier, middle: Point) -> bool:
    """Return whether the middle of a frontier that was seen before is of this one."""
    return dist(frontier.middle, middle) < SAME


def _times(middles: Sequence[Point], frontier: Frontier) -> int:
    """Return how many of the middles are of a frontier."""
    return sum(_is_of(frontier, middle) for middle in middles)

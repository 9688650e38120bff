"""A way as a sequence of sub-targets, with places before and behind each door."""

from dataclasses import dataclass
from itertools import pairwise
from math import cos, hypot, inf, pi, sin

from apps.indoor_navigation.algorithms.planning.doors_map import DoorsMap, KnownDoor
from apps.indoor_navigation.algorithms.planning.search import Way, length
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Terrain
from apps.indoor_navigation.data import Place
from geometry import wrap_angle

WIDE_ROOM = 0.17  # m on either side of the robot in a door that it can pass at any angle
THROUGH_RANGE = 0.1  # m before the place behind a narrow door from which on the robot is through
MIN_WITHIN = 0.15  # m from a line; every robot can come as near
MAX_COST_RATIO = 1.05  # of a straight line to the sub-target after the next, that replaces the next


@dataclass(frozen=True, slots=True)
class SubTarget:
    """A place on the way. door: number of the door that is passed on the way to it, or None. is_last: the way ends.

    axis: rad, direction through the door before or behind it. within: maximum distance of the robot from the line along
    the axis before it drives on, m. is_narrow: whether the door on the way to it is narrow, so that the robot drives
    straight through.
    """

    x: float
    y: float
    door: int | None = None
    is_last: bool = False
    axis: float = 0.0
    within: float = inf
    is_narrow: bool = False

    @property
    def place(self) -> Place:
        """The place in odom."""
        return self.x, self.y

    @property
    def lines_up(self) -> bool:
        """Whether the robot must line up with a door here."""
        return self.within < inf

    def is_in_line(self, robot: Place) -> bool:
        """Return whether the robot is near enough to the line."""
        return abs((robot[1] - self.y) * cos(self.axis) - (robot[0] - self.x) * sin(self.axis)) <= self.within

    def is_reached(self, robot: Place, near: float) -> bool:
        """Return whether the robot has reached it, to so many m.

        Behind a door the robot may be beside it, because it only must be through the door; behind a narrow door it must
        be through wholly, because there it has no room to turn.
        """
        left_x, left_y = self.x - robot[0], self.y - robot[1]
        if self.door is None:
            return hypot(left_x, left_y) < near
        return left_x * cos(self.axis) + left_y * sin(self.axis) < (THROUGH_RANGE if self.is_narrow else near)


@dataclass(frozen=True, slots=True)
class Route:
    """The rest of a way. ends_short: the way beyond an obstacle that may go away, before which the route ends."""

    targets: tuple[SubTarget, ...]
    ends_short: Way = ()

    @classmethod
    def along(cls, way: Way, doors: DoorsMap, terrain: Terrain, passage: "Passage") -> "Route":
        """Return the sub-targets along a way: its corners, and places before and behind each door.

        Where there is no room for such places, the robot passes the door as the way leads.
        """
        targets = [SubTarget(*place) for place in way[1:]] or [SubTarget(*way[0])]
        for start, end in pairwise(way):
            crossing = doors.crossed(start, end)
            if crossing is not None:
                targets = _through(*crossing, doors, terrain, passage, way[0], targets)
        last = targets[-1]
        return cls((*targets[:-1], SubTarget(last.x, last.y, last.door, is_last=True)))

    def points(self, robot: Place) -> Way:
        """Return the points from the robot to the end."""
        return (robot, *(target.place for target in self.targets))

    def length(self, robot: Place) -> float:
        """Return the length of the rest, m."""
        return length(self.points(robot))

    def advanced(self, terrain: Terrain, robot: Place, near: float) -> "Route":
        """Return the route without sub-targets that are not needed any more.

        The next sub-target is removed when the robot is near it, m, or when a straight line to the one after it costs
        no more; that line must be free in any case. A sub-target behind a door stays until the robot is as far behind
        the door, and one before a door until the robot is in line with the door.
        """
        targets = self.targets
        while len(targets) > 1 and _is_needless(terrain, robot, targets, near):
            targets = targets[1:]
        return Route(targets, self.ends_short)

    def shortened(self, distance: float, robot: Place) -> "Route":
        """Return a route that ends so many m from the robot, with the rest in `ends_short`."""
        points = self.points(robot)
        kept: list[SubTarget] = []
        for target, (start, end) in zip(self.targets, pairwise(points), strict=True):
            piece = length((start, end))
            if distance < piece:
                part = max(distance, 0.0) / piece
                x, y = start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
                rest = points[1 + len(kept) :]
                return Route((*kept, SubTarget(x, y, is_last=True)), ((x, y), *rest))
            kept.append(target)
            distance -= piece
        return self


@dataclass(frozen=True, slots=True)
class Passage:
    """How to pass doors. before: distance of sub-targets before and behind a door, m. half_width: of the robot, m."""

    before: float
    half_width: float

    def into(self, door: KnownDoor, direction: float) -> SubTarget:
        """Return the sub-target before a door, along its normal (1) or against it (-1)."""
        within = max(self._room(door), MIN_WITHIN) if self._room(door) < WIDE_ROOM else inf
        return SubTarget(*door.beside(0.0, -direction * self.before), axis=_axis(door, direction), within=within)

    def out_of(self, number: int, door: KnownDoor, direction: float, aside: float = 0.0) -> SubTarget:
        """Return the sub-target behind a door, so many m to the left of its middle line seen along its normal."""
        place = door.beside(aside, direction * self.before)
        return SubTarget(*place, door=number, axis=_axis(door, direction), is_narrow=self._room(door) < WIDE_ROOM)

    def _room(self, door: KnownDoor) -> float:
        """Return the room on either side of the robot in a door, m."""
        return door.width / 2.0 - self.half_width


def _through(
    number: int,
    direction: float,
    doors: DoorsMap,
    terrain: Terrain,
    passage: Passage,
    robot: Place,
    targets: list[SubTarget],
) -> list[SubTarget]:
    """Return the sub-targets with places before and behind a door; the last sub-target stays in any case."""
    door, before = doors.doors[number], passage.before
    first = [target for target in targets[:-1] if door.ahead(target.place) * direction <= 0.0]
    then = [target for target in targets[:-1] if door.ahead(target.place) * direction > 0.0]
    gone = [target for target in first if _apart(target.place, door.centre) > before]
    left = [target for target in then if _apart(target.place, door.centre) > before]
    into = [passage.into(door, direction)] if _apart((gone[-1].place if gone else robot), door.centre) > before else []
    out_of = [passage.out_of(number, door, direction)] if _apart(targets[-1].place, door.centre) > before else []
    through = [*gone, *into, *out_of, *left, targets[-1]]
    return through if terrain.cost_of(robot, *(target.place for target in through)) < BARRED else targets


def _axis(door: KnownDoor, direction: float) -> float:
    """Return the direction through a door, rad, along its normal (1) or against it (-1)."""
    return wrap_angle(door.normal + (pi if direction < 0.0 else 0.0))


def _apart(one: Place, other: Place) -> float:
    return hypot(other[0] - one[0], other[1] - one[1])


def _is_needless(terrain: Terrain, robot: Place, targets: tuple[SubTarget, ...], near: float) -> bool:
    first, second = targets[:2]
    straight = terrain.cost_of(robot, second.place)
    if straight >= BARRED or not first.is_in_line(robot):
        return False
    if first.is_reached(robot, near):
        return True
    return first.door is None and straight <= MAX_COST_RATIO * terrain.cost_of(robot, first.place, second.place)

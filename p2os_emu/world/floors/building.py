"""What the families of floors share: rooms as convex outlines, walls between them, doors, and the world made of them.

A family lays rooms side by side and says where there are doors. Walls follow from the outlines: where two rooms meet,
and round the outside. Clearance is what a passage leaves a PowerBot on each side.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from math import cos, dist, hypot, inf, pi, sin
from random import Random

from geometry import Point, Polygon, Pose2D
from p2os_emu.world.errors import WorldError
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.moving_doors import LEAF_HEIGHT, LEAF_THICKNESS, MovingDoor
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import WALL_THICKNESS, Block, DoorEntry, WallEntry, WorldSpec

HALF_WIDTH = 0.34
"""m, of a PowerBot, the widest robot."""
PASSING = HALF_WIDTH + 0.06
"""m, radius of the disc that gets from every place of a floor to every other."""
TURNING_ROOM = 0.75
"""m round each place; a PowerBot needs 0.64."""
TIGHT = (0.07, 0.15)
"""m on each side of a PowerBot in a tight passage."""
WIDE = (0.15, 0.6)
"""Likewise in the others."""
PASSAGE = "corridor"
"""Of the names of places where robots pass, at their beginning; all other places are goals."""

_DOOR_MARGIN = 0.2  # m between a door and a corner
_POST_MARGIN = 0.7  # m on the free side of a door that stands ajar, where robots turn
_AJAR = (0.87, 1.4)  # rad between a wall and the leaf of a door that stands ajar
_MOST_AJAR = 1.1  # m that such a door leaves free
_FRAME = 0.08  # m, edge of the posts at a door in glass
_TRIES = 30


class DoorKind(Enum):
    """How two rooms are connected: a gap, a leaf that slides into the wall, one that stands ajar, or no wall at all."""

    GAP = "gap"
    LEAF = "leaf"
    AJAR = "ajar"
    NO_WALL = "no wall"


@dataclass(slots=True, eq=False)
class Room:
    """A room by its outline.

    corners: convex, counter-clockwise, in the middles of the walls, m. places: where robots are sent, by name.
    gaps: the middles of its doors, and half of what they leave free, m.
    pieces: what stands in it, as boxes from the floor on.
    """

    name: str
    corners: Polygon
    places: dict[str, Point]
    gaps: list[tuple[Point, float]] = field(default_factory=list)
    pieces: list[Block] = field(default_factory=list)

    @property
    def is_passage(self) -> bool:
        """Whether robots only pass it."""
        return self.name.startswith(PASSAGE)

    @property
    def edges(self) -> Iterator[tuple[Point, Point]]:
        """Its edges, the room on their left."""
        return pairwise((*self.corners, self.corners[0]))

    def depth_of(self, point: Point) -> float:
        """How far a point lies inside, m from the nearest edge; below 0 outside."""
        return min(_beside(a, b, point) for a, b in self.edges)


@dataclass(slots=True, eq=False)
class Side:
    """The straight border from `start` to `end` between a room, on its left, and another one or the outside."""

    start: Point
    end: Point
    one: Room
    other: Room | None
    is_glass: bool = False
    has_wall: bool = True
    gaps: list[tuple[float, float]] = field(default_factory=list)

    @property
    def length(self) -> float:
        """m."""
        return dist(self.start, self.end)

    def at(self, along: float, left: float = 0.0) -> Point:
        """The point so far along it, and so far to its left, m."""
        x, y = (self.end[0] - self.start[0]) / self.length, (self.end[1] - self.start[1]) / self.length
        return self.start[0] + along * x - left * y, self.start[1] + along * y + left * x

    def blocks(self) -> Iterator[Block]:
        """Its wall, and frames at the doors of a wall of glass."""
        if not self.has_wall:
            return
        doors = tuple(DoorEntry(begin, width) for begin, width in self.gaps)
        name = "pane" if self.is_glass else "wall"
        yield from WallEntry(self.start, self.end, name, doors=doors, glass=self.is_glass).blocks()
        heading = _heading(self.start, self.end)
        for begin, width in self.gaps if self.is_glass else ():
            for along in (begin - _FRAME / 2, begin + width + _FRAME / 2):
                yield Block(*self.at(along), heading, _FRAME, WALL_THICKNESS + 0.02, LEAF_HEIGHT, "door frame")


class Building:
    """A floor in the making."""

    def __init__(self, name: str, about: str, random: Random) -> None:
        self.random = random
        self.rooms: list[Room] = []
        self.furniture: list[Block] = []
        self._name = name
        self._about = about
        self._sides: list[Side] | None = None
        self._leaves: list[MovingDoor] = []

    def add_room(self, name: str, corners: Sequence[Point], *, has_place: bool = True) -> Room:
        """Add a room; all rooms come before the first door. A place of the same name is near its middle."""
        room = Room(name, tuple(corners), {})
        if has_place:
            x, y = sum(x for x, _ in corners) / len(corners), sum(y for _, y in corners) / len(corners)
            near = ((x + self.random.gauss(0.0, 0.4), y + self.random.gauss(0.0, 0.4)) for _ in range(_TRIES))
            least = TURNING_ROOM + WALL_THICKNESS
            room.places[name] = next((point for point in near if room.depth_of(point) >= least), (x, y))
        self.rooms.append(room)
        return room

    def add_box(
        self, name: str, left: float, right: float, bottom: float, top: float, *, has_place: bool = True
    ) -> Room:
        """Add a room with right angles, from its least and its greatest x and y, m."""
        corners = (left, bottom), (right, bottom), (right, top), (left, top)
        return self.add_room(name, corners, has_place=has_place)

    def rename(self, room: Room, name: str) -> None:
        """Give a room with one place, and the place, another name."""
        (place,) = room.places.values()
        room.name, room.places = name, {name: place}

    @property
    def sides(self) -> list[Side]:
        """Every border between two rooms, and of a room to the outside."""
        if self._sides is None:
            self._sides = list(_sides(self.rooms))
        return self._sides

    def between(self, one: Room, other: Room) -> Side | None:
        """The longest border of two rooms."""
        shared = (side for side in self.sides if {side.one, side.other} == {one, other})
        return max(shared, key=lambda side: side.length, default=None)

    def neighbours(self, least: float) -> list[Side]:
        """All borders between two rooms that are so long, m."""
        return [side for side in self.sides if side.other is not None and side.length >= least]

    def tree(self, sides: Sequence[Side]) -> list[Side]:
        """Choose, by chance, borders that connect all rooms without a way round."""
        group = {id(room): number for number, room in enumerate(self.rooms)}
        chosen = []
        for side in self.random.sample(sides, len(sides)):
            one, other = group[id(side.one)], group[id(side.other)]
            if one != other:
                chosen.append(side)
                group = {room: one if number == other else number for room, number in group.items()}
        if len(set(group.values())) > 1:
            raise WorldError(f"floor {self._name!r} has rooms without neighbours")
        return chosen

    def connect(self, sides: Sequence[Side], doors: Sequence[DoorKind], tight: float) -> None:
        """Put a door into each of some borders; all doors of one room, chosen by chance, are tight.

        Args:
            sides: Between two rooms.
            doors: Kinds to choose from by chance.
            tight: Share of the other doors that are tight, too.
        """
        rooms = [room for room in self.rooms if not room.is_passage]
        degrees = {id(room): sum(room in (side.one, side.other) for side in sides) for room in rooms}
        least = min(degrees.values())
        chosen = self.random.choice([room for room in rooms if degrees[id(room)] == least])
        for side in sides:
            is_tight = chosen in (side.one, side.other) or self.random.random() < tight
            kind = self.random.choice([door for door in doors if not (is_tight and door is DoorKind.NO_WALL)])
            self.add_door(side, kind, self.random.uniform(*(TIGHT if is_tight else WIDE)))

    def add_door(self, side: Side, kind: DoorKind, clearance: float) -> None:
        """Put a door into a border; where a leaf finds no room, it becomes a gap."""
        assert side.other is not None
        if kind is DoorKind.NO_WALL:
            side.has_wall = False
            self._note(side, side.length / 2, side.length / 2)
            return
        width = 2 * (HALF_WIDTH + min(clearance, side.length / 2 - _DOOR_MARGIN - HALF_WIDTH - WALL_THICKNESS / 2))
        if kind is DoorKind.AJAR and self._leave_ajar(side, width):
            return
        turned = self.random.random() < 0.5  # the leaf is at the far end
        leaf = width if kind is DoorKind.LEAF and side.length >= 2 * (width + _DOOR_MARGIN) else 0.0
        low, high = _DOOR_MARGIN + (0.0 if turned else leaf), _DOOR_MARGIN + (leaf if turned else 0.0)
        begin = self.random.uniform(low, max(low, side.length - width - high))
        side.gaps.append((begin, width))
        self._note(side, begin + width / 2, width / 2)
        if leaf:
            ends = side.at(begin), side.at(begin + width)
            name = f"door between {side.one.name} and {side.other.name}"
            self._leaves.append(MovingDoor(name, *(ends[::-1] if turned else ends)))

    def _note(self, side: Side, along: float, half_width: float) -> None:
        for room in (side.one, side.other):
            assert room is not None
            room.gaps.append((side.at(along), half_width))

    def _leave_ajar(self, side: Side, clear: float) -> bool:
        """Hang a leaf that stands ajar and leaves so much, m; return False where there is no room for it."""
        assert side.other is not None
        angle = self.random.uniform(*_AJAR)
        clear = min(clear, _MOST_AJAR)
        width = (clear + LEAF_THICKNESS) / sin(angle)
        turned, inward = self.random.random() < 0.5, self.random.choice((1, -1))
        room = side.one if inward > 0 else side.other
        low, high = (_POST_MARGIN, _DOOR_MARGIN) if turned else (_DOOR_MARGIN, _POST_MARGIN)
        if side.length - width < low + high:
            return False
        begin = self.random.uniform(low, side.length - width - high)
        hinge, sense = (begin + width, -1) if turned else (begin, 1)
        behind = side.at(hinge + sense * cos(angle) * width, inward * (sin(angle) * width + 2 * PASSING))
        if room.depth_of(behind) < WALL_THICKNESS:
            return False
        middle = side.at(hinge + sense * cos(angle) * width / 2, inward * sin(angle) * width / 2)
        heading = _heading(side.at(hinge), middle)
        leaf = Block(
            *middle, heading, width - 0.04, LEAF_THICKNESS, LEAF_HEIGHT, "door that stands ajar", colour="wood"
        )
        side.gaps.append((begin, width))
        self._note(side, begin + width / 2, clear / 2)
        if not self.is_passable(room, [leaf]):
            side.gaps.pop()
            side.one.gaps.pop()
            side.other.gaps.pop()
            return False
        room.pieces.append(leaf)
        self.furniture.append(leaf)
        return True

    def is_passable(self, room: Room, more: Sequence[Block] = (), radius: float = inf) -> bool:
        """Return whether robots get from each door of a room to every other and to its places, and turn there.

        Args:
            room: With its pieces.
            more: Pieces that may come.
            radius: Of the disc that has to pass, m; where a door is narrower, one that passes the door.
        """
        pieces = (*room.pieces, *more)
        turning = FreeSpace(WorldSpec("", furniture=pieces), TURNING_ROOM)
        if not all(turning.is_free(place) for place in room.places.values()):
            return False
        radius = min(radius, *(half_width - 0.002 for _, half_width in room.gaps))
        points = [*(point for point, _ in room.gaps), *room.places.values()]
        return are_connected(
            FreeSpace(WorldSpec("", walls=self._walls_of(room, radius), furniture=pieces), radius), points
        )

    def _walls_of(self, room: Room, radius: float) -> tuple[Block, ...]:
        """The walls round a room; its doors are closed outside, where a disc in them ends."""
        walls: list[Block] = []
        far = radius + 0.06
        for side in self.sides:
            if room not in (side.one, side.other):
                continue
            walls += side.blocks()
            out = -far if room is side.one else far
            gaps = side.gaps if side.has_wall else [(0.0, side.length)]
            for begin, width in gaps:
                middle = side.at(begin + width / 2, out)
                walls.append(Block(*middle, _heading(side.start, side.end), width + 2 * far, 0.1, 1.0))
        return tuple(walls)

    def spec(self) -> WorldSpec:
        """The world."""
        places = {name: place for room in self.rooms for name, place in room.places.items()}
        return WorldSpec(
            self._name,
            self._about,
            tuple(block for side in self.sides for block in side.blocks()),
            tuple(self.furniture),
            tuple(Pose2D(x, y, self.random.uniform(-pi, pi)) for x, y in places.values()),
            places=places,
            moving_doors=tuple(self._leaves),
        )


def cuts(random: Random, low: float, high: float, parts: int, unevenness: float = 0.15) -> list[float]:
    """Cut a length into parts, all nearly as long; returns where, with both ends."""
    shares = [random.uniform(1 - unevenness, 1 + unevenness) for _ in range(parts)]
    return [low + (high - low) * sum(shares[:number]) / sum(shares) for number in range(parts + 1)]


def _sides(rooms: Sequence[Room]) -> Iterator[Side]:
    for number, room in enumerate(rooms):
        for a, b in room.edges:
            covered = []
            for index, other in enumerate(rooms):
                for c, d in other.edges if other is not room else ():
                    low, high = _shared(a, b, c, d)
                    if high - low > WALL_THICKNESS:
                        covered.append((low, high))
                        if index > number:
                            yield Side(_along(a, b, low), _along(a, b, high), room, other)
            begin = 0.0
            for low, high in (*sorted(covered), (dist(a, b), dist(a, b))):
                if low - begin > WALL_THICKNESS:
                    yield Side(_along(a, b, begin), _along(a, b, low), room, None)
                begin = max(begin, high)


def _shared(a: Point, b: Point, c: Point, d: Point) -> tuple[float, float]:
    """From where to where along a to b the edge c to d of another room runs, which goes the other way, m."""
    if max(abs(_beside(a, b, c)), abs(_beside(a, b, d))) > 1e-6:
        return 0.0, 0.0
    length = dist(a, b)
    start, end = (((point[0] - a[0]) * (b[0] - a[0]) + (point[1] - a[1]) * (b[1] - a[1])) / length for point in (d, c))
    return max(0.0, start), min(length, end)


def _beside(a: Point, b: Point, point: Point) -> float:
    """How far a point lies to the left of the line from a to b, m."""
    cross = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    return cross / hypot(b[0] - a[0], b[1] - a[1])


def _along(a: Point, b: Point, far: float) -> Point:
    share = far / dist(a, b)
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def _heading(a: Point, b: Point) -> float:
    return Pose2D(*a).bearing_to(*b)

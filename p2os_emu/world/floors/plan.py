"""Random floor plans by a seed: rooms on both sides of a corridor, with doors, furniture and named places.

Every plan can be driven: a disc of `conditions.RADIUS` gets from every place to every other, and every place and the
inside of every door has room to turn. At least two rooms share a door of their own, so that there are two ways.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from random import Random

from geometry import Point, Pose2D, polygons_overlap
from p2os_emu.world.errors import WorldError
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import Block, DoorEntry, WallEntry, WorldSpec

ABOUT = "rooms along a corridor"
ROOMS = 6
MOST_ROOMS = 20
ROOM_LENGTHS = (3.8, 4.8)  # m along the corridor, on average
UNEVENNESS = 0.12  # of a room's length
ROOM_DEPTHS = (3.4, 5.0)
CORRIDOR_WIDTHS = (1.8, 2.4)
DOOR_WIDTHS = (0.95, 1.2)
DOOR_MARGIN = 0.2  # m between a door and a corner; the leaf goes the other way and needs its own width there
SHARED_DOORS = 0.4  # of the walls between rooms
TURNING_ROOM = 0.75  # m round each place; a PowerBot needs 0.64
BEFORE_DOORS = 0.6  # m from the wall to where a robot stands inside a room
PIECES = (2, 4)  # in each room
TRIES = 12  # for each piece
PASSAGE = 0.5  # m, radius of the disc that gets from every door of a room to its place, between the furniture
WALL_GAP = 0.08  # m from the middle of a wall to what stands at it
FURNITURE = (
    ("cupboard", (0.8, 1.6), (0.35, 0.5), 1.8, "white", True),
    ("desk", (1.2, 1.8), (0.6, 0.8), 0.74, "wood", True),
    ("sofa", (1.6, 2.0), (0.8, 0.9), 0.8, "red", True),
    ("chest", (0.5, 0.9), (0.4, 0.6), 0.6, "brown", True),
    ("table", (0.8, 1.4), (0.7, 0.9), 0.74, "wood", False),
    ("chair", (0.4, 0.5), (0.4, 0.5), 0.9, "teal", False),
    ("plant", (0.3, 0.4), (0.3, 0.4), 1.2, "green", True),
)
"""Name, length, width, height (m), colour, and whether it stands at a wall."""


@dataclass(frozen=True, slots=True)
class _Room:
    """A room between the middles of its walls, m, with its place and where one stands inside its doors."""

    name: str
    left: float
    right: float
    bottom: float
    top: float
    place: Point
    insides: tuple[Point, ...] = ()

    def walls(self) -> tuple[Block, ...]:
        """Its walls without doors."""
        corners = (
            (self.left, self.bottom),
            (self.right, self.bottom),
            (self.right, self.top),
            (self.left, self.top),
        )
        return tuple(
            block for a, b in zip(corners, corners[1:] + corners[:1], strict=True) for block in WallEntry(a, b).blocks()
        )


def floor_plan(seed: int, *, rooms: int = ROOMS) -> WorldSpec:
    """Make up a plan. The corridor runs along x, rooms lie below and above it.

    Args:
        seed: Same seed, same plan.
        rooms: How many, from 2 to `MOST_ROOMS`.
    Returns:
        A world with a place for every room ("room-1") and one for the corridor ("corridor"), starts at the places, and
        a leaf in every door ("door of room-1", "door between room-1 and room-2") that stands open until it is told.
    Raises:
        WorldError: There cannot be so many rooms.
    """
    if not 2 <= rooms <= MOST_ROOMS:
        raise WorldError(f"a floor plan has from 2 to {MOST_ROOMS} rooms, not {rooms}")
    return _Plan(seed, rooms).spec()


class _Plan:
    """A plan in the making."""

    def __init__(self, seed: int, rooms: int) -> None:
        self._name = f"plan:{seed}"
        self._random = Random(f"{seed} floor plan of {rooms}")
        self._walls: list[WallEntry] = []
        self._leaves: list[MovingDoor] = []
        above = rooms // 2
        below = rooms - above
        self._length = self._random.uniform(*ROOM_LENGTHS) * below
        depth, width = self._random.uniform(*ROOM_DEPTHS), self._random.uniform(*CORRIDOR_WIDTHS)
        top = depth + width + self._random.uniform(*ROOM_DEPTHS)
        self._corridor = depth, depth + width
        self._rooms = self._row(1, below, 0.0, depth) + self._row(below + 1, above, depth + width, top)
        for name, a, b in (
            ("south wall", (0.0, 0.0), (self._length, 0.0)),
            ("east wall", (self._length, 0.0), (self._length, top)),
            ("north wall", (self._length, top), (0.0, top)),
            ("west wall", (0.0, top), (0.0, 0.0)),
        ):
            self._walls.append(WallEntry(a, b, name))
        self._add_doors_to_the_corridor()
        self._add_doors_between()

    def spec(self) -> WorldSpec:
        """The plan with its furniture."""
        places = {room.name: room.place for room in self._rooms}
        places["corridor"] = self._length / 2, sum(self._corridor) / 2
        return WorldSpec(
            self._name,
            f"{len(self._rooms)} rooms along a corridor, made up",
            tuple(block for wall in self._walls for block in wall.blocks()),
            tuple(piece for room in self._rooms for piece in self._furnish(room)),
            tuple(Pose2D(x, y, self._random.uniform(-pi, pi)) for x, y in places.values()),
            places=places,
            moving_doors=tuple(self._leaves),
        )

    def _row(self, first: int, count: int, bottom: float, top: float) -> list[_Room]:
        """Rooms side by side over the whole length."""
        shares = [self._random.uniform(1 - UNEVENNESS, 1 + UNEVENNESS) for _ in range(count)]
        edges = [self._length * sum(shares[:i]) / sum(shares) for i in range(count + 1)]
        rooms = []
        for number, (left, right) in enumerate(pairwise(edges), first):
            x = (left + right) / 2 + self._random.uniform(-0.3, 0.3)
            y = (bottom + top) / 2 + self._random.uniform(-0.3, 0.3)
            rooms.append(_Room(f"room-{number}", left, right, bottom, top, (x, y)))
        return rooms

    def _add_doors_to_the_corridor(self) -> None:
        for y, inward in zip(self._corridor, (-1, 1), strict=True):
            doors = []
            for index, room in enumerate(self._rooms):
                if y in (room.bottom, room.top):
                    begin, width, opens_down = self._gap(room.right - room.left)
                    begin += room.left
                    doors.append(DoorEntry(begin, width))
                    ends = (begin, y), (begin + width, y)
                    self._leaves.append(MovingDoor(f"door of {room.name}", *(ends if opens_down else ends[::-1])))
                    inside = begin + width / 2, y + inward * BEFORE_DOORS
                    self._rooms[index] = replace(room, insides=(*room.insides, inside))
            self._walls.append(WallEntry((0.0, y), (self._length, y), "corridor", doors=tuple(doors)))

    def _add_doors_between(self) -> None:
        """Walls between neighbours, some with a door; one at least, where there are neighbours."""
        pairs = [i for i, (a, b) in enumerate(pairwise(self._rooms)) if a.right == b.left]
        chosen = {i for i in pairs if self._random.random() < SHARED_DOORS}
        if pairs and not chosen:
            chosen = {self._random.choice(pairs)}
        for i in pairs:
            self._wall_between(i, has_door=i in chosen)

    def _wall_between(self, index: int, *, has_door: bool) -> None:
        one, other = self._rooms[index : index + 2]
        x, bottom, name = one.right, one.bottom, f"between {one.name} and {other.name}"
        doors: tuple[DoorEntry, ...] = ()
        if has_door:
            begin, width, opens_down = self._gap(one.top - bottom)
            doors = (DoorEntry(begin, width),)
            ends = (x, bottom + begin), (x, bottom + begin + width)
            self._leaves.append(MovingDoor(f"door {name}", *(ends if opens_down else ends[::-1])))
            middle = bottom + begin + width / 2
            self._rooms[index] = replace(one, insides=(*one.insides, (x - BEFORE_DOORS, middle)))
            self._rooms[index + 1] = replace(other, insides=(*other.insides, (x + BEFORE_DOORS, middle)))
        self._walls.append(WallEntry((x, bottom), (x, one.top), f"wall {name}", doors=doors))

    def _gap(self, length: float) -> tuple[float, float, bool]:
        """A door in a wall: where it begins, how wide it is, whether its leaf opens towards the wall's beginning."""
        width = self._random.uniform(*DOOR_WIDTHS)
        opens_down = self._random.random() < 0.5
        near, far = DOOR_MARGIN, width + DOOR_MARGIN
        low, high = (far, near) if opens_down else (near, far)
        return self._random.uniform(low, length - width - high), width, opens_down

    def _furnish(self, room: _Room) -> list[Block]:
        """Furniture that leaves every door and the place of a room within reach of each other."""
        pieces: list[Block] = []
        for _ in range(self._random.randint(*PIECES)):
            candidates = (self._piece(room) for _ in range(TRIES))
            fitting = (piece for piece in candidates if _leaves_room(room, [*pieces, piece]))
            pieces += [piece for piece in (next(fitting, None),) if piece]
        return pieces

    def _piece(self, room: _Room) -> Block:
        name, lengths, widths, height, colour, at_wall = self._random.choice(FURNITURE)
        length, width = self._random.uniform(*lengths), self._random.uniform(*widths)
        if not at_wall:
            x = self._random.uniform(room.left + 1.0, room.right - 1.0)
            y = self._random.uniform(room.bottom + 1.0, room.top - 1.0)
            return Block(x, y, self._random.uniform(-pi, pi), length, width, height, name, colour=colour)
        if self._random.random() < 0.5:
            x = self._random.uniform(room.left + WALL_GAP + length / 2, room.right - WALL_GAP - length / 2)
            y = self._random.choice((room.bottom + WALL_GAP + width / 2, room.top - WALL_GAP - width / 2))
            return Block(x, y, 0.0, length, width, height, name, colour=colour)
        x = self._random.choice((room.left + WALL_GAP + width / 2, room.right - WALL_GAP - width / 2))
        y = self._random.uniform(room.bottom + WALL_GAP + length / 2, room.top - WALL_GAP - length / 2)
        return Block(x, y, pi / 2, length, width, height, name, colour=colour)


def _leaves_room(room: _Room, pieces: Sequence[Block]) -> bool:
    """Return whether the last piece overlaps no other, and a robot still gets everywhere in the room."""
    last = pieces[-1].footprint
    if any(polygons_overlap(last, piece.footprint) for piece in pieces[:-1]):
        return False
    if not FreeSpace(WorldSpec("", furniture=tuple(pieces)), TURNING_ROOM).is_free(room.place):
        return False
    inside = WorldSpec("", walls=room.walls(), furniture=tuple(pieces))
    return are_connected(FreeSpace(inside, PASSAGE), (room.place, *room.insides))

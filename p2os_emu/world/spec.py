"""Worlds as data: walls, objects, places where robots start, and routes.

A world comes from a `configs/worlds` file or from an ARIA `.map` file, and is a value: `World` builds physics from it.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from geometry import Point, Polygon, Pose2D, Segment
from p2os_emu.world.colours import check_colour
from p2os_emu.world.docks import Dock
from p2os_emu.world.floor import Floor
from p2os_emu.world.light import Light
from p2os_emu.world.magnets import Magnet
from p2os_emu.world.movable import Movable
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.people import Person
from p2os_emu.world.textures import Textures

WALL_THICKNESS = 0.1
WALL_HEIGHT = 2.0
WALL_COLOUR = "cream"


@dataclass(frozen=True, slots=True)
class Block:
    """A box that does not move: centre (m), heading of its length (rad), size (m).

    reflector: it throws light back where it came from, as the marks do that scanners steer by.
    colour: one of `colours.COLOURS`.
    bottom: m above the floor; the box reaches from there to `bottom` + `height`.
    glass: light passes through it, so scanners, infrared sensors and cameras miss it; sonar hears it, robots touch it.
    board: inner corners along and up of the chessboard on its long sides, one less than squares; (0, 0) for none.
    """

    x: float
    y: float
    heading: float
    length: float
    width: float
    height: float
    name: str = ""
    reflector: bool = False
    colour: str = WALL_COLOUR
    bottom: float = 0.0
    glass: bool = False
    board: tuple[int, int] = (0, 0)

    @property
    def top(self) -> float:
        """Height of the upper side above the floor, m."""
        return self.bottom + self.height

    @property
    def square(self) -> float:
        """Edge of a square of its chessboard, m: around the board is a margin as wide as a square."""
        columns, rows = self.board
        return min(self.length / (columns + 3), self.height / (rows + 3))

    def crosses(self, height: float) -> bool:
        """Return whether part of the block is so high above the floor, m."""
        return self.bottom <= height <= self.top

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point of the floor lies under the block."""
        along, across = Pose2D(self.x, self.y, self.heading).locate(x, y)
        return abs(along) <= self.length / 2 and abs(across) <= self.width / 2

    @property
    def footprint(self) -> Polygon:
        """The four corners on the floor, counter-clockwise, m."""
        return rectangle(Pose2D(self.x, self.y, self.heading), self.length / 2, self.length / 2, self.width)


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """A world to build.

    walls, furniture: boxes that do not move.
    starts: where robots begin, best place first; never empty.
    routes: named lists of waypoints, m; a round trip ends where it begins.
    objects: what can be pushed and gripped. drops: where the floor ends, as at stairs that go down; of no height.
    places: named points, m, for those who send robots somewhere. people: who walks about.
    moving_doors: leaves that open and shut in gaps of walls.
    textures: of walls and furniture. light: how it changes; None where it never does.
    docks: where robots are charged.
    note: how it differs from its file, a sentence for people; empty where it does not.
    """

    name: str
    about: str = ""
    walls: tuple[Block, ...] = ()
    furniture: tuple[Block, ...] = ()
    starts: tuple[Pose2D, ...] = (Pose2D(),)
    routes: Mapping[str, tuple[Point, ...]] = field(default_factory=dict)
    objects: tuple[Movable, ...] = ()
    drops: tuple[Block, ...] = ()
    magnets: tuple[Magnet, ...] = ()
    floor: Floor = field(default_factory=Floor)
    places: Mapping[str, Point] = field(default_factory=dict)
    people: tuple[Person, ...] = ()
    moving_doors: tuple[MovingDoor, ...] = ()
    note: str = ""
    textures: Textures = field(default_factory=Textures)
    light: Light | None = None
    docks: tuple[Dock, ...] = ()

    @property
    def middle(self) -> tuple[float, float, float]:
        """Centre and greatest extent of what stands there, m; the first start where nothing does."""
        corners = [corner for block in (*self.walls, *self.furniture) for corner in block.footprint]
        if not corners:
            return self.starts[0].x, self.starts[0].y, 0.0
        xs, ys = [x for x, _ in corners], [y for _, y in corners]
        return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2, max(max(xs) - min(xs), max(ys) - min(ys))


def rectangle(pose: Pose2D, front: float, rear: float, width: float) -> Polygon:
    """Corners of a rectangle that reaches `front` ahead of a pose, `rear` behind it and half `width` to each side."""
    half = width / 2
    return tuple(pose.transform(x, y) for x, y in ((-rear, -half), (front, -half), (front, half), (-rear, half)))


@dataclass(frozen=True, slots=True)
class DoorEntry:
    """A gap in a wall: from `at_m` along the wall, `width_m` wide."""

    at_m: float
    width_m: float = 0.9


@dataclass(frozen=True, slots=True)
class WallEntry:
    """A straight wall along its centre line; the doors are left out of it."""

    from_m: tuple[float, float]
    to_m: tuple[float, float]
    name: str = ""
    thickness_m: float = WALL_THICKNESS
    height_m: float = WALL_HEIGHT
    doors: tuple[DoorEntry, ...] = ()
    reflector: bool = False
    colour: str = WALL_COLOUR
    glass: bool = False

    def blocks(self) -> Iterator[Block]:
        """The wall cut at its doors; it reaches half its thickness beyond its ends, so that corners close."""
        line = Segment(*self.from_m, *self.to_m)
        check_colour(self.colour)
        if not min(line.length, self.thickness_m, self.height_m) > 0.0:
            raise ValueError("length, thickness and height must be above 0 m")
        begin = -self.thickness_m / 2
        for door in sorted(self.doors, key=lambda each: each.at_m):
            if not (door.width_m > 0.0 and max(begin, 0.0) <= door.at_m <= line.length - door.width_m):
                raise ValueError(f"a door of {door.width_m} m at {door.at_m} m does not fit the wall")
            yield self._block(line, begin, door.at_m)
            begin = door.at_m + door.width_m
        yield self._block(line, begin, line.length + self.thickness_m / 2)

    def _block(self, line: Segment, begin: float, end: float) -> Block:
        heading = math.atan2(line.y2 - line.y1, line.x2 - line.x1)
        x, y = Pose2D(line.x1, line.y1, heading).transform((begin + end) / 2, 0.0)
        size = end - begin, self.thickness_m, self.height_m
        return Block(x, y, heading, *size, self.name, self.reflector, self.colour, glass=self.glass)

"""Furniture of generated floors, on thin legs or down to the floor, put where robots still pass."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import pi
from random import Random
from typing import NamedTuple

from geometry import Point, Pose2D, polygons_overlap
from p2os_emu.world.floors.building import HALF_WIDTH, Building, Room
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.spec import WALL_THICKNESS, Block, WorldSpec
from p2os_emu.world.tables import TableEntry

EASE = (0.065, 0.35)
"""m on each side of a PowerBot between the pieces of a room, where its doors leave as much."""

_WALL_GAP = 0.03  # m between a wall and what stands at it
_BEFORE_DOORS = 0.55  # m from a door to the middle of the circle that no piece stands in
_DOOR_CIRCLE = 0.45  # m
_TRIES = 12  # for each piece


class Piece(NamedTuple):
    """Furniture at the origin, its back towards -y. size: length along x and depth along y, m. blocks: what it is."""

    size: tuple[float, float]
    blocks: tuple[Block, ...]

    def at(self, pose: Pose2D) -> "Piece":
        """The piece at a pose of its middle."""
        return Piece(self.size, tuple(_moved(block, pose) for block in self.blocks))

    @property
    def outlines(self) -> list[Block]:
        """What robots pass beside; legs are below the tops that they carry."""
        return [block for block in self.blocks if block.bottom > 0.0] or list(self.blocks)


Make = Callable[[Random], Piece]


def _solid(
    name: str, lengths: tuple[float, float], depths: tuple[float, float], height: float, colour: str = "brown"
) -> Make:
    """Return what makes boxes that reach down to the floor, m."""

    def make(random: Random) -> Piece:
        size = random.uniform(*lengths), random.uniform(*depths)
        return Piece(size, (Block(0.0, 0.0, 0.0, *size, height, name, colour=colour),))

    return make


def table(
    name: str,
    lengths: tuple[float, float],
    depths: tuple[float, float],
    height: float = 0.74,
    legs: tuple[float, float] = (0.03, 0.06),
    colour: str = "wood",
) -> Make:
    """Return what makes tables, or chairs, with four legs of some thickness, m."""

    def make(random: Random) -> Piece:
        size = random.uniform(*lengths), random.uniform(*depths)
        return Piece(size, TableEntry((0.0, 0.0), size, height, random.uniform(*legs), name, 0.0, colour).blocks())

    return make


def _with_chairs(make: Make, sides: Sequence[int]) -> Make:
    """Return what makes tables with chairs, some pulled out: one (1) or several at the front, and at the back (-1)."""

    def make_all(random: Random) -> Piece:
        middle = make(random)
        blocks, half = list(middle.blocks), middle.size[1] / 2
        for side in sides:
            seat = chair(random)
            x = random.uniform(-0.5, 0.5) * (middle.size[0] - seat.size[0])
            y = side * (half + random.uniform(-0.05, 0.35))
            blocks += seat.at(Pose2D(x, y, random.gauss(0.0, 0.25))).blocks
        return Piece((middle.size[0], middle.size[1] + (0.5 if 1 in sides else 0.0)), tuple(blocks))

    return make_all


chair = table("chair", (0.4, 0.48), (0.4, 0.48), 0.46, (0.02, 0.035), "teal")
cupboard = _solid("cupboard", (0.8, 1.6), (0.35, 0.55), 1.8, "white")
chest = _solid("chest", (0.5, 1.0), (0.4, 0.6), 0.7)
plant = _solid("plant", (0.3, 0.45), (0.3, 0.45), 1.2, "green")
sofa = _solid("sofa", (1.6, 2.1), (0.8, 0.95), 0.8, "red")
bed = _solid("bed", (1.9, 2.1), (0.9, 1.6), 0.5, "blue")
box = _solid("box", (0.25, 0.6), (0.25, 0.6), 0.5, "orange")
stool = table("stool", (0.3, 0.36), (0.3, 0.36), 0.5, (0.02, 0.03), "purple")
desk = _with_chairs(table("desk", (1.2, 1.8), (0.7, 0.8)), (1,))
dining = _with_chairs(table("table", (1.0, 1.6), (0.8, 0.9)), (1, -1, 1, -1))
small_table = table("small table", (0.5, 0.8), (0.5, 0.6), 0.5)


def shelf(random: Random) -> Piece:
    """A board on a wall, above the heads of low robots."""
    size = random.uniform(0.8, 1.5), 0.3
    return Piece(size, (Block(0.0, 0.0, 0.0, *size, 0.3, "shelf", colour="wood", bottom=random.uniform(0.8, 1.3)),))


AT_WALLS_OF_OFFICES: tuple[Make, ...] = (desk, desk, desk, cupboard, cupboard, shelf, chest, plant)
AT_WALLS_OF_HOMES: tuple[Make, ...] = (sofa, bed, cupboard, chest, desk, shelf, plant)
ANYWHERE: tuple[Make, ...] = (chair, small_table, plant)
CLUTTER: tuple[Make, ...] = (box, box, chair, chair, stool, small_table, plant)


def furnish(
    building: Building, room: Room, at_walls: Sequence[Make], inside: Sequence[Make], counts: Iterable[int]
) -> None:
    """Put pieces at the walls of a room and then inside of it, as many as counted where there is room for them.

    Every door and the places of the room stay within reach of each other, for a disc that is drawn by chance.
    """
    random = building.random
    radius = HALF_WIDTH + random.uniform(*EASE)
    before = [point for gap, _ in room.gaps if (point := _before(room, gap)) is not None]
    for makes, count, place in zip((at_walls, inside), counts, (_at_wall, _inside), strict=True):
        for _ in range(count):
            candidates = (random.choice(makes)(random) for _ in range(_TRIES))
            for piece in (each.at(pose) for each in candidates for pose in place(room, each, random)):
                if _fits(room, piece, before) and building.is_passable(room, piece.outlines, radius):
                    room.pieces += piece.outlines
                    building.furniture += piece.blocks
                    break


def _fits(room: Room, piece: Piece, before: Sequence[Point]) -> bool:
    """Return whether a piece is inside of a room, beside all others, and not right before a door."""
    least = WALL_THICKNESS / 2
    outlines = [block.footprint for block in piece.outlines]
    if any(room.depth_of(corner) < least for outline in outlines for corner in outline):
        return False
    if any(polygons_overlap(outline, other.footprint) for outline in outlines for other in room.pieces):
        return False
    space = FreeSpace(WorldSpec("", furniture=tuple(piece.outlines)), _DOOR_CIRCLE)
    return all(space.is_free(point) for point in before)


def _before(room: Room, gap: Point) -> Point | None:
    """Where robots stand that come in by a door: inside, as far from the wall as `_BEFORE_DOORS`."""
    for (x1, y1), (x2, y2) in room.edges:
        pose = Pose2D(x1, y1, Pose2D(x1, y1).bearing_to(x2, y2))
        along, left = pose.locate(*gap)
        if abs(left) < 1e-6 and along > 0.0:
            inside = pose.transform(along, _BEFORE_DOORS)
            if room.depth_of(inside) > 0.0:
                return inside
    return None


def _at_wall(room: Room, piece: Piece, random: Random) -> Iterator[Pose2D]:
    """A pose with the back to a wall, if the wall is long enough."""
    (x1, y1), (x2, y2) = random.choice(list(room.edges))
    pose = Pose2D(x1, y1, Pose2D(x1, y1).bearing_to(x2, y2))
    length = pose.locate(x2, y2)[0]
    margin = WALL_THICKNESS / 2 + piece.size[0] / 2 + _WALL_GAP
    if length > 2 * margin:
        back = max(-block.y + block.width / 2 for block in piece.outlines[:1])
        x, y = pose.transform(random.uniform(margin, length - margin), WALL_THICKNESS / 2 + _WALL_GAP + back)
        yield Pose2D(x, y, pose.heading)


def _inside(room: Room, piece: Piece, random: Random) -> Iterator[Pose2D]:
    """A pose somewhere in the room."""
    xs, ys = [x for x, _ in room.corners], [y for _, y in room.corners]
    yield Pose2D(random.uniform(min(xs), max(xs)), random.uniform(min(ys), max(ys)), random.uniform(-pi, pi))


def _moved(block: Block, pose: Pose2D) -> Block:
    there = pose.compose(Pose2D(block.x, block.y, block.heading))
    return replace(block, x=there.x, y=there.y, heading=there.heading)

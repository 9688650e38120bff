"""Rooms with patterns on all surfaces and light that changes, by a seed: where robots drive by what they see."""

from dataclasses import replace
from math import pi
from random import Random

from geometry import Pose2D
from p2os_emu.world import Block, WorldSpec
from p2os_emu.world.floor import Floor, Texture
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.light import Light
from p2os_emu.world.shortest_path import are_connected
from p2os_emu.world.spec import WallEntry
from p2os_emu.world.textures import Pattern, Textures

LENGTHS, DEPTHS = (7.0, 10.0), (6.0, 8.0)  # m
PIECES = (5, 9)
SCREENS = (0, 2)  # walls that end within the room
PASSAGE = 1.2  # m between any two things that do not stand at each other
HEIGHTS = (1.0, 1.9)  # m of furniture: higher than the camera, as the method needs
FREE_START = 0.7  # m about the start
FLOORS = ((Texture.CARPET, 0.5), (Texture.CHECKER, 0.4), (Texture.PLANKS, 0.15), (Texture.TILES, 0.3))
FLOOR_COLOURS = (("light grey", "dark grey"), ("cream", "brown"), ("grey", "white"), ("wood", "brown"))
COLOURS = ("wood", "brown", "cream", "teal", "orange", "red", "white", "yellow")
_TRIES = 60


def textured_room(seed: int) -> WorldSpec:
    """Return a room with furniture; the same seed gives the same room.

    A disc of `PASSAGE` gets everywhere between the pieces, which stand at walls or free.
    """
    rng = Random(f"{seed} textured room")
    length, depth = rng.uniform(*LENGTHS), rng.uniform(*DEPTHS)
    corners = ((0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth))
    names = ("south wall", "east wall", "north wall", "west wall")
    walls = [
        block
        for name, begin, end in zip(names, corners, corners[1:] + corners[:1], strict=True)
        for block in WallEntry(begin, end, name).blocks()
    ]
    for _ in range(rng.randint(*SCREENS)):
        walls += _screen(rng, length, depth)
    texture, pattern = rng.choice(FLOORS)
    spec = WorldSpec(
        f"textured room {seed}",
        walls=tuple(walls),
        floor=Floor(texture, *rng.choice(FLOOR_COLOURS), pattern),
        textures=Textures(
            (Pattern.BRICKS, Pattern.POSTERS, Pattern.PLASTER, Pattern.WOOD),
            (Pattern.WOOD, Pattern.CLOTH, Pattern.POSTERS),
        ),
        light=Light(drift=0.2, turn_deg=40.0, period_s=30.0),
    )
    for _ in range(rng.randint(*PIECES)):
        spec = _with_piece(rng, spec, length, depth)
    return replace(spec, starts=(_start(rng, spec, length, depth),))


def _screen(rng: Random, length: float, depth: float) -> list[Block]:
    """A wall from the south or north wall to near the middle."""
    x = rng.uniform(0.3, 0.7) * length
    reach = rng.uniform(0.25, 0.45) * depth
    begin, end = ((x, 0.0), (x, reach)) if rng.random() < 0.5 else ((x, depth), (x, depth - reach))
    return list(WallEntry(begin, end, "screen").blocks())


def _with_piece(rng: Random, spec: WorldSpec, length: float, depth: float) -> WorldSpec:
    """Return the room with one piece more, or as it is if there is no room for any."""
    for _ in range(_TRIES):
        long, wide = rng.uniform(0.4, 1.6), rng.uniform(0.35, 0.8)
        height, colour = rng.uniform(*HEIGHTS), rng.choice(COLOURS)
        if rng.random() < 0.6:  # at a wall, with its length along it
            gap = 0.05 + wide / 2.0 + 0.03
            side = rng.randrange(4)
            along = rng.uniform(long / 2.0 + 0.1, (length if side % 2 == 0 else depth) - long / 2.0 - 0.1)
            x, y = ((along, gap), (length - gap, along), (along, depth - gap), (gap, along))[side]
            heading = pi / 2 * (side % 2)
        else:
            x, y = rng.uniform(1.0, length - 1.0), rng.uniform(1.0, depth - 1.0)
            heading = rng.uniform(-pi, pi)
        piece = Block(x, y, heading, long, wide, height, f"piece {len(spec.furniture)}", colour=colour)
        more = replace(spec, furniture=(*spec.furniture, piece))
        if _is_passable(more, piece, spec, length, depth):
            return more
    return spec


def _is_passable(more: WorldSpec, piece: Block, spec: WorldSpec, length: float, depth: float) -> bool:
    """Return whether passages beside a piece are wide, and the whole floor stays connected."""
    others = [*spec.furniture, *(wall for wall in spec.walls if wall.name == "screen")]
    for other in others:
        alone = FreeSpace(replace(spec, walls=(), furniture=(other,)), PASSAGE)
        if not all(alone.is_free(corner) for corner in _outline(piece)):
            return False
    room = FreeSpace(replace(spec, walls=tuple(w for w in spec.walls if w.name != "screen"), furniture=()), PASSAGE)
    is_at_wall = min(piece.x, piece.y, length - piece.x, depth - piece.y) < 0.6
    if not is_at_wall and not all(room.is_free(corner) for corner in _outline(piece)):
        return False
    space = FreeSpace(more, PASSAGE / 2.0 - 0.02)
    grid = [(x * 0.5, y * 0.5) for x in range(1, int(length * 2)) for y in range(1, int(depth * 2))]
    free = [place for place in grid if space.is_free(place)]
    return bool(free) and are_connected(space, free)


def _outline(piece: Block) -> list[tuple[float, float]]:
    """Corners and middles of the edges."""
    corners = piece.footprint
    ends = corners[1:] + corners[:1]
    return [*corners, *(((ax + bx) / 2.0, (ay + by) / 2.0) for (ax, ay), (bx, by) in zip(corners, ends, strict=True))]


def _start(rng: Random, spec: WorldSpec, length: float, depth: float) -> Pose2D:
    space = FreeSpace(spec, FREE_START)
    while True:
        place = rng.uniform(0.5, length - 0.5), rng.uniform(0.5, depth - 0.5)
        if space.is_free(place):
            return Pose2D(*place, rng.uniform(-pi, pi))

"""An office without walls: columns of desks and chairs on thin legs, aisles between the chairs, rooms beside."""

from itertools import pairwise
from math import pi
from random import Random

from geometry import Pose2D
from p2os_emu.world.floors.building import HALF_WIDTH, TIGHT, WIDE, Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_OFFICES, Piece, chair, dining, furnish, plant, table
from p2os_emu.world.spec import WALL_THICKNESS, Block, WorldSpec

ABOUT = "an open office with desks and chairs on thin legs"

_COLUMNS = (3, 4)  # of desks, back to back
_DESKS = (2, 3)  # one behind the other, in half of a column
_LENGTH, _DEPTH = (1.4, 1.6), (0.7, 0.8)  # m, of a desk
_CHAIRS = 0.5  # m beside a desk that its chair keeps within
_CROSS_AISLE = (1.7, 2.1)  # m, at both ends and in the middle of the columns
_TIGHT_AISLES = 0.4
_SCREENS = 0.4  # of the pairs of desks
_ROOM_DEPTHS = (3.0, 3.6)
_TIGHT = 0.3


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    length, depth, cross = (random.uniform(*span) for span in (_LENGTH, _DEPTH, _CROSS_AISLE))
    desks = [random.randint(*_DESKS) for _ in range(2)]
    half_column = depth + _CHAIRS
    x, middles = 0.0, []
    for _ in range(random.randint(*_COLUMNS)):
        x += _aisle(random) + half_column
        middles.append(x)
        x += half_column
    width = x + _aisle(random)
    south = cross, cross + desks[0] * length
    north = south[1] + cross, south[1] + cross + desks[1] * length
    height = north[1] + cross
    office = building.add_box("corridor", 0.0, width, 0.0, height, has_place=False)
    office.places = {"corridor-south": (width / 2, cross / 2), "corridor-north": (width / 2, height - cross / 2)}
    bay = (south[1] + north[0]) / 2
    office.places |= {f"bay-{number}": (middle, bay) for number, middle in enumerate(middles, 1)}
    top = height + random.uniform(*_ROOM_DEPTHS)
    for number, (a, b) in enumerate(pairwise(cuts(random, 0.0, width, random.choice((2, 3)))), 1):
        building.add_box(f"room-{number}", a, b, height, top)
    building.connect(building.neighbours(1.4), (DoorKind.LEAF, DoorKind.GAP), _TIGHT)
    for middle in middles:
        for begin, count in zip((south[0], north[0]), desks, strict=True):
            for number in range(count):
                pieces = _pair(middle, begin + (number + 0.5) * length, length, depth, random)
                office.pieces += [block for piece in pieces for block in piece.outlines]
                building.furniture += [block for piece in pieces for block in piece.blocks]
    furnish(building, office, (plant,), (), (random.randint(0, 2), 0))
    for room in building.rooms[1:]:
        furnish(building, room, AT_WALLS_OF_OFFICES, (dining, *ANYWHERE), (random.randint(1, 3), random.randint(1, 2)))
    return building.spec()


def _aisle(random: Random) -> float:
    """Width of an aisle between chairs, m; the walls at the sides take a little of it."""
    clearance = TIGHT if random.random() < _TIGHT_AISLES else WIDE
    return 2 * (HALF_WIDTH + random.uniform(*clearance)) + WALL_THICKNESS / 2


def _pair(x: float, y: float, length: float, depth: float, random: Random) -> list[Piece]:
    """Two desks back to back at a place, m, most with a chair, some with a screen between them."""
    pieces = []
    for sense in (1, -1):
        side = Pose2D(x, y, 0.0 if sense > 0 else pi)
        desk = table("desk", (depth, depth), (length, length), legs=(0.03, 0.05))(random)
        pieces.append(desk.at(side.compose(Pose2D(depth / 2, 0.0))))
        seat = chair(random)
        far = depth + random.uniform(0.0, _CHAIRS - 0.3)
        at = side.compose(Pose2D(far, random.uniform(-0.3, 0.3) * length, random.gauss(0.0, 0.12)))
        if random.random() < 0.85:
            pieces.append(seat.at(at))
    if random.random() < _SCREENS:
        screen = Block(x, y, 0.0, 0.04, length, 1.3, "screen", colour="teal")
        pieces.append(Piece((0.04, length), (screen,)))
    return pieces

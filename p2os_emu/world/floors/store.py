"""A store with racks: aisles of uneven width between posts and crates, boards above, and rooms at one end."""

from collections.abc import Iterator
from itertools import pairwise
from random import Random

from p2os_emu.world.floors.building import HALF_WIDTH, TIGHT, WIDE, Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import AT_WALLS_OF_OFFICES, box, furnish
from p2os_emu.world.spec import Block, WorldSpec

ABOUT = "a store with racks and crates"

_RACKS = (4, 6)
_BAYS = (5, 7)  # of each rack
_BAY, _DEPTH = (1.2, 1.4), (0.75, 0.9)  # m
_BOARDS = (0.7, 1.5)  # m above the floor
_BOARD = 0.04  # m
_POST = 0.06  # m
_CRATES = 0.65  # of the bays have one on the floor
_OUTER_AISLE = (1.7, 2.1)  # m, along the walls
_TIGHT_AISLES = 0.5
_NICHES = 0.4  # of the racks have two bays left out
_ROOM_DEPTHS = (3.0, 3.8)
_TIGHT = 0.3


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    bay, depth = random.uniform(*_BAY), random.uniform(*_DEPTH)
    bays, racks = random.randint(*_BAYS), random.randint(*_RACKS)
    west, east, south, north = (random.uniform(*_OUTER_AISLE) for _ in range(4))
    rows, y = [], south
    for number in range(racks):
        if number:
            clearance = TIGHT if random.random() < _TIGHT_AISLES else WIDE
            y += 2 * (HALF_WIDTH + random.uniform(*clearance))
        rows.append((y, y + depth))
        y += depth
    right, top = west + bays * bay + east, y + north
    hall = building.add_box("corridor", 0.0, right, 0.0, top, has_place=False)
    hall.places = {"corridor-west": (west / 2, top / 2), "corridor-east": (right - east / 2, top / 2)}
    hall.places |= {
        f"{down}-{across}": (x, y)
        for down, y in (("south", south / 2), ("north", top - north / 2))
        for across, x in (("west", west / 2), ("middle", (west + right - east) / 2), ("east", right - east / 2))
    }
    begin = -random.uniform(*_ROOM_DEPTHS)
    for number, (a, b) in enumerate(pairwise(cuts(random, 0.0, top, 2)), 1):
        building.add_box(f"office-{number}", begin, 0.0, a, b)
    building.connect(building.neighbours(1.4), (DoorKind.LEAF, DoorKind.GAP), _TIGHT)
    for low, high in rows:
        left_out = random.randrange(1, bays - 2) if random.random() < _NICHES else bays
        for first, last in ((0, left_out), (left_out + 2, bays)):
            if last > first:
                blocks = list(_rack(west + first * bay, last - first, bay, (low, high), random))
                hall.pieces += blocks[:1]
                building.furniture += blocks
    furnish(building, hall, (box,), (box,), (random.randint(0, 2), random.randint(1, 3)))
    for room in building.rooms[1:]:
        furnish(building, room, AT_WALLS_OF_OFFICES, (box,), (random.randint(2, 4), random.randint(0, 2)))
    return building.spec()


def _rack(left: float, bays: int, bay: float, rows: tuple[float, float], random: Random) -> Iterator[Block]:
    """Boards, then posts, then what stands on the floor in some bays."""
    low, high = rows
    length, y = bays * bay, (low + high) / 2
    for board in _BOARDS:
        yield Block(left + length / 2, y, 0.0, length, high - low, _BOARD, "rack", colour="blue", bottom=board)
    for number in range(bays + 1):
        x = min(max(left + number * bay, left + _POST / 2), left + length - _POST / 2)
        for post in (low + _POST / 2, high - _POST / 2):
            yield Block(x, post, 0.0, _POST, _POST, 2.0, "rack", colour="blue")
    for number in range(bays):
        width, depth = random.uniform(0.7, 0.8) * bay, random.uniform(0.6, 0.9) * (high - low)
        if random.random() < _CRATES:
            x = left + (number + 0.5) * bay
            yield Block(x, y, 0.0, width, depth, random.uniform(0.4, 0.6), "crate", colour="orange")

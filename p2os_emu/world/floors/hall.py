"""Rooms round a hall: every room opens to the hall, some also to the next room."""

from itertools import pairwise
from random import Random

from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_OFFICES, chest, furnish, plant, small_table
from p2os_emu.world.spec import WorldSpec

ABOUT = "rooms round a hall"

_HALL = (6.0, 8.5), (5.0, 7.0)  # m along x and y
_DEPTHS = (3.0, 4.2)  # m, of the rooms
_DOORS_BETWEEN = 0.35  # of the walls between rooms
_TIGHT = 0.3


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    width, height = (random.uniform(*span) for span in _HALL)
    west, east, south, north = (random.uniform(*_DEPTHS) for _ in range(4))
    left, right, bottom, top = west, west + width, south, south + height
    hall = building.add_box("corridor", left, right, bottom, top)
    rows = []
    for low, high, parts in ((0.0, bottom, random.choice((2, 3))), (top, top + north, random.choice((2, 3)))):
        inner = cuts(random, left, right, parts)[1:-1]
        edges = [0.0, *inner, right + east]
        rows.append([(a, b, low, high) for a, b in pairwise(edges)])
    boxes = [*rows[0], (right, right + east, bottom, top), *rows[1], (0.0, left, bottom, top)]
    for number, sizes in enumerate(boxes, 1):
        building.add_box(f"room-{number}", *sizes)
    to_hall = [side for side in building.neighbours(1.4) if hall in (side.one, side.other)]
    others = [side for side in building.neighbours(2.0) if hall not in (side.one, side.other)]
    chosen = [side for side in others if random.random() < _DOORS_BETWEEN]
    building.connect([*to_hall, *chosen], (DoorKind.LEAF, DoorKind.LEAF, DoorKind.AJAR), _TIGHT)
    furnish(building, hall, (plant, chest), (small_table, plant, chest), (2, random.randint(2, 4)))
    for room in building.rooms[1:]:
        furnish(building, room, AT_WALLS_OF_OFFICES, ANYWHERE, (random.randint(2, 4), random.randint(0, 2)))
    return building.spec()

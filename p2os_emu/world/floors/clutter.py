"""A few large rooms full of things: boxes, chairs, stools and tables anywhere, with tight ways between them."""

from itertools import pairwise
from random import Random

from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import CLUTTER, chest, cupboard, dining, furnish
from p2os_emu.world.spec import WorldSpec

ABOUT = "rooms full of boxes, chairs and tables"

_SIZES = (12.0, 15.0), (8.5, 11.0)  # m
_COLUMNS, _ROWS = 3, 2
_PIECES = (8, 13)  # in each room
_TIGHT = 0.3
_SECOND_DOORS = 0.5


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    length, width = (random.uniform(*span) for span in _SIZES)
    ys = cuts(random, 0.0, width, _ROWS)
    hub = random.randrange(_COLUMNS * _ROWS)
    boxes = [(a, b, c, d) for c, d in pairwise(ys) for a, b in pairwise(cuts(random, 0.0, length, _COLUMNS))]
    numbers = iter(range(1, len(boxes) + 1))
    for number, sizes in enumerate(boxes):
        building.add_box("corridor" if number == hub else f"room-{next(numbers)}", *sizes)
    sides = building.neighbours(1.4)
    tree = building.tree(sides)
    more = [side for side in sides if side not in tree and random.random() < _SECOND_DOORS]
    building.connect([*tree, *more], (DoorKind.LEAF, DoorKind.GAP, DoorKind.AJAR), _TIGHT)
    for room in building.rooms:
        furnish(building, room, (cupboard, chest), (dining, *CLUTTER), (1, random.randint(*_PIECES)))
    return building.spec()

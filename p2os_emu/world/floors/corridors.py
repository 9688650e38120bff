"""Corridors that turn: two legs at a right angle with rooms on both sides, behind doors that stand ajar."""

from itertools import pairwise
from random import Random

from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_OFFICES, box, furnish, plant
from p2os_emu.world.spec import WorldSpec

ABOUT = "L-shaped corridors with doors that stand ajar"

_WIDTHS = (1.7, 2.3)  # m, of the corridors
_LEGS = (8.5, 12.0), (8.0, 10.5)  # m along x and y, of the inner corner's sides
_DEPTHS = (3.2, 4.2)
_TIGHT = 0.3
_DOORS_BETWEEN = 0.25


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    width, (long, high) = random.uniform(*_WIDTHS), (random.uniform(*span) for span in _LEGS)
    south, inner_south, east, inner_east = (random.uniform(*_DEPTHS) for _ in range(4))
    x, y = long, south  # of the inner corner's column and the lower side of the corridor along x
    end = y + width + high
    along = building.add_box("corridor-1", 0.0, x, y, y + width)
    up = building.add_box("corridor-2", x, x + width, y, end)
    boxes = [(a, b, 0.0, y) for a, b in pairwise(cuts(random, 0.0, x + width, 3))]
    boxes += [(a, b, y + width, y + width + inner_south) for a, b in pairwise(cuts(random, 0.0, x, 2))]
    boxes += [(x + width, x + width + east, a, b) for a, b in pairwise(cuts(random, y, end, 3))]
    boxes += [(x - inner_east, x, y + width + inner_south, end)]
    for number, sizes in enumerate(boxes, 1):
        building.add_box(f"room-{number}", *sizes)
    corner = building.between(along, up)
    assert corner is not None
    building.add_door(corner, DoorKind.NO_WALL, 0.0)
    sides = [side for side in building.neighbours(1.4) if side is not corner]
    one_each = {id(side.other): side for side in sides if side.one.is_passage}.values()
    behind = [side for side in sides if not side.one.is_passage and random.random() < _DOORS_BETWEEN]
    building.connect([*one_each, *behind], (DoorKind.AJAR, DoorKind.AJAR, DoorKind.LEAF), _TIGHT)
    for corridor in (along, up):
        furnish(building, corridor, (plant, box), (box,), (random.randint(1, 2), 0))
    for room in building.rooms[2:]:
        furnish(building, room, AT_WALLS_OF_OFFICES, ANYWHERE, (random.randint(2, 4), random.randint(0, 2)))
    return building.spec()

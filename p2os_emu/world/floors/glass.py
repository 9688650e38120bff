"""Glazed offices on both sides of an aisle: laser scanners and cameras look through most walls, sonar does not."""

from itertools import pairwise
from random import Random

from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_OFFICES, furnish, plant
from p2os_emu.world.spec import WorldSpec

ABOUT = "glazed offices beside an aisle"

_LENGTHS = (12.0, 16.0)  # m
_AISLES = (1.8, 2.5)
_DEPTHS = (3.2, 4.2)
_OFFICES = (3, 4)  # on each side
_GLAZED = 0.4  # of the walls between offices
_DOORS_BETWEEN = 0.3
_TIGHT = 0.3


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    length, aisle = random.uniform(*_LENGTHS), random.uniform(*_AISLES)
    south, north = random.uniform(*_DEPTHS), random.uniform(*_DEPTHS)
    corridor = building.add_box("corridor-middle", 0.0, length, south, south + aisle)
    boxes = [(a, b, 0.0, south) for a, b in pairwise(cuts(random, 0.0, length, random.randint(*_OFFICES)))]
    boxes += [
        (a, b, south + aisle, south + aisle + north)
        for a, b in pairwise(cuts(random, 0.0, length, random.randint(*_OFFICES)))
    ]
    for number, sizes in enumerate(boxes, 1):
        building.add_box(f"office-{number}", *sizes)
    to_aisle, doors = [], []
    for side in building.neighbours(1.0):
        is_front = corridor in (side.one, side.other)
        side.is_glass = is_front or random.random() < _GLAZED
        if is_front:
            to_aisle.append(side)
        elif random.random() < _DOORS_BETWEEN:
            doors.append(side)
    building.connect([*to_aisle, *doors], (DoorKind.GAP,), _TIGHT)
    ends = {"corridor-west": (1.1, south + aisle / 2), "corridor-east": (length - 1.1, south + aisle / 2)}
    corridor.places |= ends
    furnish(building, corridor, (plant,), (), (random.randint(0, 2), 0))
    for room in building.rooms[1:]:
        furnish(building, room, AT_WALLS_OF_OFFICES, ANYWHERE, (random.randint(2, 4), random.randint(0, 2)))
    return building.spec()

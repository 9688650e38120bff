"""Dead ends: corridors of uneven width that branch and never meet again, with throats and clutter in them."""

from random import Random

from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import box, chest, furnish, plant, stool
from p2os_emu.world.spec import WorldSpec

ABOUT = "branching corridors with dead ends"

_COLUMNS, _ROWS = (4, 5), (3, 4)
_CELL = (2.3, 2.9)  # m, on average
_PASSAGES_PER_PLACE = 2
_TIGHT = 0.35


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    columns, rows = random.randint(*_COLUMNS), random.randint(*_ROWS)
    xs = cuts(random, 0.0, columns * random.uniform(*_CELL), columns, 0.12)
    ys = cuts(random, 0.0, rows * random.uniform(*_CELL), rows, 0.12)
    for row in range(rows):
        for column in range(columns):
            building.add_box("", xs[column], xs[column + 1], ys[row], ys[row + 1])
    tree = building.tree(building.neighbours(1.0))
    ends = passages = 0
    for room in building.rooms:
        if sum(room in (side.one, side.other) for side in tree) == 1:
            ends += 1
            building.rename(room, f"end-{ends}")
        else:
            passages += 1
            building.rename(room, f"corridor-{passages}")
            if passages % _PASSAGES_PER_PLACE:
                room.places = {}
    building.connect(tree, (DoorKind.GAP, DoorKind.GAP, DoorKind.NO_WALL), _TIGHT)
    for room in building.rooms:
        furnish(building, room, (chest, box, plant), (box, stool), (random.randint(0, 1), random.randint(0, 1)))
    return building.spec()

"""An apartment: rooms that are reached through other rooms, by narrow doors."""

from collections.abc import Iterator
from random import Random

from p2os_emu.world.floors.building import Building, DoorKind
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_HOMES, dining, furnish
from p2os_emu.world.spec import WorldSpec

ABOUT = "an apartment whose rooms open into each other by narrow doors"

_SIZES = (11.0, 14.0), (9.0, 11.0)  # m
_ROOMS = (7, 8)
_LEAST = 2.5  # m, of a room
_SECOND_DOORS = 0.25
_TIGHT = 0.65

_Box = tuple[float, float, float, float]


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    length, width = (random.uniform(*span) for span in _SIZES)
    boxes = [(0.0, length, 0.0, width)]
    for _ in range(random.randint(*_ROOMS) - 1):
        largest = max(boxes, key=_greatest_edge)
        if _greatest_edge(largest) > 2 * _LEAST:
            boxes.remove(largest)
            boxes += _halves(largest, random)
    hub = max(boxes, key=lambda box: (box[1] - box[0]) * (box[3] - box[2]))
    numbers = iter(range(1, len(boxes) + 1))
    for box in sorted(boxes):
        building.add_box("corridor" if box == hub else f"room-{next(numbers)}", *box)
    sides = building.neighbours(1.3)
    tree = building.tree(sides)
    more = [side for side in sides if side not in tree and random.random() < _SECOND_DOORS]
    building.connect([*tree, *more], (DoorKind.LEAF, DoorKind.LEAF, DoorKind.GAP, DoorKind.AJAR), _TIGHT)
    for room in building.rooms:
        inside = (dining, *ANYWHERE) if room.is_passage else ANYWHERE
        furnish(building, room, AT_WALLS_OF_HOMES, inside, (random.randint(2, 4), random.randint(0, 2)))
    return building.spec()


def _greatest_edge(box: _Box) -> float:
    return max(box[1] - box[0], box[3] - box[2])


def _halves(box: _Box, random: Random) -> Iterator[_Box]:
    """Cut a box across its longer edge, both parts large enough for a room."""
    left, right, bottom, top = box
    if right - left > top - bottom:
        x = _cut(left, right, random)
        yield left, x, bottom, top
        yield x, right, bottom, top
    else:
        y = _cut(bottom, top, random)
        yield left, right, bottom, y
        yield left, right, y, top


def _cut(low: float, high: float, random: Random) -> float:
    least = max(_LEAST, 0.42 * (high - low))
    return random.uniform(low + least, high - least)

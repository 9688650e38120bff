"""A building without right angles: every wall stands at its own angle."""

from itertools import product
from math import atan2, cos, pi, sin
from random import Random

from geometry import Point, wrap_angle
from p2os_emu.world.floors.building import Building, DoorKind, cuts
from p2os_emu.world.floors.furnishing import ANYWHERE, AT_WALLS_OF_HOMES, AT_WALLS_OF_OFFICES, furnish
from p2os_emu.world.spec import WorldSpec

ABOUT = "rooms without right angles"

_COLUMNS, _ROWS = 3, 3
_CELL = (4.0, 4.8)  # m, on average
_SHIFT = 0.6  # m, of each corner
_LEAST_SKEW = 0.02  # rad between every corner and a right angle
_DOORS_ROUND = 0.3  # of the borders that need no door
_TIGHT = 0.3


def make(name: str, random: Random) -> WorldSpec:
    """Make a floor of this family."""
    building = Building(name, ABOUT, random)
    corners = _corners(random)
    numbers = iter(range(1, _COLUMNS * _ROWS))
    for row, column in product(range(_ROWS), range(_COLUMNS)):
        is_middle = (row, column) == (_ROWS // 2, _COLUMNS // 2)
        around = [corners[row + down, column + right] for down, right in ((0, 0), (0, 1), (1, 1), (1, 0))]
        building.add_room("corridor" if is_middle else f"room-{next(numbers)}", around)
    sides = building.neighbours(1.5)
    tree = building.tree(sides)
    more = [side for side in sides if side not in tree and random.random() < _DOORS_ROUND]
    building.connect([*tree, *more], (DoorKind.LEAF, DoorKind.GAP, DoorKind.AJAR), _TIGHT)
    for room in building.rooms:
        kinds = random.choice((AT_WALLS_OF_HOMES, AT_WALLS_OF_OFFICES))
        furnish(building, room, kinds, ANYWHERE, (random.randint(2, 3), random.randint(0, 2)))
    return building.spec()


def _corners(random: Random) -> dict[tuple[int, int], Point]:
    """Corners of all rooms by row and column: a grid, each corner moved by chance until no angle is right, turned."""
    xs = cuts(random, 0.0, _COLUMNS * random.uniform(*_CELL), _COLUMNS)
    ys = cuts(random, 0.0, _ROWS * random.uniform(*_CELL), _ROWS)
    while True:
        moved = {
            (row, column): (x + random.uniform(-_SHIFT, _SHIFT), y + random.uniform(-_SHIFT, _SHIFT))
            for (row, y), (column, x) in product(enumerate(ys), enumerate(xs))
        }
        if all(_is_skew(moved, row, column) for row, column in product(range(_ROWS), range(_COLUMNS))):
            break
    turn = random.uniform(0.15, pi / 2 - 0.15)
    return {key: (cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y) for key, (x, y) in moved.items()}


def _is_skew(corners: dict[tuple[int, int], Point], row: int, column: int) -> bool:
    """Return whether no angle of a room is nearly right."""
    around = [corners[row + down, column + right] for down, right in ((0, 0), (0, 1), (1, 1), (1, 0))]
    headings = [atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(around, (*around[1:], around[0]), strict=True)]
    turns = [wrap_angle(b - a) for a, b in zip(headings, (*headings[1:], headings[0]), strict=True)]
    return all(abs(turn - pi / 2) > _LEAST_SKEW for turn in turns)

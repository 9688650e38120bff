"""Conversion of an ARIA map to a world, as MobileSim reads it: walls, reflectors, and boxes to push.

A map without lines has only the points that a laser saw: they become small blocks, side by side. So do lines that are
too many for the physics engine, and blocks become larger until they are few enough.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from geometry import Cairn, MapFile, Pose2D, Segment
from p2os_emu.world.docks import Dock
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.spec import WALL_HEIGHT, Block, WallEntry, WorldSpec

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_SHIFT = 2**31  # rows apart in the number of a cell; farther out nothing is built

LINE_THICKNESS = 0.02  # a line of a map is the face of a wall, whichever side one sees it from
POINT_CELL = 0.05  # m; points closer together than this are one obstacle
MOST_WALLS = 3000
"""Blocks of one world that stand still: a step looks at each, so this many take a fifth of a core."""
MOST_SAMPLES = 500_000
"""Points that lines which are too many are cut into."""
GOAL = "Goal"
"""Kind of places where robots are sent; its name is the place's."""
DOCK = "Dock"
"""Kind of places where robots are charged; the pose is that of a robot that stands there."""
STARTS = ("RobotHome", DOCK, GOAL)
"""Kinds of places where robots may begin, best first."""
REFLECTOR = "Reflector"
BOXES = ("Sim.BoxObstacle", "BoxObstacle")
"""Kinds that are boxes even if the map does not say so."""
BOX_HEIGHT = 0.5  # m, assumed
BOX_MASS = 10.0  # kg, assumed
BOX_FRICTION = 0.3


def world_of(file: MapFile, name: str) -> WorldSpec:
    """Make a world: robots start at RobotHome, else at a dock or a goal, else at the origin; goals are places.

    Robots are charged at the docks of the map, which has no stations to be seen there.
    """
    lines = [line for line in file.lines if line.length > 0.0]
    walls, note = _walls(lines, file)
    walls += [
        block
        for cairn in file.places(REFLECTOR)
        if cairn.extent is not None
        for block in _wall(cairn.extent, reflector=True)
    ]
    starts = tuple(cairn.pose for kind in STARTS for cairn in file.places(kind))
    return WorldSpec(
        name,
        f"ARIA map {name}",
        tuple(walls),
        starts=starts or (Pose2D(),),
        objects=tuple(_boxes(file)),
        places={cairn.name: (cairn.pose.x, cairn.pose.y) for cairn in file.places(GOAL) if cairn.name},
        note=note,
        docks=tuple(Dock(cairn.name or "dock", cairn.pose) for cairn in file.places(DOCK)),
    )


def _walls(lines: Sequence[Segment], file: MapFile) -> tuple[list[Block], str]:
    """The walls of a map, and a sentence where they are coarser than the file."""
    if not file.lines:
        walls, cell = _rows_of_cells(np.array(file.points, np.float64).reshape(-1, 2), file.cell)
        note = f"the points of the map are too many; they are blocks of {cell:.2g} m" if cell > POINT_CELL else ""
        return walls, note
    if len(lines) <= MOST_WALLS:
        return [block for line in lines for block in _wall(line)], ""
    walls, cell = _rows_of_cells(*_samples(np.array(lines, np.float64)))
    return walls, f"the map has {len(lines)} lines, more than {MOST_WALLS}; they are blocks of {cell:.2g} m"


def _samples(lines: Floats) -> tuple[Floats, float]:
    """Points along lines, about `MOST_SAMPLES` at most, and the edge of cells in which they leave no gaps, m."""
    starts, ways = lines[:, :2], lines[:, 2:] - lines[:, :2]
    lengths = np.hypot(ways[:, 0], ways[:, 1])
    cell = max(POINT_CELL, 2.0 * float(lengths.sum()) / MOST_SAMPLES)
    counts = np.minimum(np.ceil(2.0 * lengths / cell), MOST_SAMPLES).astype(np.int64) + 1
    which = np.repeat(np.arange(len(lines)), counts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = number / np.maximum(counts[which] - 1, 1)
    points: Floats = starts[which] + shares[:, np.newaxis] * ways[which]
    return points, cell


def _wall(line: Segment, reflector: bool = False) -> Iterable[Block]:
    if line.length == 0.0:
        return ()
    return WallEntry(line[:2], line[2:], thickness_m=LINE_THICKNESS, reflector=reflector).blocks()


def _boxes(file: MapFile) -> Iterator[Movable]:
    """The areas that are boxes for the simulator."""
    for cairn in file.cairns:
        attributes = file.kinds.get(cairn.kind, {})
        is_box = attributes.get("Sim.Obstacle", "yes" if cairn.kind in BOXES else "no") == "yes"
        if is_box and cairn.extent is not None:
            yield _box(cairn, cairn.extent, attributes)


def _box(cairn: Cairn, corners: Segment, attributes: Mapping[str, str]) -> Movable:
    x1, y1, x2, y2 = corners
    turned = Pose2D(0.0, 0.0, cairn.pose.heading)  # the corners are given before the turn about the map's origin
    x, y = turned.transform((x1 + x2) / 2, (y1 + y2) / 2)
    reflectance = attributes.get("Sim.LaserReflect", "1")
    return Movable(
        name=cairn.name or f"{cairn.kind} {x:.2f} {y:.2f}",
        shape=Shape.BOX,
        pose=Pose2D(x, y, cairn.pose.heading),
        length=abs(x2 - x1),
        width=abs(y2 - y1),
        height=BOX_HEIGHT,
        mass=BOX_MASS,
        friction=BOX_FRICTION,
        colour="yellow",
        reflector=reflectance.isdecimal() and int(reflectance) > 1,
    )


def _rows_of_cells(points: Floats, finest: float) -> tuple[list[Block], float]:
    """A block for every run of cells of a grid, along x, that hold a point; and the edge of the cells, m.

    Where there are more than `MOST_WALLS` runs, equal ones of neighbouring rows become one block, and the cells are
    doubled until the blocks are few enough.

    Args:
        points: m, shape (n, 2).
        finest: Least edge of the cells, m.
    """
    cell = max(POINT_CELL, finest)
    if not len(points):
        return [], cell
    while True:
        columns, rows = np.round(points.T / cell).astype(np.int64)
        runs = _runs(rows, columns)
        if len(runs) <= MOST_WALLS or len(runs := _merged(runs)) <= MOST_WALLS:
            break
        cell *= 2.0
    blocks = [
        Block(
            x=(first + last) / 2 * cell,
            y=(low + high) / 2 * cell,
            heading=0.0,
            length=(last - first + 1) * cell,
            width=(high - low + 1) * cell,
            height=WALL_HEIGHT,
        )
        for low, high, first, last in runs.tolist()
    ]
    return blocks, cell


def _runs(rows: Integers, columns: Integers) -> Integers:
    """Runs of neighbouring cells: first and last row, which are the same, and first and last column; shape (n, 4)."""
    keys = np.sort(rows * _SHIFT + columns + _SHIFT // 2)  # one number for each cell, in the order of the rows
    keys = keys[np.append(True, np.diff(keys) != 0)]
    begins = np.flatnonzero(np.append(True, np.diff(keys) != 1))
    firsts, lasts = keys[begins], keys[np.append(begins[1:], len(keys)) - 1]
    row = firsts // _SHIFT
    return np.stack((row, row, firsts % _SHIFT - _SHIFT // 2, lasts % _SHIFT - _SHIFT // 2), axis=1)


def _merged(runs: Integers) -> Integers:
    """The same with runs of the same columns in neighbouring rows put together."""
    runs = runs[np.lexsort((runs[:, 0], runs[:, 3], runs[:, 2]))]
    steps = np.diff(runs, axis=0)
    begins = np.flatnonzero(np.append(True, (steps[:, 0] != 1) | (steps[:, 2] != 0) | (steps[:, 3] != 0)))
    merged = runs[begins]
    merged[:, 1] = runs[np.append(begins[1:], len(runs)) - 1, 1]
    return merged

"""From an ARIA map to a world, with what MobileSim makes of it: walls, reflectors, and boxes to push.

A map without lines has only the points that a laser saw: they become small blocks, side by side.
"""

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby

from geometry import Cairn, MapFile, Point, Pose2D, Segment
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.spec import WALL_HEIGHT, Block, WallEntry, WorldSpec

LINE_THICKNESS = 0.02  # a line of a map is the face of a wall, whichever side one sees it from
POINT_CELL = 0.05  # m; points closer together than this are one obstacle
GOAL = "Goal"
"""Kind of places where robots are sent; its name is the place's."""
STARTS = ("RobotHome", "Dock", GOAL)
"""Kinds of places where robots may begin, best first."""
REFLECTOR = "Reflector"
BOXES = ("Sim.BoxObstacle", "BoxObstacle")
"""Kinds that are boxes even if the map does not say so."""
BOX_HEIGHT = 0.5  # m, assumed
BOX_MASS = 10.0  # kg, assumed
BOX_FRICTION = 0.3


def world_of(file: MapFile, name: str) -> WorldSpec:
    """Make a world: robots start at RobotHome, else at a dock or a goal, else at the origin; goals are places."""
    walls = [block for line in file.lines for block in _wall(line)]
    if not file.lines:
        walls += _rows_of_cells(file.points)
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
    )


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


def _rows_of_cells(points: Iterable[Point]) -> Iterator[Block]:
    """A block for every run of cells of the grid, along x, that hold a point."""
    cells = sorted({(round(y / POINT_CELL), round(x / POINT_CELL)) for x, y in points})
    for (row, _), run in groupby(enumerate(cells), lambda item: (item[1][0], item[1][1] - item[0])):
        columns = [column for _, (_, column) in run]
        first, last = columns[0], columns[-1]
        yield Block(
            x=(first + last) / 2 * POINT_CELL,
            y=row * POINT_CELL,
            heading=0.0,
            length=(last - first + 1) * POINT_CELL,
            width=POINT_CELL,
            height=WALL_HEIGHT,
        )

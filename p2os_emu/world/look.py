"""Looks of objects: boxes, cylinders and spheres with colours, from which a camera process draws the world.

Nothing public states the looks of these robots beyond their outlines: hull, deck, wheels and a light on the nose, in a
body colour that follows from the robot's name.
"""

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple
from zlib import crc32

from configs.target_file import Rgb, TargetFile
from p2os_emu.world.chassis import HULL_BOTTOM, HULL_TOP, MASS_HEIGHT, Chassis
from p2os_emu.world.collision import HULL, WHEELS
from p2os_emu.world.colours import COLOURS, Colour
from p2os_emu.world.floor import Floor
from p2os_emu.world.links import FIRST, BodyLink
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.moving_doors import LEAF_HEIGHT, LEAF_THICKNESS, MovingDoor
from p2os_emu.world.people import BODY_RADIUS, HEIGHT, HIP, LEG_HEIGHT, LEG_RADIUS, Person
from p2os_emu.world.spec import Block, WorldSpec
from p2os_emu.world.textures import SurfaceTexture

Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

LEVEL: Quaternion = (0.0, 0.0, 0.0, 1.0)
ON_ITS_SIDE: Quaternion = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)  # a cylinder along y
SKIRTING_HEIGHT = 0.08
SKIRTING_DEPTH = 0.01  # m that a skirting board stands out
DECK = 0.02  # m, thickness of a robot's top plate
WHEEL_WIDTH = 0.05
FLOOR_MARGIN = 4.0  # m of floor around what stands in a world
LEAST_FLOOR = 24.0  # m
FLOOR_DEPTH = 0.02
NOSE = 0.06  # m, edge of the light in front
HEAD = 0.24  # m, height of one
SHEET = 0.001  # m, thickness of the coloured sheets of a target
BACKING = 0.004  # m, of what they are glued on, which a viewer ahead of the robot sees
_GLASS_RAIL = 0.04  # m, height of the rails that hold a pane of glass
RAIL = 0.012  # m, of the frame that carries them
SKIN: Colour = (0.80, 0.62, 0.50, 1.0)
ROBOT_COLOURS = ("red", "blue", "orange", "green", "yellow", "purple", "teal", "pink")


class Form(Enum):
    """What a part is."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"


class ShapePart(NamedTuple):
    """One part of a thing, in the thing's own frame.

    size: of a box along x, y, z; of a cylinder diameter, diameter, height along its own z; of a sphere its diameter, m.
    floor: how the top of a box looks that is the floor. texture: how the sides of any other box look.
    """

    form: Form
    size: Triple
    colour: Colour
    place: Triple = (0.0, 0.0, 0.0)
    turn: Quaternion = LEVEL
    floor: Floor | None = None
    texture: SurfaceTexture | None = None


Look = tuple[ShapePart, ...]


def floor_look(spec: WorldSpec) -> Look:
    """The floor of a world, seen from its origin."""
    x, y, extent = spec.middle
    edge = max(LEAST_FLOOR, extent + 2 * FLOOR_MARGIN)
    size = edge, edge, FLOOR_DEPTH
    return (ShapePart(Form.BOX, size, COLOURS["white"], (x, y, -FLOOR_DEPTH / 2), floor=spec.floor),)


def wall_look(block: Block, texture: SurfaceTexture | None = None) -> Look:
    """A wall with a skirting board, seen from its middle."""
    if block.glass:
        return _pane_look(block)
    board = block.length + 2 * SKIRTING_DEPTH, block.width + 2 * SKIRTING_DEPTH, SKIRTING_HEIGHT
    place = 0.0, 0.0, (SKIRTING_HEIGHT - block.height) / 2
    return (*furniture_look(block, texture), ShapePart(Form.BOX, board, COLOURS["dark grey"], place))


def furniture_look(block: Block, texture: SurfaceTexture | None = None) -> Look:
    """A piece of furniture, seen from its middle."""
    if block.glass:
        return _pane_look(block)
    size = block.length, block.width, block.height
    if any(block.board):
        return ShapePart(Form.BOX, size, COLOURS["white"]), *_board_look(block)
    return (ShapePart(Form.BOX, size, COLOURS[block.colour], texture=texture),)


def _board_look(block: Block) -> Look:
    """The black squares of a chessboard, as sheets that go through a white board and stand out on both sides."""
    columns, rows = block.board
    edge = block.square
    size = edge, block.width + 2 * SHEET, edge
    return tuple(
        ShapePart(Form.BOX, size, COLOURS["black"], ((column - columns / 2) * edge, 0.0, (row - rows / 2) * edge))
        for column in range(columns + 1)
        for row in range(rows + 1)
        if (column + row) % 2 == 0
    )


def _pane_look(block: Block) -> Look:
    """The rails below and above a pane of glass, of which nothing else is seen."""
    rail = block.length, block.width, min(_GLASS_RAIL, block.height / 2)
    place = (block.height - rail[2]) / 2
    return tuple(ShapePart(Form.BOX, rail, COLOURS["grey"], (0.0, 0.0, z)) for z in (-place, place))


def movable_look(movable: Movable) -> Look:
    """A movable object, seen from its middle."""
    form = Form.CYLINDER if movable.shape is Shape.CYLINDER else Form.BOX
    return (ShapePart(form, (movable.length, movable.width, movable.height), COLOURS[movable.colour]),)


def leaf_look(door: MovingDoor) -> Look:
    """The leaf of a door, seen from its middle."""
    return (ShapePart(Form.BOX, (door.width, LEAF_THICKNESS, LEAF_HEIGHT), COLOURS[door.colour]),)


def person_look(person: Person) -> Look:
    """Somebody seen from the middle of their height: legs, body and head. In pictures the legs do not step."""
    trunk, waist = HEIGHT - HEAD - LEG_HEIGHT, LEG_HEIGHT - HEIGHT
    legs = [
        ShapePart(
            Form.CYLINDER, (2 * LEG_RADIUS, 2 * LEG_RADIUS, LEG_HEIGHT), COLOURS["dark grey"], (0.0, side, waist / 2)
        )
        for side in (HIP, -HIP)
    ]
    body = (
        ShapePart(
            Form.CYLINDER,
            (2 * BODY_RADIUS, 2 * BODY_RADIUS, trunk),
            COLOURS[person.colour],
            (0.0, 0.0, LEG_HEIGHT + (trunk - HEIGHT) / 2),
        ),
        ShapePart(Form.SPHERE, (HEAD, HEAD, HEAD), SKIN, (0.0, 0.0, (HEIGHT - HEAD) / 2)),
    )
    return (*legs, *body)


def robot_looks(
    name: str, chassis: Chassis, links: Sequence[BodyLink], target: TargetFile | None = None
) -> dict[int, Look]:
    """A robot by its links: hull, wheels, and what its accessories add; each seen from its centre of mass."""
    wheel = 2 * chassis.wheel_radius, 2 * chassis.wheel_radius, WHEEL_WIDTH
    wheels = {link: (ShapePart(Form.CYLINDER, wheel, COLOURS["black"], turn=ON_ITS_SIDE),) for link in WHEELS}
    others = {number: (ShapePart(Form.BOX, link.size, COLOURS["grey"]),) for number, link in enumerate(links, FIRST)}
    hull = _hull(name, chassis) if target is None else (*_hull(name, chassis), *_target(target, chassis))
    return {HULL: hull, **wheels, **others}


def _hull(name: str, chassis: Chassis) -> Look:
    """The body colour, the deck on top, and the light on the nose."""
    colour = COLOURS[ROBOT_COLOURS[crc32(name.encode()) % len(ROBOT_COLOURS)]]
    length, middle = chassis.front + chassis.rear, (chassis.front - chassis.rear) / 2
    top = HULL_TOP - DECK
    return (
        ShapePart(
            Form.BOX, (length, chassis.width, top - HULL_BOTTOM), colour, _seen(middle, 0.0, (top + HULL_BOTTOM) / 2)
        ),
        ShapePart(Form.BOX, (length, chassis.width, DECK), COLOURS["black"], _seen(middle, 0.0, HULL_TOP - DECK / 2)),
        ShapePart(Form.BOX, (NOSE / 2, 2 * NOSE, NOSE), COLOURS["white"], _seen(chassis.front, 0.0, top - NOSE)),
    )


def _target(target: TargetFile, chassis: Chassis) -> Look:
    """Three rectangles on a frame that stands on the deck. Only drawn: cardboard, above all sensors of other robots."""
    x, half = target.inset_m - chassis.rear, target.span_m / 2
    place = _seen(x + BACKING + RAIL / 2, 0.0, HULL_TOP + RAIL / 2)
    return (
        ShapePart(Form.BOX, (RAIL, target.span_m, RAIL), COLOURS["dark grey"], place),
        *_rectangle(target, x, half, target.left),
        *_rectangle(target, x - target.depth_m, 0.0, target.centre),
        *_rectangle(target, x, -half, target.right),
    )


def _rectangle(target: TargetFile, x: float, y: float, colour: Rgb) -> Look:
    """A sheet whose coloured face is at x and looks back, what it is glued on, and the post under it."""
    size, z = (target.width_m, target.height_m), target.middle_m
    foot = z - target.height_m / 2 - HULL_TOP
    return (
        ShapePart(Form.BOX, (SHEET, *size), (*colour, 1.0), _seen(x + SHEET / 2, y, z)),
        ShapePart(Form.BOX, (BACKING, *size), COLOURS["dark grey"], _seen(x + SHEET + BACKING / 2, y, z)),
        ShapePart(
            Form.BOX, (RAIL, RAIL, foot), COLOURS["dark grey"], _seen(x + BACKING + RAIL / 2, y, HULL_TOP + foot / 2)
        ),
    )


def _seen(x: float, y: float, z: float) -> Triple:
    """From the floor under the axle to the centre of mass, m."""
    return x, y, z - MASS_HEIGHT

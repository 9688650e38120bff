"""Parts of a robot that move beside its wheels: bodies on joints, one on the other, that an accessory adds to it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from p2os_emu.world.engine import engine

Triple = tuple[float, float, float]

FIRST = 2
"""Index of a robot's first link beyond its two wheels."""


class Joint(Enum):
    """What a joint lets its part do; the values are the engine's."""

    FIXED = engine.JOINT_FIXED
    TURNS = engine.JOINT_REVOLUTE
    SLIDES = engine.JOINT_PRISMATIC


@dataclass(frozen=True, slots=True)
class BodyLink:
    """One part, a box of even density, and the joint that carries it; at zero its axes are the robot's.

    mass: kg. size: of the box, m. centre: of the box, m from the joint.
    place: of the joint, m: from the parent's joint, or from the floor under the middle of the axle.
    parent: index of the part that carries it, among those of one accessory; None for the hull.
    axis: of the joint. lower, upper: its ends, rad or m; no ends where lower is not below upper.
    rotor: kg m2 about the axis: of a motor, as felt behind its gear.
    friction: of its surface. collides: it touches walls, furniture, floor and other robots.
    """

    mass: float
    size: Triple
    centre: Triple
    place: Triple
    parent: int | None = None
    joint: Joint = Joint.FIXED
    axis: Triple = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = -1.0
    rotor: float = 0.0
    friction: float = 0.3
    collides: bool = True


def joined(accessories: Iterable[Sequence[BodyLink]]) -> tuple[BodyLink, ...]:
    """The links of several accessories in one row, their parents counted anew."""
    row: list[BodyLink] = []
    for links in accessories:
        before = len(row)
        row += [link if link.parent is None else replace(link, parent=link.parent + before) for link in links]
    return tuple(row)

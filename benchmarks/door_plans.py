"""Floor plans in which doors are looked for: rooms, corridors, and much that is no door. Seeded; the truth is known.

A plan is rows of rooms, one of which may be a corridor. Walls get doors, corridor ends, and decoys: niches, closed
doors, gaps too narrow. Then come furniture and people, and all is sheared a little, turned and moved.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rng = np.random.Generator

THINNEST, THICKEST = 0.10, 0.20  # m, of walls
JAMB = 0.18  # m of wall at least between a door and the next corner
DOOR_WIDTHS = (0.82, 1.5)
CORRIDOR_WIDTHS, ROOM_SIZES = (1.2, 2.3), (2.8, 6.5)
AROUND_DOORS = 1.15  # m on either side of a door that furniture leaves free
WITHIN_DOORS = 0.35  # m on either side of a door's middle where nobody stands
LEAF = 0.04


@dataclass(frozen=True, slots=True)
class Opening:
    """Where one can leave, at least 0.8 m wide and 1 m deep beyond.

    corners: the four corners of the wall's faces: both jambs of one face, both jambs of the other; shape (4, 2).
    is_corridor_end: a corridor as wide ends there, which comes from the side of the first face.
    """

    corners: Floats
    is_corridor_end: bool = False


@dataclass(slots=True)
class Plan:
    """Everything that a beam may hit.

    polygons: walls, furniture and leaves, as their corners. legs: x, y, radius of round things. rooms: x and y from
    and to, before the plan was turned. matrix, shift: how it was turned.
    """

    polygons: list[Floats] = field(default_factory=list)
    legs: list[tuple[float, float, float]] = field(default_factory=list)
    openings: list[Opening] = field(default_factory=list)
    rooms: list[tuple[float, float, float, float]] = field(default_factory=list)
    keep_free: list[tuple[float, float, float, float]] = field(default_factory=list)
    doorways: list[tuple[float, float, float, float]] = field(default_factory=list)
    matrix: Floats = field(default_factory=lambda: np.eye(2))
    shift: Floats = field(default_factory=lambda: np.zeros(2))

    def edges(self) -> Floats:
        """All straight edges as x1, y1, x2, y2, turned; shape (n, 4)."""
        return np.concatenate([np.hstack((p, np.roll(p, -1, 0))) for p in map(self.turned, self.polygons)])

    def round_things(self) -> Floats:
        """All legs, turned; shape (n, 3)."""
        if not self.legs:
            return np.zeros((0, 3))
        legs = np.array(self.legs)
        return np.hstack((self.turned(legs[:, :2]), legs[:, 2:]))

    def turned(self, points: Floats) -> Floats:
        """Take points from the plan as it was drawn to where it lies."""
        return points @ self.matrix.T + self.shift


@dataclass(frozen=True, slots=True)
class Wall:
    """A wall along x (axis 0) or y (axis 1): where it lies across, from where to where, how thick."""

    axis: int
    across: float
    start: float
    end: float
    thickness: float

    def box(self, start: float, end: float, low: float, high: float) -> tuple[float, float, float, float]:
        """A box beside the wall: along it from start to end, across it from low to high, from its middle."""
        low, high = self.across + low, self.across + high
        return (start, end, low, high) if self.axis == 0 else (low, high, start, end)


def draw_plan(seed: int) -> Plan:
    """A plan; the same seed gives the same one."""
    rng = np.random.default_rng(seed)
    plan = Plan()
    for wall, about in _walls(plan, rng):
        _build(plan, wall, about, rng)
    for room in plan.rooms:
        _furnish(plan, room, rng)
    _enclose(plan, rng.uniform(1.5, 8.0))
    angle, shear = rng.uniform(-np.pi, np.pi), rng.uniform(-0.15, 0.15) * (rng.random() < 0.25)
    plan.matrix = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]) @ np.array([[1.0, shear], [0.0, 1.0]])
    plan.shift = rng.uniform(-20.0, 20.0, 2)
    return plan


def closed_room(width: float, depth: float) -> Plan:
    """One room without any gap."""
    plan = Plan(rooms=[(0.05, width - 0.05, 0.05, depth - 0.05)])
    for axis, across, end in ((0, 0.0, width), (0, depth, width), (1, 0.0, depth), (1, width, depth)):
        plan.polygons.append(_rectangle(*Wall(axis, across, 0.0, end, 0.1).box(0.0, end, -0.05, 0.05)))
    return plan


def _walls(plan: Plan, rng: Rng) -> Iterator[tuple[Wall, str]]:
    """Draw rows of rooms; each wall with what it is: `inner`, `outer`, `corridor`, its `end`, `missing`."""
    has_corridor = rng.random() < 0.6
    heights = [rng.uniform(*ROOM_SIZES) for _ in range(rng.integers(2, 4))]
    width, thick = rng.uniform(7.0, 15.0), rng.uniform(THINNEST, THICKEST)
    lobby = width - rng.uniform(3.0, 4.0) if has_corridor and rng.random() < 0.6 else width
    columns = [_columns(lobby, width, rng) for _ in heights]
    if has_corridor:
        heights[1:1], columns[1:1] = [rng.uniform(*CORRIDOR_WIDTHS)], [sorted({0.0, lobby, width})]
    lines = np.concatenate(([0.0], np.cumsum(heights)))
    for k, (low, high) in enumerate(pairwise(lines)):
        for left, right in pairwise(columns[k]):
            plan.rooms.append((left + thick / 2, right - thick / 2, low + thick / 2, high - thick / 2))
        for x in columns[k]:
            is_end = has_corridor and k == 1 and x == lobby < width
            yield Wall(1, x, low, high, thick), "outer" if x in (0.0, width) else "end" if is_end else "inner"
    for k, y in enumerate(lines):
        junctions = sorted({*(columns[k - 1] if k > 0 else ()), *(columns[k] if k < len(heights) else ())})
        for left, right in pairwise(junctions):
            about = "outer" if k in (0, len(heights)) else "corridor" if has_corridor and k < 3 else "inner"
            yield Wall(0, y, left, right, thick), "missing" if about == "corridor" and left >= lobby else about


def _enclose(plan: Plan, margin: float) -> None:
    """Put other houses around, so that doors lead somewhere."""
    points = np.concatenate(plan.polygons)
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    for turn in ((low[0], high[1]), (high[0], low[1])):
        plan.polygons.append(np.array([low, turn, high, turn]))


def _columns(lobby: float, width: float, rng: Rng) -> list[float]:
    """Where the walls between the rooms of a row are; the lobby, at whose door a corridor ends, is one of them."""
    columns = [0.0]
    while lobby - columns[-1] > 2 * ROOM_SIZES[0] and rng.random() < 0.85:
        columns.append(
            columns[-1] + rng.uniform(ROOM_SIZES[0], min(ROOM_SIZES[1], lobby - columns[-1] - ROOM_SIZES[0]))
        )
    return sorted({*columns, lobby, width})


def _build(plan: Plan, wall: Wall, about: str, rng: Rng) -> None:
    """Build a wall with what is in it."""
    half = wall.thickness / 2
    cursor = wall.start - half
    for start, end, kind in _gaps(wall, about, rng):
        if start > cursor:
            plan.polygons.append(_rectangle(*wall.box(cursor, start, -half, half)))
        cursor = end
        if kind == "nothing":
            continue
        plan.keep_free.append(wall.box(start - 0.1, end + 0.1, -AROUND_DOORS - half, AROUND_DOORS + half))
        plan.doorways.append(wall.box(start, end, -WITHIN_DOORS, WITHIN_DOORS))
        if kind in ("door", "end"):
            adapters = [_rectangle(*wall.box(start, end, side, side))[[0, 2]] for side in (-half, half)]
            plan.openings.append(Opening(np.concatenate(adapters), kind == "end"))
            if kind == "door" and rng.random() < 0.6:
                plan.polygons.append(_leaf(wall, start, end, rng))
        elif kind == "closed":
            depth = rng.uniform(-half, half - LEAF)
            plan.polygons.append(_rectangle(*wall.box(start, end, depth, depth + LEAF)))
        elif kind == "niche":
            _niche(plan, wall, start, end, rng)
    plan.polygons.append(_rectangle(*wall.box(cursor, wall.end + half, -half, half)))


def _gaps(wall: Wall, about: str, rng: Rng) -> list[tuple[float, float, str]]:
    """What interrupts a wall: from, to, kind; in order."""
    half = wall.thickness / 2
    first, last = wall.start + half, wall.end - half  # between the faces of the crossing walls
    if about == "end" and rng.random() < 0.7:
        return [(first, last, "end")]
    if about == "outer" and rng.random() < 0.7:
        return []
    if about == "missing" or (about == "inner" and last - first > 2.7 and rng.random() < 0.08):
        return [(first, last, "nothing")]
    gaps: list[tuple[float, float, str]] = []
    cursor = first + JAMB
    for _ in range(3):
        kind = str(rng.choice(["door", "niche", "closed", "narrow", ""], p=[0.45, 0.08, 0.08, 0.08, 0.31]))
        width = rng.uniform(0.35, 0.62) if kind == "narrow" else rng.uniform(*DOOR_WIDTHS)
        room = last - JAMB - width - cursor
        if kind and room > 0.0:
            start = cursor + rng.uniform(0.0, room)
            gaps.append((start, start + width, kind))
            cursor = start + width + 2 * JAMB
    return gaps


def _leaf(wall: Wall, start: float, end: float, rng: Rng) -> Floats:
    """A door's leaf that stands open."""
    side, hinge_at_end = rng.choice([-1.0, 1.0]), rng.random() < 0.5
    hinge, along = (end, -1.0) if hinge_at_end else (start, 1.0)
    length, opened = end - start, rng.uniform(1.3, 3.0)
    outline = np.array([[0.0, 0.0], [length, 0.0], [length, -LEAF], [0.0, -LEAF]])
    c, s = cos(opened), sin(opened)
    turned = outline @ np.array([[c, s], [-s, c]])
    points = np.column_stack((hinge + along * turned[:, 0], wall.across + side * (wall.thickness / 2 + turned[:, 1])))
    return points if wall.axis == 0 else points[:, ::-1]


def _niche(plan: Plan, wall: Wall, start: float, end: float, rng: Rng) -> None:
    """A recess, too shallow to leave by."""
    side, half, deep, plate = rng.choice([-1.0, 1.0]), wall.thickness / 2, rng.uniform(0.25, 0.75), 0.05
    for box in (
        wall.box(start - plate, end + plate, *sorted((side * deep, side * (deep + plate)))),
        wall.box(start - plate, start, *sorted((side * half, side * deep))),
        wall.box(end, end + plate, *sorted((side * half, side * deep))),
    ):
        plan.polygons.append(_rectangle(*box))


def _furnish(plan: Plan, room: tuple[float, float, float, float], rng: Rng) -> None:
    """Put furniture, clutter and people into a room."""
    left, right, low, high = room
    area = (right - left) * (high - low)
    for _ in range(rng.poisson(area / 7.0)):
        _cupboard(plan, room, rng)
    if min(right - left, high - low) > 4.0 and rng.random() < 0.35:
        _pair_of_shelves(plan, room, rng)
    for _ in range(rng.poisson(area / 12.0)):
        _box(plan, room, rng)
    for _ in range(rng.poisson(area / 9.0)):
        _legs(plan, room, rng)


def _cupboard(plan: Plan, room: tuple[float, float, float, float], rng: Rng) -> None:
    """Something against a wall."""
    left, right, low, high = room
    long, deep, wall = rng.uniform(0.4, 1.8), rng.uniform(0.25, 0.6), rng.integers(4)
    if wall < 2 and right - left > long + 0.5:
        x, y = rng.uniform(left, right - long), low if wall == 0 else high - deep
        _put(plan, (x, x + long, y, y + deep))
    elif wall >= 2 and high - low > long + 0.5:
        x, y = left if wall == 2 else right - deep, rng.uniform(low, high - long)
        _put(plan, (x, x + deep, y, y + long))


def _pair_of_shelves(plan: Plan, room: tuple[float, float, float, float], rng: Rng) -> None:
    """Two pieces of furniture in one line with a gap as wide as a door between, and room behind: no door."""
    left, right, low, high = room
    gap, deep = rng.uniform(0.8, 1.4), rng.uniform(0.25, 0.5)
    first, second = rng.uniform(0.5, 1.2, 2)
    across = rng.uniform(0.0, 0.04) if rng.random() < 0.5 else rng.uniform(0.0, 0.3)
    total = first + gap + second
    if swap := rng.random() < 0.5:
        left, right, low, high = low, high, left, right
    if right - left < total + 1.0:
        return
    x, y = rng.uniform(left + 0.5, right - total - 0.5), rng.uniform(low + 1.2, high - 1.2 - deep)
    for start, length, offset in ((x, first, 0.0), (x + first + gap, second, across)):
        box = (start, start + length, y + offset, y + offset + deep)
        _put(plan, (box[2], box[3], box[0], box[1]) if swap else box)


def _box(plan: Plan, room: tuple[float, float, float, float], rng: Rng) -> None:
    left, right, low, high = room
    x, y, long, deep = rng.uniform(left, right), rng.uniform(low, high), *rng.uniform(0.15, 0.8, 2)
    if x + long < right and y + deep < high:
        _put(plan, (x, x + long, y, y + deep))


def _legs(plan: Plan, room: tuple[float, float, float, float], rng: Rng) -> None:
    """A table's, a chair's or a person's legs."""
    kind = rng.choice(["table", "chair", "person"])
    angle, x, y = rng.uniform(-np.pi, np.pi), rng.uniform(room[0], room[1]), rng.uniform(room[2], room[3])
    if kind == "person":
        long, radius = rng.uniform(0.08, 0.2), rng.uniform(0.05, 0.08)
        corners = [(long, 0.0), (-long, 0.0)]
    else:
        (long, deep), radius = rng.uniform(0.3, 0.8, 2) if kind == "table" else (0.2, 0.2), rng.uniform(0.015, 0.03)
        corners = [(long, deep), (-long, deep), (-long, -deep), (long, -deep)]
    for u, v in corners:
        at = x + cos(angle) * u - sin(angle) * v, y + sin(angle) * u + cos(angle) * v
        if _holds(room, *at) and not any(_holds(way, *at) for way in plan.doorways):
            plan.legs.append((*at, radius))


def _put(plan: Plan, box: tuple[float, float, float, float]) -> None:
    """Put a piece of furniture where it leaves the doors free."""
    if not any(box[0] < f[1] and f[0] < box[1] and box[2] < f[3] and f[2] < box[3] for f in plan.keep_free):
        plan.polygons.append(_rectangle(*box))


def _holds(box: tuple[float, float, float, float], x: float, y: float) -> bool:
    return box[0] <= x <= box[1] and box[2] <= y <= box[3]


def _rectangle(left: float, right: float, low: float, high: float) -> Floats:
    return np.array([[left, low], [right, low], [right, high], [left, high]])

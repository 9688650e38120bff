"""Scans of floor plans as an LMS200 makes them, with the truth of which doors can be seen in them. Seeded.

The noise: range noise of 5 to 10 mm, beams that fall on two things at once and tell something between, beams without
echo, a spot that is black or of glass.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.data import Door, LaserRead
from benchmarks.door_plans import Floats, Opening, Plan, Rng, draw_plan

Bools = NDArray[np.bool_]

BEAMS, FIELD = 361, pi
MODES = ((8.0, 0.001), (8.0, 0.001), (8.0, 0.001), (32.0, 0.01), (80.0, 0.01))  # range_max and digit, m
CLEARANCE = 0.35  # m around the scanner
FOOTPRINT = 0.0035  # rad to either side of a beam's middle: it is about as wide as the beams are apart
CLEAR = 1.0  # m that must be free beyond a door

# A door that fulfils all of these must be found. One that does not may be found, and is counted neither way.
SURE_BEAMS = 12  # at least, that go through and a metre on
SURE_SHARE = 0.5  # of the beams towards the opening, that do
SURE_ECHOES = 0.4  # of the beams that go through, that meet something: a black wall has no echo either
SURE_VIEW = 1.15  # rad at most between its normal and the view of its middle
SURE_DISTANCE = 7.0  # m at most to either jamb
SURE_JAMB = 0.05  # m to either side of each jamb, where it must be in view
SURE_WALL = 5  # beams at least, on the wall within WALL_BESIDE of each jamb
WALL_BESIDE = 0.6  # m
SURE_WALL_OF_CORRIDOR, CORRIDOR_WALL = 8, 2.0  # beams at least on either wall of a corridor, within m before its end
SURE_SUPPORT = 1.3  # m of wall in view at least, both sides together
LONG = (0.0, 1.3, 1.7)  # m of wall on one side at least, by how many of its ends are open: so end cupboards, too
MOUTH, MOUTH_WALL = 1.6, 0.75  # m: what is wider is no door but a corridor's mouth, and has a wall on both sides
SURE_SUPPORT_OF_CORRIDOR = 1.0  # m at least, of either wall


@dataclass(frozen=True, slots=True)
class Sight:
    """An opening as it is from where the robot is. is_sure: it must be found; else it may be."""

    door: Door
    is_sure: bool


@dataclass(frozen=True, slots=True)
class Case:
    """A scan and the truth."""

    seed: int
    scan: LaserRead
    sights: tuple[Sight, ...]


def cases(first_seed: int, count: int) -> Iterator[Case]:
    """So many scans, each of a plan of its own."""
    for seed in range(first_seed, first_seed + count):
        yield make_case(seed)


def make_case(seed: int) -> Case:
    """One scan of one plan; the same seed gives the same."""
    rng = np.random.default_rng((seed, 1))
    plan = draw_plan(seed)
    place = _free_place(plan, rng)
    return look(plan, seed, (*place, rng.uniform(-pi, pi)))


def look(plan: Plan, seed: int, scanner: tuple[float, float, float], *, is_clean: bool = False) -> Case:
    """Scan a plan from a place of the scanner, with the noise of a seed or without any."""
    rng = np.random.default_rng((seed, 2))
    range_max, digit = MODES[rng.integers(len(MODES))]
    edges, legs = plan.edges(), plan.round_things()
    angles = np.asarray(scanner[2] - FIELD / 2 + np.arange(BEAMS) * (FIELD / (BEAMS - 1)), dtype=np.float64)
    beams = (angles[:, None] + np.array([-FOOTPRINT, 0.0, FOOTPRINT])).ravel()
    hits = cast(scanner[:2], beams, edges, legs).reshape(BEAMS, 3)
    clean: Floats = hits[:, 1]
    ranges = clean.copy() if is_clean else _as_measured(hits, rng)
    ranges = np.where(ranges < range_max, np.round(ranges / digit) * digit, inf)
    sights = tuple(_sight(opening, plan, scanner, angles, clean, (edges, legs), range_max) for opening in plan.openings)
    mount = (0.15, 0.0, 0.0)
    pose = scanner[0] - 0.15 * cos(scanner[2]), scanner[1] - 0.15 * sin(scanner[2]), scanner[2]
    scan = LaserRead(0.0, pose, mount, -FIELD / 2, FIELD / (BEAMS - 1), range_max, ranges)
    return Case(seed, scan, tuple(sight for sight in sights if sight is not None))


def cast(origin: tuple[float, float], directions: Floats, edges: Floats, legs: Floats) -> Floats:
    """How far rays run until they hit an edge or something round; m, infinite where they hit nothing."""
    rays = np.column_stack((np.cos(directions), np.sin(directions)))[:, None, :]
    start, along = edges[:, :2] - origin, edges[:, 2:] - edges[:, :2]
    cross = rays[..., 0] * along[:, 1] - rays[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along a line, which meet none
        far = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        part = (start[:, 0] * rays[..., 1] - start[:, 1] * rays[..., 0]) / cross
        nearest = np.where((far > 0.0) & (part >= 0.0) & (part <= 1.0), far, inf).min(axis=1)
        if len(legs):
            to = legs[:, :2] - origin
            ahead = rays[..., 0] * to[:, 0] + rays[..., 1] * to[:, 1]
            inside = legs[:, 2] ** 2 - (to**2).sum(axis=1) + ahead**2
            near = ahead - np.sqrt(inside)
            nearest = np.minimum(nearest, np.where((inside >= 0.0) & (ahead > 0.0), near, inf).min(axis=1))
    return np.asarray(nearest)


def _free_place(plan: Plan, rng: Rng) -> tuple[float, float]:
    """Somewhere in a room, not too near to anything."""
    edges, legs = plan.edges(), plan.round_things()
    around = np.linspace(-pi, pi, 48, endpoint=False)
    while True:
        left, right, low, high = plan.rooms[rng.integers(len(plan.rooms))]
        x, y = plan.turned(np.array([rng.uniform(left, right), rng.uniform(low, high)]))
        if _is_inside_something(plan, x, y):
            continue
        if cast((x, y), around, edges, legs).min() > CLEARANCE:
            return float(x), float(y)


def _is_inside_something(plan: Plan, x: float, y: float) -> bool:
    for polygon in map(plan.turned, plan.polygons):
        ahead = np.roll(polygon, -1, 0) - polygon
        side = ahead[:, 0] * (y - polygon[:, 1]) - ahead[:, 1] * (x - polygon[:, 0])
        if (side > 0.0).all() or (side < 0.0).all():
            return True
    return False


def _as_measured(hits: Floats, rng: Rng) -> Floats:
    """Range noise, beams on two things at once, beams without echo, a black spot or one of glass."""
    near, far = hits.min(axis=1), hits.max(axis=1)
    with np.errstate(invalid="ignore"):  # infinite ranges, which do not mix
        is_mixed = (far - near > 0.2) & np.isfinite(far) & (rng.random(len(hits)) < 0.4)
        between = near + (far - near) * rng.random(len(hits))
    ranges = np.where(is_mixed, between, hits[:, 1])
    ranges += rng.normal(0.0, rng.uniform(0.005, 0.010), len(ranges))
    ranges[rng.random(len(ranges)) < 0.004] = inf
    if rng.random() < 0.6:
        spot = _spot(hits[:, 1], int(rng.integers(len(ranges))), rng.uniform(0.05, 0.5))
        ranges[spot] = ranges[spot] + rng.uniform(0.3, 3.0) if rng.random() < 0.3 else inf
    return np.maximum(ranges, 0.0)


def _spot(clean: Floats, first: int, width: float) -> slice:
    """The beams of a spot of a wall."""
    last = first
    while last < len(clean) and _chord(clean[first], clean[last], last - first) < width:
        last += 1
    return slice(first, last)


def _chord(a: float, b: float, beams: int) -> float:
    if not (np.isfinite(a) and np.isfinite(b)):
        return inf
    return float(np.sqrt(max(0.0, a * a + b * b - 2 * a * b * cos(beams * FIELD / (BEAMS - 1)))))


def _sight(
    opening: Opening,
    plan: Plan,
    scanner: tuple[float, float, float],
    angles: Floats,
    clean: Floats,
    things: tuple[Floats, Floats],
    range_max: float,
) -> Sight | None:
    """An opening as seen from the scanner; None where it is seen from its edge or lies behind."""
    here = np.array(scanner[:2])
    corners = plan.turned(opening.corners).reshape(2, 2, 2)  # face, jamb, x and y
    nearest = int(np.argmin(np.hypot(*(corners.mean(axis=1) - here).T)))
    along = (corners[0, 1] - corners[0, 0]) / np.hypot(*(corners[0, 1] - corners[0, 0]))
    from_corridor = opening.is_corridor_end and nearest == 0
    if from_corridor:
        nearest = 1  # the corridor ends where its walls do
    jambs = corners[nearest]
    centre, width = jambs.mean(axis=0), float(np.hypot(*(jambs[1] - jambs[0])))
    normal = np.array([-along[1], along[0]])
    if normal @ (centre - here) < 0.0:
        normal = -normal
    distance = float(normal @ (centre - here))
    if distance < 0.02:
        return None
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    closing = rays @ normal
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along the wall, which do not meet it
        at_line = np.where(closing > 0.05, distance / closing, inf)
        side = (at_line[:, None] * rays + here - centre) @ along
        depth = np.minimum(clean, range_max) * closing - distance
        seen_side = (np.minimum(clean, 1e6)[:, None] * rays + here - centre) @ along
    towards = np.isfinite(at_line) & (np.abs(side) < width / 2)
    through = towards & (depth >= CLEAR)
    if from_corridor:
        is_between = bool(np.abs((corners[1] - here) @ along).max() < width)
        on_wall = (np.abs(np.abs(seen_side) - width / 2) < 0.01) & (depth < 0.0) & (depth > -CORRIDOR_WALL)
    else:
        is_between = True
        on_wall = (np.abs(depth) < 0.01) & (np.abs(np.abs(seen_side) - width / 2 - WALL_BESIDE / 2) < WALL_BESIDE / 2)
    beside = [int((on_wall & (np.sign(seen_side) == sign)).sum()) for sign in (-1, 1)]
    support = (
        _length(seen_side[np.abs(depth) < 0.01])
        if not from_corridor
        else min(_length(depth[on_wall & (seen_side * sign > 0)]) for sign in (-1, 1))
    )
    view = abs(atan2(float(along @ (centre - here)), distance))
    is_sure = (
        through.sum() >= SURE_BEAMS
        and through.sum() >= SURE_SHARE * towards.sum()
        and (through & (clean < range_max)).sum() >= SURE_ECHOES * through.sum()
        and view <= SURE_VIEW
        and max(hypot(*(jamb - here)) for jamb in jambs) < min(SURE_DISTANCE, range_max - 0.3)
        and all(_in_view(jamb, inwards, scanner, things) for jamb, inwards in zip(jambs, (along, -along), strict=True))
        and is_between
        and (from_corridor or _is_a_walls(seen_side, depth, width / 2))
        and min(beside) >= (SURE_WALL_OF_CORRIDOR if from_corridor else SURE_WALL)
        and support >= (SURE_SUPPORT_OF_CORRIDOR if from_corridor else SURE_SUPPORT)
    )
    door = Door(float(centre[0]), float(centre[1]), width, atan2(normal[1], normal[0]), 1.0)
    return Sight(door, bool(is_sure))


def _is_a_walls(side: Floats, depth: Floats, half: float) -> bool:
    """Whether what is beside an opening is told from cupboards: its ends are no open ones, or it is long."""
    on = np.flatnonzero(np.abs(depth) < 0.01)
    if not len(on):
        return False
    outside = [at for at in (on[0] - 1, on[-1] + 1) if 0 <= at < len(depth)]
    open_ends = sum(bool(depth[at] > 0.1) for at in outside)
    if half > MOUTH / 2 and (open_ends or min(_beside(side[on], half)) < MOUTH_WALL):
        return False
    return max(_beside(side[on], half)) >= LONG[open_ends]


def _beside(side: Floats, half: float) -> tuple[float, float]:
    return _length(side[side < -half]), _length(side[side > half])


def _length(places: Floats) -> float:
    """Of what is in view of a wall on which beams end at these places, m."""
    steps = np.abs(np.diff(places))
    return float(steps[steps < 0.3].sum())


def _in_view(jamb: Floats, inwards: Floats, scanner: tuple[float, float, float], things: tuple[Floats, Floats]) -> bool:
    """Whether nothing hides what is to both sides of a jamb, and it is in the field of view."""
    for offset in (-SURE_JAMB, SURE_JAMB, 3 * SURE_JAMB):
        point = jamb + offset * inwards - np.array(scanner[:2])
        direction = atan2(point[1], point[0])
        if abs((direction - scanner[2] + pi) % (2 * pi) - pi) > FIELD / 2:
            return False
        hit = cast((scanner[0], scanner[1]), np.array([direction]), *things)[0]
        if hit < hypot(*point) - 0.1:
            return False
    return True

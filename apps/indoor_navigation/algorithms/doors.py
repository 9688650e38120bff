"""Door-like exits in one laser scan: openings in walls, and the ends of corridors.

A door is told from other gaps by its wall. Straight segments are found in the scan, and those in one line make a wall's
line. Each beam crosses that line somewhere; where the beams between two pieces of wall go on behind it for a metre,
there is a door. So a leg before the door, or a leaf that stands open, hides a part of it and no more.

Two pieces of furniture with a gap between are in line, too, but they end in the open: beyond their outer ends one sees
on behind the line, where a wall goes on to the next corner. Hence such a piece counts only where it is long.
"""

from dataclasses import dataclass
from enum import Enum
from math import atan2, hypot

import numpy as np

from apps.indoor_navigation.algorithms.corridor_ends import find_corridor_ends
from apps.indoor_navigation.algorithms.opening import DoorNumbers, Opening
from apps.indoor_navigation.algorithms.segments import Beams, Bools, Ints, Segments, find_segments, fit
from apps.indoor_navigation.data import Door, Floats, LaserRead
from geometry import Pose2D, wrap_angle

SEED = 0.22  # m of the shortest segment of which a line is made
MOST_LINES = 14
IN_LINE = 0.045  # m that a segment may be off another's line,
IN_LINE_RISE = 0.01  # m² more with each m between them, and each 1/m of the other: short ones have no sure direction
ON_WALL = 0.07  # m that a beam's end may be off its wall's line
REVEAL = 0.35  # m: a wall may be as thick
IN_FRONT = 0.25  # m before the line: what is nearer to it, as a leaf at its hinge, shows where the jamb is
HIDDEN = 0.18  # m beside a jamb that something may hide
SHADOW = 1.5  # m of wall that a leaf may hide beside an opening
GRAZING = 0.12  # cosine: lines seen more from the side are not looked at
IN_THE_OPEN = 0.1  # m behind a line, where nothing bounds its end
JOINED = 0.25  # m from the end of a wall, where another one begins
WHOLE = 0.3  # m: points of a wall that are farther apart have no wall between
MANY = 15  # beams through: more are no better


class End(Enum):
    """How a wall ends: where another one joins it, behind something, or in the open, where one sees on behind it."""

    CORNER = "corner"
    HIDDEN = "hidden"
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines of walls, k of them, and how the n beams meet each.

    normals: away from the scanner, shape (2, k). wall: beams that end on the wall, shape (k, n). crossing: where on the
    line a beam crosses it, m counter-clockwise from its foot. along: where along the line the beam ends. depth: how far
    behind the line. is_hit: beams that end on something.
    """

    normals: Floats
    distances: Floats
    wall: Bools
    crossing: Floats
    along: Floats
    depth: Floats
    is_hit: Bools


def find_doors(scan: LaserRead, numbers: DoorNumbers) -> tuple[Door, ...]:
    """The door-like exits in a scan, in odom, the nearest first."""
    beams = Beams.of(scan)
    segments = find_segments(beams)
    if segments is None:
        return ()
    found = _find_in_walls(beams, segments, numbers) + find_corridor_ends(beams, segments, numbers)
    scanner = Pose2D(*scan.pose).compose(Pose2D(*scan.mount))
    kept: list[Opening] = []
    for opening in sorted(found, key=lambda each: -each.confidence):
        if all(_apart(opening, other) for other in kept):
            kept.append(opening)
    kept.sort(key=lambda each: hypot(*each.centre))
    return tuple(_door(opening, scanner) for opening in kept)


def _apart(one: Opening, other: Opening) -> bool:
    (x, y), (u, v) = one.centre, other.centre
    return hypot(x - u, y - v) > (one.width + other.width) / 2.0


def _door(opening: Opening, scanner: Pose2D) -> Door:
    x, y = scanner.transform(*opening.centre)
    normal = wrap_angle(scanner.heading + atan2(opening.normal[1], opening.normal[0]))
    return Door(x, y, opening.width, normal, opening.confidence)


def _find_in_walls(beams: Beams, segments: Segments, numbers: DoorNumbers) -> list[Opening]:
    """Openings between two pieces of one wall."""
    lines = _find_lines(beams, segments)
    if lines is None:
        return []
    line, beam = np.nonzero(lines.wall)
    at = lines.crossing[line, beam]
    gap = at[1:] - at[:-1]
    is_wide = (line[1:] == line[:-1]) & (gap >= numbers.narrowest - numbers.slack) & (gap <= numbers.widest + SHADOW)
    through = np.cumsum(lines.depth >= numbers.clear - numbers.slack, axis=1)
    is_open = through[line[1:], beam[1:]] - through[line[:-1], beam[:-1]] >= numbers.beams
    found = (
        _opening(lines, int(line[k]), int(beam[k]), int(beam[k + 1]), numbers)
        for k in np.flatnonzero(is_wide & is_open)
    )
    return [opening for opening in found if opening is not None]


def _find_lines(beams: Beams, segments: Segments) -> Lines | None:
    """The lines of the longest segments, each made of all segments that are in line with it."""
    seeds = np.argsort(-segments.lengths, kind="stable")[:MOST_LINES]
    seeds = seeds[segments.lengths[seeds] >= SEED]
    if not len(seeds):
        return None
    is_part = _in_line(segments.normals[:, seeds], segments.distances[seeds], segments, seeds)
    normals, distances, _ = fit(segments.moments @ is_part.T)
    is_part = _in_line(normals, distances, segments, None)
    is_own = _first_of_each(is_part[:, seeds].tolist())
    is_part, normals, distances = is_part[is_own], normals[:, is_own], distances[is_own]
    closing = normals.T @ beams.rays
    sliding = normals[0][:, None] * beams.rays[1] - normals[1][:, None] * beams.rays[0]
    depth = beams.ranges * closing - distances[:, None]
    meets = closing > GRAZING
    owners = np.concatenate((is_part, np.zeros((len(is_part), 1), dtype=bool)), axis=1)
    wall = owners[:, segments.of_beam] & meets & (np.abs(depth) < ON_WALL)
    crossing = distances[:, None] * sliding / np.where(meets, closing, GRAZING)
    return Lines(
        normals, distances, wall, crossing, beams.ranges * sliding, np.where(meets, depth, -np.inf), beams.is_hit
    )


def _first_of_each(has: list[list[bool]]) -> list[int]:
    """Of lines, each of which has the seeds of others, those whose seeds no earlier one of them has."""
    chosen: list[int] = []
    for number in range(len(has)):
        if not any(has[earlier][number] for earlier in chosen):
            chosen.append(number)
    return chosen


def _in_line(normals: Floats, distances: Floats, segments: Segments, seeds: Ints | None) -> Bools:
    """Which segments have both ends on which lines."""
    off = np.maximum(
        np.abs(normals.T @ segments.starts - distances[:, None]), np.abs(normals.T @ segments.ends - distances[:, None])
    )
    if seeds is None:
        return np.asarray(off < IN_LINE)
    middles = (segments.starts + segments.ends) / 2.0
    away = np.abs(
        normals[0][:, None] * (middles[1] - middles[1][seeds][:, None])
        - normals[1][:, None] * (middles[0] - middles[0][seeds][:, None])
    )
    return np.asarray(off < IN_LINE + IN_LINE_RISE / segments.lengths[seeds][:, None] * away)


def _opening(lines: Lines, line: int, first: int, last: int, numbers: DoorNumbers) -> Opening | None:
    """The opening between two beams that end on a wall; None where it is no exit."""
    part = slice(first, last + 1)
    crossing, along, depth = lines.crossing[line, part], lines.along[line, part], lines.depth[line, part]
    right = _jamb(crossing, along, depth)
    left = _jamb(-crossing[::-1], -along[::-1], depth[::-1])
    if right is None or left is None:
        return None
    left = -left
    if not numbers.narrowest - numbers.slack <= left - right <= numbers.widest:
        return None
    within = (crossing > right) & (crossing < left)
    is_through = within & (depth >= numbers.clear - numbers.slack)
    through, echoes = int(is_through.sum()), int((is_through & lines.is_hit[part]).sum())
    share = through / max(1, int((within & (depth > -IN_FRONT)).sum()))
    if through < numbers.beams or share < numbers.share or echoes < numbers.echoes * through:
        return None
    support = _support(lines, line, first, last, left - right, numbers)
    if not support:
        return None
    normal = lines.normals[:, line]
    foot = normal * lines.distances[line]
    tangent = np.array([-normal[1], normal[0]])
    (rx, ry), (lx, ly) = (foot + right * tangent).tolist(), (foot + left * tangent).tolist()
    confidence = share * min(1.0, through / MANY) * min(1.0, support / (2.0 * numbers.wall))
    return Opening((lx, ly), (rx, ry), (float(normal[0]), float(normal[1])), confidence)


def _jamb(crossing: Floats, along: Floats, depth: Floats) -> float | None:
    """Where the opening begins after the beam at index 0, which ends on the wall; None where that is hidden."""
    behind = int(np.argmax(depth > ON_WALL))
    if behind > 1 and depth[behind - 1] < -IN_FRONT:
        if crossing[behind] - along[0] > HIDDEN:
            return None
        return float(along[0] + crossing[behind]) / 2.0
    if depth[behind] < REVEAL:
        return float(along[behind])
    return float(along[behind - 1] + crossing[behind]) / 2.0


def _support(lines: Lines, line: int, first: int, last: int, width: float, numbers: DoorNumbers) -> float:
    """How much wall is in view beside an opening, m; nothing where that is too little to be a wall's."""
    wall, along, depth = np.flatnonzero(lines.wall[line]), lines.along[line], lines.depth[line]
    steps = np.diff(along[wall])
    steps = np.where(steps < WHOLE, steps, 0.0)
    split = int(np.searchsorted(wall, first))
    right, left = float(steps[:split].sum()), float(steps[split + 1 :].sum())
    right_end, left_end = _end(along, depth, lines.is_hit, wall[0], -1), _end(along, depth, lines.is_hit, wall[-1], 1)
    is_open, is_mouth = End.OPEN in (right_end, left_end), width > numbers.usual
    other = left_end if right_end is End.OPEN else right_end
    needed = {End.CORNER: numbers.open_wall, End.HIDDEN: numbers.hidden_wall, End.OPEN: numbers.free_wall}[other]
    if right + left < max(numbers.wall, numbers.wall_share * width) or (
        is_open and (is_mouth or max(right, left) < needed)
    ):
        return 0.0
    return right + left if min(right, left) >= (numbers.mouth_wall if is_mouth else numbers.least_wall) else 0.0


def _end(along: Floats, depth: Floats, is_hit: Bools, beam: int, outwards: int) -> End:
    """What is beyond the last beam on a wall."""
    beyond = [number for number in (beam + outwards, beam + 2 * outwards) if 0 <= number < len(depth)]
    if len(beyond) < 2:
        return End.HIDDEN
    if all(is_hit[number] and depth[number] > IN_THE_OPEN for number in beyond):
        return End.OPEN
    is_joined = any(hypot(along[number] - along[beam], depth[number] - depth[beam]) < JOINED for number in beyond)
    return End.CORNER if is_joined else End.HIDDEN

"""Door-like exits in one laser scan: openings in walls, and the ends of corridors.

A door is told from other gaps by its wall. Straight segments are found in the scan, and those in one line make a wall's
line. Each beam crosses that line somewhere; where the beams between two pieces of wall go on behind it for a metre,
there is a door. So a leg before the door, or a leaf that stands open, hides a part of it and no more.

Two pieces of furniture with a gap between are in line, too, but they end in the open: beyond their outer ends one sees
on behind the line, where a wall goes on to the next corner. Or their sides are seen beside the gap, deeper than a wall
is thick. Hence such a piece counts only where it is long.
"""

from dataclasses import dataclass
from math import atan2, hypot

import numpy as np

from apps.indoor_navigation.algorithms.corridor_ends import find_corridor_ends
from apps.indoor_navigation.algorithms.opening import DoorParameters, Opening
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
OFF_LINE = 0.1  # m before or behind a line: what is there tells how the line ends
LOOK = 8  # beams beyond the end of a line that are looked at for that
SURELY_ON = 0.02  # m that the ends of two beams side by side may be off a line to be of its wall,
STEP = 0.02  # and m that they are apart along it at least: those on a wall across are not
MIDST, BLOCKING = 0.15, 2  # m from the jambs, and beams that end on the line there at least: it is no opening
FACE_STEP, OFF_FACE = 0.2, 0.08  # m that points of a jamb's face may be apart, and off the jamb
THICKEST, DEEPEST = 0.27, 0.7  # m: between these, a jamb is as deep as a cupboard
WHOLE = 0.3  # m: points of a wall that are farther apart have no wall between
MANY = 15  # beams through: more are no better


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


def find_doors(scan: LaserRead, parameters: DoorParameters) -> tuple[Door, ...]:
    """The door-like exits in a scan, in odom, the nearest first."""
    beams = Beams.of(scan)
    segments = find_segments(beams)
    if segments is None:
        return ()
    found = _find_in_walls(beams, segments, parameters) + find_corridor_ends(beams, segments, parameters)
    scanner = Pose2D(*scan.pose).compose(Pose2D(*scan.mount))
    kept: list[Opening] = []
    for opening in sorted(found, key=lambda each: -each.confidence):
        if all(_apart(opening, other) for other in kept):
            kept.append(opening)
    kept.sort(key=lambda each: hypot(*each.centre))
    return tuple(_door(opening, scanner) for opening in kept)


def _apart(one: Opening, other: Opening) -> bool:
    """Whether two openings are two; beside a corner of a room, doors are nearer to each other than they are wide."""
    (x, y), (u, v) = one.centre, other.centre
    return hypot(x - u, y - v) > max(one.width, other.width) / 2.0


def _door(opening: Opening, scanner: Pose2D) -> Door:
    x, y = scanner.transform(*opening.centre)
    normal = wrap_angle(scanner.heading + atan2(opening.normal[1], opening.normal[0]))
    return Door(x, y, opening.width, normal, opening.confidence)


def _find_in_walls(beams: Beams, segments: Segments, parameters: DoorParameters) -> list[Opening]:
    """Openings between two pieces of one wall."""
    lines = _find_lines(beams, segments)
    if lines is None:
        return []
    line, beam = np.nonzero(lines.wall)
    at = lines.crossing[line, beam]
    gap = at[1:] - at[:-1]
    is_wide = (
        (line[1:] == line[:-1]) & (gap >= parameters.narrowest - parameters.slack) & (gap <= parameters.widest + SHADOW)
    )
    through = np.cumsum(lines.depth >= parameters.clear - parameters.slack, axis=1)
    is_open = through[line[1:], beam[1:]] - through[line[:-1], beam[:-1]] >= parameters.beams
    found = (
        _opening(lines, int(line[k]), int(beam[k]), int(beam[k + 1]), parameters)
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
    along = beams.ranges * sliding
    in_line = meets & (np.abs(depth) < SURELY_ON)  # as on a stub beside a door, too short to be a segment
    step = along[:, 1:] - along[:, :-1]
    pairs = in_line[:, 1:] & in_line[:, :-1] & (step > STEP) & (step < WHOLE)
    wall[:, 1:] |= pairs
    wall[:, :-1] |= pairs
    crossing = distances[:, None] * sliding / np.where(meets, closing, GRAZING)
    return Lines(normals, distances, wall, crossing, along, np.where(meets, depth, -np.inf), beams.is_hit)


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


def _opening(lines: Lines, line: int, first: int, last: int, parameters: DoorParameters) -> Opening | None:
    """The opening between two beams that end on a wall; None where it is no exit."""
    part = slice(first, last + 1)
    crossing, along, depth = lines.crossing[line, part], lines.along[line, part], lines.depth[line, part]
    right = _jamb(crossing, along, depth, lines.is_hit[part])
    left = _jamb(-crossing[::-1], -along[::-1], depth[::-1], lines.is_hit[part][::-1])
    if right is None or left is None:
        return None
    left = -left
    if not parameters.narrowest - parameters.slack <= left - right <= parameters.widest:
        return None
    within = (crossing > right) & (crossing < left)
    is_through = within & (depth >= parameters.clear - parameters.slack)
    through, echoes = int(is_through.sum()), int((is_through & lines.is_hit[part]).sum())
    share = through / max(1, int((within & (depth > -IN_FRONT)).sum()))
    if through < parameters.beams or share < parameters.share or echoes < parameters.echoes * through:
        return None
    in_midst = (np.abs(depth) < ON_WALL) & (along > right + MIDST) & (along < left - MIDST)
    if int(in_midst.sum()) >= BLOCKING:  # as the hinge of a leaf, which hides the wall beside
        return None
    support = _support(lines, line, first, last, left - right, parameters)
    if not support:
        return None
    normal = lines.normals[:, line]
    foot = normal * lines.distances[line]
    tangent = np.array([-normal[1], normal[0]])
    (rx, ry), (lx, ly) = (foot + right * tangent).tolist(), (foot + left * tangent).tolist()
    confidence = share * min(1.0, through / MANY) * min(1.0, support / (2.0 * parameters.wall))
    return Opening((lx, ly), (rx, ry), (float(normal[0]), float(normal[1])), confidence)


def _jamb(crossing: Floats, along: Floats, depth: Floats, is_hit: Bools) -> float | None:
    """Where the opening begins after the beam at index 0, which ends on the wall; None where that is hidden."""
    is_behind = depth > ON_WALL
    behind = int(np.argmax(is_behind[:-1] & (is_behind[1:] | is_hit[:-1])))
    if behind > 1 and depth[behind - 1] < -IN_FRONT:
        if crossing[behind] - along[0] > HIDDEN:
            return None
        return float(along[0] + crossing[behind]) / 2.0
    if depth[behind] < REVEAL:
        return float(along[behind])
    return float(along[behind - 1] + crossing[behind]) / 2.0


def _support(lines: Lines, line: int, first: int, last: int, width: float, parameters: DoorParameters) -> float:
    """How much wall is in view beside an opening, m; nothing where that is too little to be a wall's."""
    wall, along, depth = np.flatnonzero(lines.wall[line]), lines.along[line], lines.depth[line]
    steps = np.diff(along[wall])
    steps = np.where(steps < WHOLE, steps, 0.0)
    split = int(np.searchsorted(wall, first))
    right, left = float(steps[:split].sum()), float(steps[split + 1 :].sum())
    longest, is_mouth = max(right, left), width > parameters.usual
    if right + left < max(parameters.wall, parameters.wall_share * width):
        return 0.0
    if min(right, left) < (parameters.mouth_wall if is_mouth else parameters.least_wall):
        return 0.0
    open_ends = _is_open(depth, lines.is_hit, wall[0], -1) + _is_open(depth, lines.is_hit, wall[-1], 1)
    if open_ends and (is_mouth or longest < (parameters.open_wall if open_ends == 1 else parameters.free_wall)):
        return 0.0
    if longest < parameters.deep_wall:
        along, depth, is_hit = along[first : last + 1], depth[first : last + 1], lines.is_hit[first : last + 1]
        if _is_deep(along, depth, is_hit) or _is_deep(along[::-1], depth[::-1], is_hit[::-1]):
            return 0.0
    return right + left


def _is_deep(along: Floats, depth: Floats, is_hit: Bools) -> bool:
    """Whether the jamb after the beam at index 0 goes as far back as a cupboard's side: a wall is not so thick.

    What goes back farther is a leaf, or another wall.
    """
    last, back = (float(along[0]), float(depth[0])), 0.0
    for place, behind, has_echo in zip(along[1:].tolist(), depth[1:].tolist(), is_hit[1:].tolist(), strict=True):
        if not has_echo or behind < -OFF_LINE:
            continue
        if hypot(place - last[0], behind - last[1]) > FACE_STEP:
            break
        last = place, behind
        if behind > DEEPEST:
            return False
        if abs(place - along[0]) < OFF_FACE:
            back = behind
    return back > THICKEST


def _is_open(depth: Floats, is_hit: Bools, beam: int, outwards: int) -> bool:
    """Whether a wall's line ends in the open: beyond the last beam on it, what is off it lies behind."""
    for number in range(beam + outwards, beam + LOOK * outwards, outwards):
        if not 0 < number < len(depth) - 1 or depth[number] < -OFF_LINE:
            return False
        if depth[number] > OFF_LINE:
            return bool(is_hit[number] and is_hit[number + outwards] and depth[number + outwards] > OFF_LINE)
    return False

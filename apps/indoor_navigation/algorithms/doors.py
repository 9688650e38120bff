"""Door-like exits in one laser scan: openings in walls, and the ends of corridors.

A door differs from other gaps by its wall. Straight segments of the scan that are in line form the line of a wall. Each
beam crosses that line somewhere; where the beams between two pieces of wall pass it by a metre, there is a door. So a
leg in front of the door, or an open leaf, hides only a part of it.

Two pieces of furniture with a gap between them may be in line as well. But they end in the open: beyond their outer
ends the scan shows places behind the line, where a wall continues to the next corner. Or their sides are seen beside
the gap, deeper than a wall is thick. So such a piece counts only where it is long.
"""

from dataclasses import dataclass
from math import atan2, hypot

import numpy as np

from apps.indoor_navigation.algorithms.corridor_ends import find_corridor_ends
from apps.indoor_navigation.algorithms.opening import DoorParameters, Opening
from apps.indoor_navigation.algorithms.segments import Beams, Segments, find_segments, fit
from apps.indoor_navigation.data import Bools, Door, Floats, Ints, LaserRead
from geometry import Pose2D, wrap_angle

MIN_SEED = 0.22  # m, length of the shortest segment that starts a line
MAX_LINES = 14  # that are examined; the longest segments first, which bounds the time for a scan
LINE_OFFSET = 0.045  # m of a segment from the line of another, if they touch
OFFSET_GROWTH = 0.01  # m more per m between them and per 1/m of the other's length: short ones have no sure direction
WALL_OFFSET = 0.07  # m of a beam's end from the line of its wall
MAX_THICKNESS = 0.35  # m of a wall
MAX_IN_FRONT = 0.25  # m before the line; an object nearer to it, such as a leaf at its hinge, shows the jamb
MAX_HIDDEN = 0.18  # m beside a jamb that an object may hide
MAX_SHADOW = 1.5  # m of wall that a leaf may hide beside an opening
MIN_COSINE = 0.12  # between beam and normal; a line seen at a more grazing angle is not examined
END_OFFSET = 0.1  # m before or behind a line, beyond which a hit shows how the line ends
END_BEAMS = 8  # beams beyond the end of a line that are examined for that
STUB_OFFSET = 0.02  # m of two neighbouring hits from a line, to belong to a stub that is too short for a segment
MIN_STEP = 0.02  # m between them along the line; on a wall across it they are nearer
MIDDLE_MARGIN, MIN_BLOCKING = 0.15, 2  # m from the jambs, and hits on the line between: then it is not an opening
FACE_STEP, FACE_OFFSET = 0.2, 0.08  # m between points of a jamb's face, and of a point from the jamb
MIN_DEEP, MAX_DEEP = 0.27, 0.7  # m; between these, a jamb is as deep as a cupboard
MAX_GAP = 0.3  # m between points of a wall that counts as closed between them
ENOUGH_BEAMS = 15  # through an opening; more do not increase the confidence


@dataclass(frozen=True, slots=True)
class _Lines:
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
    """Return the door-like exits in a scan, in odom, the nearest first."""
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
    """Return whether two openings differ; doors on both sides of a corner may be nearer than they are wide."""
    (x, y), (u, v) = one.centre, other.centre
    return hypot(x - u, y - v) > max(one.width, other.width) / 2.0


def _door(opening: Opening, scanner: Pose2D) -> Door:
    x, y = scanner.transform(*opening.centre)
    normal = wrap_angle(scanner.heading + atan2(opening.normal[1], opening.normal[0]))
    return Door(x, y, opening.width, normal, opening.confidence)


def _find_in_walls(beams: Beams, segments: Segments, parameters: DoorParameters) -> list[Opening]:
    """Return the openings between two pieces of one wall."""
    lines = _find_lines(beams, segments)
    if lines is None:
        return []
    line, beam = np.nonzero(lines.wall)
    at = lines.crossing[line, beam]
    gap = at[1:] - at[:-1]
    is_wide = (
        (line[1:] == line[:-1])
        & (gap >= parameters.narrowest - parameters.slack)
        & (gap <= parameters.widest + MAX_SHADOW)
    )
    through = np.cumsum(lines.depth >= parameters.clear - parameters.slack, axis=1)
    is_open = through[line[1:], beam[1:]] - through[line[:-1], beam[:-1]] >= parameters.beams
    found = (
        _opening(lines, int(line[k]), int(beam[k]), int(beam[k + 1]), parameters)
        for k in np.flatnonzero(is_wide & is_open)
    )
    return [opening for opening in found if opening is not None]


def _find_lines(beams: Beams, segments: Segments) -> _Lines | None:
    """Return the lines of the longest segments, each with all segments that are in line with it."""
    seeds = np.argsort(-segments.lengths, kind="stable")[:MAX_LINES]
    seeds = seeds[segments.lengths[seeds] >= MIN_SEED]
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
    meets = closing > MIN_COSINE
    owners = np.concatenate((is_part, np.zeros((len(is_part), 1), dtype=bool)), axis=1)
    wall = owners[:, segments.of_beam] & meets & (np.abs(depth) < WALL_OFFSET)
    along = beams.ranges * sliding
    in_line = meets & (np.abs(depth) < STUB_OFFSET)  # a stub beside a door, too short for a segment
    step = along[:, 1:] - along[:, :-1]
    pairs = in_line[:, 1:] & in_line[:, :-1] & (step > MIN_STEP) & (step < MAX_GAP)
    wall[:, 1:] |= pairs
    wall[:, :-1] |= pairs
    crossing = distances[:, None] * sliding / np.where(meets, closing, MIN_COSINE)
    return _Lines(normals, distances, wall, crossing, along, np.where(meets, depth, -np.inf), beams.is_hit)


def _first_of_each(has: list[list[bool]]) -> list[int]:
    """Return the lines whose seed no earlier chosen line has; each row tells which seeds a line has."""
    chosen: list[int] = []
    for number in range(len(has)):
        if not any(has[earlier][number] for earlier in chosen):
            chosen.append(number)
    return chosen


def _in_line(normals: Floats, distances: Floats, segments: Segments, seeds: Ints | None) -> Bools:
    """Return which segments have both ends on which lines."""
    off = np.maximum(
        np.abs(normals.T @ segments.starts - distances[:, None]), np.abs(normals.T @ segments.ends - distances[:, None])
    )
    if seeds is None:
        return np.asarray(off < LINE_OFFSET)
    middles = (segments.starts + segments.ends) / 2.0
    away = np.abs(
        normals[0][:, None] * (middles[1] - middles[1][seeds][:, None])
        - normals[1][:, None] * (middles[0] - middles[0][seeds][:, None])
    )
    return np.asarray(off < LINE_OFFSET + OFFSET_GROWTH / segments.lengths[seeds][:, None] * away)


def _opening(lines: _Lines, line: int, first: int, last: int, parameters: DoorParameters) -> Opening | None:
    """Return the opening between two beams that end on a wall; None where it is not an exit."""
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
    share = through / max(1, int((within & (depth > -MAX_IN_FRONT)).sum()))
    if through < parameters.beams or share < parameters.share or echoes < parameters.echoes * through:
        return None
    in_midst = (np.abs(depth) < WALL_OFFSET) & (along > right + MIDDLE_MARGIN) & (along < left - MIDDLE_MARGIN)
    if int(in_midst.sum()) >= MIN_BLOCKING:  # for example the hinge of a leaf, which hides the wall
        return None
    support = _support(lines, line, first, last, left - right, parameters)
    if not support:
        return None
    normal = lines.normals[:, line]
    foot = normal * lines.distances[line]
    tangent = np.array([-normal[1], normal[0]])
    (rx, ry), (lx, ly) = (foot + right * tangent).tolist(), (foot + left * tangent).tolist()
    confidence = share * min(1.0, through / ENOUGH_BEAMS) * min(1.0, support / (2.0 * parameters.wall))
    return Opening((lx, ly), (rx, ry), (float(normal[0]), float(normal[1])), confidence)


def _jamb(crossing: Floats, along: Floats, depth: Floats, is_hit: Bools) -> float | None:
    """Return where the opening begins after beam 0, which ends on the wall; None where that is hidden."""
    is_behind = depth > WALL_OFFSET
    behind = int(np.argmax(is_behind[:-1] & (is_behind[1:] | is_hit[:-1])))
    if behind > 1 and depth[behind - 1] < -MAX_IN_FRONT:
        if crossing[behind] - along[0] > MAX_HIDDEN:
            return None
        return float(along[0] + crossing[behind]) / 2.0
    if depth[behind] < MAX_THICKNESS:
        return float(along[behind])
    return float(along[behind - 1] + crossing[behind]) / 2.0


def _support(lines: _Lines, line: int, first: int, last: int, width: float, parameters: DoorParameters) -> float:
    """Return the length of wall in view beside an opening, m; 0 where it is too short for a wall."""
    wall, along, depth = np.flatnonzero(lines.wall[line]), lines.along[line], lines.depth[line]
    steps = np.diff(along[wall])
    steps = np.where(steps < MAX_GAP, steps, 0.0)
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
    """Return whether the jamb after beam 0 is as deep as the side of a cupboard: a wall is not so thick.

    A face that reaches farther back is a leaf, or another wall.
    """
    last, back = (float(along[0]), float(depth[0])), 0.0
    for place, behind, has_echo in zip(along[1:].tolist(), depth[1:].tolist(), is_hit[1:].tolist(), strict=True):
        if not has_echo or behind < -END_OFFSET:
            continue
        if hypot(place - last[0], behind - last[1]) > FACE_STEP:
            break
        last = place, behind
        if behind > MAX_DEEP:
            return False
        if abs(place - along[0]) < FACE_OFFSET:
            back = behind
    return back > MIN_DEEP


def _is_open(depth: Floats, is_hit: Bools, beam: int, outwards: int) -> bool:
    """Return whether the line of a wall ends in the open: the first hits beyond its last beam are behind it."""
    for number in range(beam + outwards, beam + END_BEAMS * outwards, outwards):
        if not 0 < number < len(depth) - 1 or depth[number] < -END_OFFSET:
            return False
        if depth[number] > END_OFFSET:
            return bool(is_hit[number] and is_hit[number + outwards] and depth[number + outwards] > END_OFFSET)
    return False

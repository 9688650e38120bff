"""Rooms of segments, a robot that drives through them with odometry that errs, and what its scanner sees."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2, cos, hypot, sin

import numpy as np

from geometry import Point, Pose2D, Segment, wrap_angle
from maps.building.readings import BeamView, Floats

BEARINGS = np.radians(np.arange(-90.0, 90.5, 1.0))
REACH = 20.0
NOISE = 0.008  # m


def room(x: float, y: float, width: float, height: float, *doors: tuple[str, float]) -> list[Segment]:
    """The walls of a room with doors of 0.9 m: a side (south, north, west, east) and m along it."""
    sides = {
        "south": ((x, y), (x + width, y)),
        "north": ((x, y + height), (x + width, y + height)),
        "west": ((x, y), (x, y + height)),
        "east": ((x + width, y), (x + width, y + height)),
    }
    walls = []
    for name, ((x1, y1), (x2, y2)) in sides.items():
        length = hypot(x2 - x1, y2 - y1)
        cuts = [0.0] + [cut for side, at in doors if side == name for cut in (at, at + 0.9)] + [length]
        for begin, end in zip(cuts[::2], cuts[1::2], strict=True):
            a, b = begin / length, end / length
            walls.append(Segment(x1 + a * (x2 - x1), y1 + a * (y2 - y1), x1 + b * (x2 - x1), y1 + b * (y2 - y1)))
    return walls


def ring() -> list[Segment]:
    """Four rooms about a court, each with a door to the next two: a loop of 20 m. Walls are two faces, 0.1 m apart."""
    walls = room(0.0, 0.0, 5.0, 4.0, ("east", 1.5), ("north", 2.0))
    walls += room(5.1, 0.0, 4.0, 4.0, ("west", 1.5), ("north", 1.0))
    walls += room(0.0, 4.1, 5.0, 5.0, ("south", 2.0), ("east", 2.5))
    walls += room(5.1, 4.1, 4.0, 5.0, ("south", 1.0), ("west", 2.5))
    return [*walls, Segment(1.0, 7.8, 2.2, 7.8), Segment(2.2, 7.8, 2.2, 8.6), Segment(7.6, 0.0, 7.6, 0.7)]


ROUND: tuple[Point, ...] = ((2.0, 2.0), (7.0, 2.0), (6.5, 6.9), (2.5, 6.6), (2.5, 2.2), (7.0, 2.0), (6.5, 6.0))
"""Through the doors of all rooms of `ring`, and into two of them again."""


def scan(walls: Sequence[Segment], pose: Pose2D, rng: np.random.Generator) -> Floats:
    """Ranges of a scanner in the middle of the robot, m; infinite beyond its reach."""
    table = np.array(walls)
    directions = pose.heading + BEARINGS
    dx, dy = table[:, 2] - table[:, 0], table[:, 3] - table[:, 1]
    ray_x, ray_y = np.cos(directions)[:, None], np.sin(directions)[:, None]
    cross = ray_x * dy - ray_y * dx
    to_x, to_y = table[:, 0] - pose.x, table[:, 1] - pose.y
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along a wall, which do not meet it
        ranges = (to_x * dy - to_y * dx) / cross
        along = (to_x * ray_y - to_y * ray_x) / cross
    met = np.where((ranges >= 0.0) & (along >= 0.0) & (along <= 1.0), ranges, np.inf).min(axis=1)
    result: Floats = np.where(met < REACH, met + rng.normal(0.0, NOISE, len(met)), np.inf)
    return result


def poses_along(way: Sequence[Point], step: float = 0.25) -> Iterator[Pose2D]:
    """Poses on a way, turning on the spot at its corners."""
    heading = None
    for (x1, y1), (x2, y2) in pairwise(way):
        direction, length = atan2(y2 - y1, x2 - x1), hypot(x2 - x1, y2 - y1)
        if heading is not None:
            turn = wrap_angle(direction - heading)
            for part in np.linspace(0.0, 1.0, 2 + int(abs(turn) / 0.3))[1:]:
                yield Pose2D(x1, y1, wrap_angle(heading + part * turn))
        for along in np.arange(0.0, length, step):
            yield Pose2D(x1 + along * cos(direction), y1 + along * sin(direction), direction)
        heading = direction


def drive(
    walls: Sequence[Segment], way: Sequence[Point], seed: int, drift: float = 0.02, origin: Pose2D | None = None
) -> Iterator[tuple[Pose2D, BeamView]]:
    """True poses and views along a way; each metre and each radian err by `drift`, and always to the same side.

    origin: in which odometry begins.
    """
    rng = np.random.default_rng(seed)
    odometry, before = origin or Pose2D(), None
    for number, pose in enumerate(poses_along(way)):
        if before is not None:
            step = pose.relative_to(before)
            length = hypot(step.x, step.y)
            turn = step.heading * (1.0 + drift) + drift * length * rng.uniform(0.2, 1.0)
            odometry = odometry.compose(Pose2D(step.x * (1.0 + drift), step.y, turn))
        before = pose
        ranges = scan(walls, pose, rng)
        seen = np.isfinite(ranges)
        points = ranges[seen, None] * np.stack((np.cos(BEARINGS[seen]), np.sin(BEARINGS[seen])), axis=1)
        yield pose, BeamView(0.1 * number, odometry, np.zeros_like(points), points)

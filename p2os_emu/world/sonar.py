"""Sonar: a cone of sound, sampled by a fan of rays, measured as one range.

A disc hears the nearest surface in its cone that throws the sound back: one met at a slant does not (a specular miss).
A true disc is also a little noisy, and now and then hears a neighbour that fires at the same moment (cross-talk).

The fan is level, so that a disc hears what crosses the plane of the discs (`sonar_scene.py`). In a world with overhangs
a disc has more rays, which rise within the cone: it hears the edge of a table at the distances where one of them meets
it (a top 0.74 m above the floor from 2 m on) and no longer when the robot is near. No ray points down: what ends below
the discs is not heard.
"""

from cmath import rect
from collections.abc import Iterator, Sequence
from math import cos, inf, radians, sin, sqrt
from random import Random

from geometry import Pose2D
from p2os.robot_model import SonarDisc
from p2os_emu.world.fan import Fan
from p2os_emu.world.rays import Hit, Place
from p2os_emu.world.sonar_scene import SonarScene

HEIGHT = 0.2  # m above the floor, of every disc
MAX_RANGE = 5.0  # what the sound can travel there and back within the usual 40 ms of a firing
MIN_RANGE = 0.1  # nearer surfaces read this much: the disc is still ringing
HALF_BEAM = radians(15)
RAYS = 7  # of a disc, 5 degrees apart
ROWS = tuple(radians(rise) for rise in (3.75, 7.5, 11.25, 15.0))  # of rays that rise, in worlds with overhangs
MAX_INCIDENCE = radians(55)  # between sound and surface normal; beyond, a smooth surface throws the sound away
NOISE = 0.01  # standard deviation, of the range
LEAST_NOISE = 0.005  # m
CROSS_TALK = 0.002  # chance that a ping hears a disc that fires with it

# Rays start this far behind the disc, within the hull, so that a wall the robot touches is still in front of the ray.
SETBACK = 0.06
_LENGTH = SETBACK + MAX_RANGE
_ROUNDING = 1e-9  # rad
_LEAST_COSINE = cos(MAX_INCIDENCE)


class SonarRays:
    """The discs of one robot: where their rays run, and what a disc makes of what its rays meet."""

    def __init__(
        self,
        discs: Sequence[SonarDisc],
        random: Random | None,
        scene: SonarScene | None = None,
        *,
        has_overhangs: bool = False,
    ) -> None:
        """Prepare the rays.

        Args:
            discs: Of the robot.
            random: Draws noise and cross-talk; without it the sonar is perfect: the nearest surface in the cone.
            scene: What level rays can meet; without it, only the physics engine knows.
            has_overhangs: Something in the world begins above the floor: there are rays that rise.
        """
        self._random = random
        rises = (0.0, *ROWS) if has_overhangs else (0.0,)
        self._fans = {disc.number: tuple(ray for rise in rises for ray in _fan(disc, rise)) for disc in discs}
        self._scene = None if has_overhangs else scene
        self._level = {disc.number: level_fan(disc.x, disc.y, disc.heading) for disc in discs}

    def rays(self, numbers: Sequence[int], pose: Pose2D) -> tuple[list[Place], list[Place]]:
        """Starts and ends of the rays of discs, disc by disc, for a robot at a pose; m in the world."""
        x, y, c, s = pose.x, pose.y, cos(pose.heading), sin(pose.heading)
        starts, ends = [], []
        for number in numbers:
            for (start_x, start_y, start_z), (end_x, end_y, end_z) in self._fans.get(number, ()):
                starts.append((x + c * start_x - s * start_y, y + s * start_x + c * start_y, start_z))
                ends.append((x + c * end_x - s * end_y, y + s * end_x + c * end_y, end_z))
        return starts, ends

    def in_plane(self, numbers: Sequence[int], pose: Pose2D, own: int) -> list[float] | None:
        """Measure without the physics engine, for a robot at a pose with a body id.

        Returns:
            m from the face of each disc to the nearest surface that reflects the sound, `inf` where there is none; None
            where only the physics engine knows.
        """
        if self._scene is None:
            return None
        least = 0.0 if self._random is None else _LEAST_COSINE  # a perfect disc detects any surface
        found = self._scene.nearest(
            [self._level[number] for number in numbers if number in self._level], pose, own, least
        )
        if found is None:
            return None
        left = iter(found)
        return [next(left) if number in self._level else inf for number in numbers]

    def measure(self, numbers: Sequence[int], ends: Sequence[Place], hits: Sequence[Hit]) -> list[float]:
        """Convert the hits of rays to ranges.

        Args:
            numbers: The discs that fired together.
            ends: Of their rays.
            hits: What their rays met.
        Returns:
            Likewise.
        """
        ranges = []
        first = 0
        for number in numbers:
            last = first + len(self._fans.get(number, ()))
            ranges.append(self._echo(ends[first:last], hits[first:last]))
            first = last
        return ranges

    def hear(self, numbers: Sequence[int], ranges: Sequence[float]) -> list[float]:
        """Add what disturbs true discs.

        Args:
            numbers: The discs that fired together.
            ranges: To the nearest surfaces that reflect the sound, m.
        Returns:
            m from the face of each disc; `inf` where no echo came back, and for a disc that the robot does not have.
        """
        heard = []
        for number, range_ in zip(numbers, ranges, strict=True):
            if self._random and number in self._fans:
                range_ = self._disturbed(range_, self._random, alone=len(numbers) == 1)
            heard.append(max(0.0, range_) if range_ <= MAX_RANGE else inf)
        return heard

    def _echo(self, ends: Sequence[Place], hits: Sequence[Hit]) -> float:
        """Return the range of the nearest surface that reflects the sound; a perfect disc detects any surface."""
        nearest = inf
        for end, (body, _, fraction, place, normal) in zip(ends, hits, strict=True):
            if body >= 0 and fraction < nearest:
                left = _LENGTH * (1 - fraction)
                facing = sum(normal[i] * (place[i] - end[i]) for i in range(3))
                if self._random is None or facing >= _LEAST_COSINE * left:
                    nearest = fraction
        return nearest * _LENGTH - SETBACK

    @staticmethod
    def _disturbed(range_: float, random: Random, *, alone: bool) -> float:
        """Add noise and cross-talk; a disc that fires alone hears no other."""
        if range_ < inf:
            range_ += random.gauss(0.0, max(LEAST_NOISE, NOISE * range_))
        if not alone and random.random() < CROSS_TALK:
            range_ = min(range_, random.uniform(MIN_RANGE, MAX_RANGE))
        return max(MIN_RANGE, range_)


def level_fan(x: float = 0.0, y: float = 0.0, heading: float = 0.0) -> Fan:
    """Return the level rays of a disc at a place on a robot, m, that looks along a heading, rad."""
    return Fan(complex(x, y), heading, [rect(1.0, each) for each in _directions(heading)], SETBACK, MAX_RANGE)


def _fan(disc: SonarDisc, rise: float) -> Iterator[tuple[Place, Place]]:
    """Starts and ends of those rays of a disc that rise by an angle, in `base_link`; the cone is round."""
    half_row = sqrt(max(0.0, HALF_BEAM**2 - rise**2))
    level = cos(rise)
    for direction in _directions(disc.heading):
        if abs(direction - disc.heading) > half_row + _ROUNDING:
            continue
        c, s, up = cos(direction) * level, sin(direction) * level, sin(rise)
        yield (
            (disc.x - SETBACK * c, disc.y - SETBACK * s, HEIGHT - SETBACK * up),
            (disc.x + MAX_RANGE * c, disc.y + MAX_RANGE * s, HEIGHT + MAX_RANGE * up),
        )


def _directions(heading: float) -> list[float]:
    """Of the rays of one row, counter-clockwise, rad."""
    return [heading - HALF_BEAM + 2 * HALF_BEAM * i / (RAYS - 1) for i in range(RAYS)]

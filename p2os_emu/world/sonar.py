"""Sonar: a cone of sound, sampled by a fan of rays, heard as one range.

A disc hears the nearest surface in its cone that throws the sound back: one met at a slant does not (a specular miss).
A true disc is also a little noisy, and now and then hears a neighbour that fires at the same moment (cross-talk).
"""

import math
from collections.abc import Sequence
from math import cos, inf, radians
from random import Random

from geometry import Pose2D
from p2os.robot_model import SonarDisc
from p2os_emu.world.rays import Hit, Ray

MAX_RANGE = 5.0  # what the sound can travel there and back within the usual 40 ms of a firing
MIN_RANGE = 0.1  # nearer surfaces read this much: the disc is still ringing
HALF_BEAM = radians(15)
RAYS = 9  # of a disc
MAX_INCIDENCE = radians(55)  # between sound and surface normal; beyond, a smooth surface throws the sound away
NOISE = 0.01  # standard deviation, of the range
LEAST_NOISE = 0.005  # m
CROSS_TALK = 0.002  # chance that a ping hears a disc that fires with it

# Rays start this far behind the disc, within the hull, so that a wall the robot touches is still in front of the ray.
SETBACK = 0.06


class Sonar:
    """The discs of one robot: where their rays run, and what a disc makes of what its rays meet."""

    def __init__(self, discs: Sequence[SonarDisc], random: Random | None) -> None:
        """`random` draws noise and cross-talk; without it the sonar is perfect: the nearest surface in the cone."""
        self._random = random
        self._fans = {disc.number: _fan(disc) for disc in discs}

    def rays(self, number: int, pose: Pose2D) -> list[Ray]:
        """Starts and ends of a disc's rays for a robot at a pose, m; none for a disc that the robot does not have."""
        origin, turn = complex(pose.x, pose.y), complex(cos(pose.heading), math.sin(pose.heading))
        return [
            Ray(_point(origin + turn * start), _point(origin + turn * end)) for start, end in self._fans.get(number, ())
        ]

    def hear(self, hits: Sequence[Hit], *, alone: bool) -> float:
        """Turn what a disc's rays met into a range.

        Args:
            hits: One per ray.
            alone: No other disc fired at the same moment.
        Returns:
            m from the disc's face; `inf` where no echo came back.
        """
        if self._random is None:
            return max(0.0, min((hit.distance for hit in hits), default=inf) - SETBACK)
        echoes = [hit.distance for hit in hits if hit.cosine >= _LEAST_COSINE]
        range_ = min(echoes, default=inf) - SETBACK
        if range_ < inf:
            range_ += self._random.gauss(0.0, max(LEAST_NOISE, NOISE * range_))
        if hits and not alone and self._random.random() < CROSS_TALK:
            range_ = min(range_, self._random.uniform(MIN_RANGE, MAX_RANGE))
        return max(MIN_RANGE, range_) if range_ <= MAX_RANGE else inf


_LEAST_COSINE = cos(MAX_INCIDENCE)


def _fan(disc: SonarDisc) -> tuple[tuple[complex, complex], ...]:
    """Starts and ends of a disc's rays in `base_link`, x + i y."""
    face = complex(disc.x, disc.y)
    steps = (2 * HALF_BEAM * i / (RAYS - 1) - HALF_BEAM for i in range(RAYS))
    ways = [complex(cos(disc.heading + step), math.sin(disc.heading + step)) for step in steps]
    return tuple((face - SETBACK * way, face + MAX_RANGE * way) for way in ways)


def _point(z: complex) -> tuple[float, float]:
    return z.real, z.imag

"""Rays in a horizontal plane, cast from one robot at everything else."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from geometry import Point
from p2os_emu.world.collision import SEEN_BY_RAYS
from p2os_emu.world.engine import engine

MAX_RAYS = 16384  # the engine takes no more in one call
_STEP_ON = 0.01  # m


class Ray(NamedTuple):
    """From where to where, m in the world."""

    start: Point
    end: Point


class Hit(NamedTuple):
    """What a ray met.

    distance: m from the start of the ray; `inf` where it met nothing.
    cosine: of the angle between the ray and the normal of the surface; 1 is head-on.
    """

    distance: float
    cosine: float


NOTHING = Hit(math.inf, 0.0)


def cast(client: int, rays: Sequence[Ray], height: float, own: int) -> list[Hit]:
    """Follow rays to the first surface.

    Args:
        client: Of the physics engine.
        rays: What to follow, in the world.
        height: Of all of them above the floor, m.
        own: Body id of the robot that casts; it does not see itself.
    """
    hits: list[Hit] = []
    for first in range(0, len(rays), MAX_RAYS):
        batch = rays[first : first + MAX_RAYS]
        found = engine.rayTestBatch(
            [(x, y, height) for (x, y), _ in batch],
            [(x, y, height) for _, (x, y) in batch],
            numThreads=1,
            collisionFilterMask=SEEN_BY_RAYS,
            physicsClientId=client,
        )
        hits.extend(_hit(client, ray, height, own, result) for ray, result in zip(batch, found, strict=True))
    return hits


def _hit(client: int, ray: Ray, height: float, own: int, result: Sequence[Any]) -> Hit:
    body, _, fraction, _, (normal_x, normal_y, _) = result
    if body < 0:
        return NOTHING
    dx, dy = ray.end[0] - ray.start[0], ray.end[1] - ray.start[1]
    length = math.hypot(dx, dy)
    if body == own:
        # A ray that starts inside a hull leaves it unseen, but for one in 30,000, which meets it at its very start.
        on = fraction + _STEP_ON / length
        if on >= 1.0:
            return NOTHING
        ahead = Ray((ray.start[0] + on * dx, ray.start[1] + on * dy), ray.end)
        hit = cast(client, [ahead], height, own)[0]
        return Hit(on * length + hit.distance, hit.cosine)
    return Hit(fraction * length, -(normal_x * dx + normal_y * dy) / length)

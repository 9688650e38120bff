"""Rays of sound cast from one robot at everything else."""

from collections.abc import Sequence
from typing import Any

from p2os_emu.world.collision import HEARD_BY_SONAR
from p2os_emu.world.engine import PhysicsClient

_STEP_ON = 0.002  # of a ray

Place = tuple[float, float, float]
Hit = Sequence[Any]
"""What the engine says of a ray: body id (-1: met nothing), link, fraction of the ray, place, normal of the surface."""


def cast(client: PhysicsClient, starts: Sequence[Place], ends: Sequence[Place], own: int) -> Sequence[Hit]:
    """Follow rays to the first surface.

    Args:
        client: Of the physics engine.
        starts, ends: Of the rays, m in the world; at most 16384, as the engine has it.
        own: Body id of the robot that casts; it does not see itself.
    """
    if not starts:
        return ()
    hits: Sequence[Hit] = client.rayTestBatch(starts, ends, numThreads=1, collisionFilterMask=HEARD_BY_SONAR)
    rays = zip(hits, starts, ends, strict=True)
    return [hit if hit[0] != own else _look_past(client, start, end, own) for hit, start, end in rays]


def _look_past(client: PhysicsClient, start: Place, end: Place, own: int) -> Hit:
    """Cast a ray anew from a little further on.

    A ray that starts inside a hull leaves it unseen, but for one in 30,000, which meets it at its very start.
    """
    on = [a + _STEP_ON * (b - a) for a, b in zip(start, end, strict=True)]
    body, link, fraction, *rest = cast(client, [(on[0], on[1], on[2])], [end], own)[0]
    return body, link, _STEP_ON + (1 - _STEP_ON) * fraction, *rest

"""Movable objects under physics: robots push them, grip them, and see them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from geometry import Polygon, Pose2D
from p2os_emu.world.collision import build_object, build_object_floor, heading_of
from p2os_emu.world.engine import PhysicsClient
from p2os_emu.world.movable import Movable

STANDING = 0.005  # m/s or rad/s; an object that moves no faster stands
LOOKS_AT_REST = 10  # looks in a row that find all objects standing, until they count as being at rest


class MovingObject(NamedTuple):
    """Something that may be elsewhere after the next step, as planar sensors meet it.

    name: of a robot or an object. footprint: its outline seen from above, m. bottom, top: m above the floor. reflector:
    it throws light back where it came from.
    """

    name: str
    footprint: Polygon
    bottom: float
    top: float
    reflector: bool = False


class ObjectPlace(NamedTuple):
    """Where an object's middle is, m in the world, and its heading, rad."""

    x: float
    y: float
    z: float
    heading: float


class Objects:
    """The movable objects of one world."""

    def __init__(self, client: PhysicsClient, movables: Iterable[Movable]) -> None:
        self._client = client
        self._by_id = {build_object(client, movable): movable for movable in movables}
        self._looks_at_rest = 0
        if self._by_id:
            build_object_floor(client)

    def __contains__(self, body_id: int) -> bool:
        return body_id in self._by_id

    @property
    def bodies(self) -> Mapping[int, Movable]:
        """Body ids of the engine, and what they are."""
        return self._by_id

    def places(self) -> dict[str, ObjectPlace]:
        """Where each object is now."""
        return {movable.name: self._place(body) for body, movable in self._by_id.items()}

    def friction(self, body_id: int, other: float) -> float:
        """Coefficient of friction between an object and a surface of the engine's friction `other`."""
        return self._by_id[body_id].friction * other

    def moving(self) -> Iterator[MovingObject]:
        """Each object as it stands or hangs now; one that has fallen over keeps the outline it had upright."""
        for body, movable in self._by_id.items():
            place = self._place(body)
            half = movable.height / 2
            footprint = movable.footprint(Pose2D(place.x, place.y, place.heading))
            yield MovingObject(movable.name, footprint, place.z - half, place.z + half, movable.reflector)

    def watch_for_rest(self) -> bool:
        """Look once more; return whether the last `LOOKS_AT_REST` looks found all standing: what tips begins slowly."""
        self._looks_at_rest = self._looks_at_rest + 1 if all(map(self._stands, self._by_id)) else 0
        return self._looks_at_rest >= LOOKS_AT_REST or not self._by_id

    def _stands(self, body: int) -> bool:
        linear, angular = self._client.getBaseVelocity(body)
        return all(abs(speed) < STANDING for speed in (*linear, *angular))

    def circles(self) -> Iterator[tuple[float, float, float]]:
        """What each object takes up on the floor: x, y, radius, m."""
        for body, movable in self._by_id.items():
            place = self._place(body)
            yield place.x, place.y, movable.reach

    def _place(self, body: int) -> ObjectPlace:
        (x, y, z), quaternion = self._client.getBasePositionAndOrientation(body)
        return ObjectPlace(x, y, z, heading_of(quaternion))

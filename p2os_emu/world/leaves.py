"""The leaves of doors under physics: they slide, wait for whoever stands in the gap, and are seen by every sensor."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from random import Random
from typing import NamedTuple

from geometry import Pose2D
from p2os_emu.hints import nearest
from p2os_emu.world.collision import build_leaf, put
from p2os_emu.world.engine import STEP, PhysicsClient
from p2os_emu.world.errors import WorldError
from p2os_emu.world.moving_doors import LEAF_HEIGHT, LEAF_THICKNESS, MovingDoor
from p2os_emu.world.objects import MovingObject
from p2os_emu.world.presence import Footprint, is_met
from p2os_emu.world.spec import rectangle

MARGIN = 0.1
"""m that a leaf which shuts keeps from whatever stands in the gap."""

Others = Callable[[], Iterable[Footprint]]


class DoorState(NamedTuple):
    """How far a door is open, m, and of how much."""

    opening: float
    width: float


class _Leaf:
    """One leaf. opening: how far it is open, m."""

    def __init__(self, client: PhysicsClient, door: MovingDoor, random: Random) -> None:
        self.door = door
        self._client = client
        self._random = random
        self._width = door.width
        self._jamb = door.frame
        self._gap = Footprint.of(rectangle(self._jamb, door.width, 0.0, LEAF_THICKNESS + 2 * MARGIN))
        self._wants_open = door.is_open
        self._left = self._time_in_this_state()
        self.opening = self._width if door.is_open else 0.0
        self.body = build_leaf(client, door.width, LEAF_THICKNESS, LEAF_HEIGHT)
        self._put()

    @property
    def is_still(self) -> bool:
        """Whether it is at rest."""
        return self._left == math.inf and self.opening == (self._width if self._wants_open else 0.0)

    @property
    def is_wide_open(self) -> bool:
        """Nothing of it is in the gap."""
        return self.opening == self._width

    def set(self, is_open: bool) -> None:
        """Open or shut it for good: it does no more by itself."""
        self._wants_open, self._left = is_open, math.inf

    def step(self, others: Others) -> None:
        """Let `STEP` seconds pass among others, which it does not crush."""
        end = self._width if self._wants_open else 0.0
        if self.opening != end:
            self._slide(end, others)
        else:
            self._left -= STEP
            if self._left <= 0.0:
                self._wants_open = not self._wants_open
                self._left = self._time_in_this_state()

    def _slide(self, end: float, others: Others) -> None:
        if end == 0.0 and is_met(self._gap, others()):
            return
        way = self.door.speed * STEP
        self.opening = min(end, self.opening + way) if end else max(end, self.opening - way)
        self._put()

    def _put(self) -> None:
        x, y = self._jamb.transform(self._width / 2 - self.opening, 0.0)
        place = Pose2D(x, y, self._jamb.heading)
        put(self._client, self.body, place, LEAF_HEIGHT)
        half = self._width / 2
        self.moving = MovingObject(self.door.name, rectangle(place, half, half, LEAF_THICKNESS), 0.0, LEAF_HEIGHT)

    def _time_in_this_state(self) -> float:
        span = self.door.open_time if self._wants_open else self.door.shut_time
        return math.inf if span is None else self._random.uniform(*span)


class Leaves:
    """All doors with a leaf in one world."""

    def __init__(self, client: PhysicsClient, doors: Sequence[MovingDoor], seed: int) -> None:
        self._leaves = {door.name: _Leaf(client, door, Random(f"{seed} {door.name} door")) for door in doors}
        self._busy = [leaf for leaf in self._leaves.values() if not leaf.is_still]

    @property
    def bodies(self) -> Mapping[int, MovingDoor]:
        """Body ids of the engine, and what they are."""
        return {leaf.body: leaf.door for leaf in self._leaves.values()}

    def states(self) -> dict[str, DoorState]:
        """How far each door is open."""
        return {name: DoorState(leaf.opening, leaf.door.width) for name, leaf in self._leaves.items()}

    def set(self, name: str, is_open: bool) -> None:
        """Open or shut a door for good.

        Raises:
            WorldError: There is no such door.
        """
        if name not in self._leaves:
            raise WorldError(f"there is no door {name!r} that moves; {nearest(name, self._leaves)}")
        leaf = self._leaves[name]
        leaf.set(is_open)
        if leaf not in self._busy:
            self._busy.append(leaf)

    def step(self, others: Others) -> None:
        """Let `STEP` seconds pass among robots, people and things."""
        for leaf in self._busy:
            leaf.step(others)
            if leaf.is_still:
                self._busy = [other for other in self._busy if other is not leaf]

    def moving(self) -> Iterator[MovingObject]:
        """Each leaf where it is now."""
        return (leaf.moving for leaf in self._leaves.values())

    def in_gaps(self) -> dict[str, Footprint]:
        """The leaves that somebody would walk into."""
        return {
            name: Footprint.of(leaf.moving.footprint) for name, leaf in self._leaves.items() if not leaf.is_wide_open
        }

"""Who waits where two robots cannot pass each other: each takes the passages on its way before it enters the first.

Passages between which a robot cannot wait are taken together or not at all. So no robot holds one while it waits for
another, and there is no deadlock.
"""

from collections.abc import Mapping, Set

import numpy as np

from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.passages import NarrowPassages, PassageAhead, together
from apps.indoor_navigation.data import Place

ASKING = 2.5  # m before a passage from which on a robot asks for it
WAITING_ROOM = 1.0  # m before a passage where a robot waits
REACH = 0.35  # m about the middle of a robot within which it is in a passage
PATIENCE = 60.0  # s after which it drives on by its sensors, because the other one may be stuck


class RightOfWay:
    """The passages that one robot needs, and those that it has.

    needed: names in their order, to be taken. holders: who has those that were refused.
    """

    def __init__(self) -> None:
        self.needed: tuple[str, ...] = ()
        self.holders: Mapping[str, str] = {}
        self._granted: Set[str] | None = None
        self._passages: NarrowPassages | None = None
        self._known: tuple[FloorMap, NarrowPassages] | None = None
        self._ahead: list[PassageAhead] = []
        self._is_in_first = False
        self._waived: set[str] = set()

    def use_map(self, floor: FloorMap | None) -> None:
        """Find the passages of a map; without a map there are none."""
        if floor is not None and (self._known is None or self._known[0] is not floor):
            self._known = floor, NarrowPassages.of(floor)  # kept while the robot is lost, since it takes some time
        self._passages = self._known[1] if floor is not None and self._known is not None else None
        self.begin()

    def begin(self) -> None:
        """Begin a mission."""
        self.needed, self._ahead, self._waived = (), [], set()

    def look(self, place: Place, way: tuple[Place, ...], waits_for: Set[str]) -> None:
        """Find what is needed.

        Args:
            place: Of the robot, on the map.
            way: From there on; empty without one.
            waits_for: Passages for which it waits aside.
        """
        self.needed, self._ahead = (), []
        if self._passages is None:
            return
        inside = self._passages.around(place, REACH)
        group = together(self._passages.along(np.array(way).reshape(-1, 2)))
        self._ahead = group if group and group[0].enters < ASKING else []
        self._is_in_first = bool(group) and group[0].name in inside
        self.needed = tuple(sorted(inside | {passage.name for passage in self._ahead} | set(waits_for)))

    def grant(self, granted: Set[str] | None, holders: Mapping[str, str]) -> None:
        """Take which passages the robot has; None where nobody gives any, and every robot drives by its sensors."""
        self._granted, self.holders = granted, holders

    def waive(self, names: Set[str]) -> None:
        """Enter these passages without a right from now on."""
        self._waived |= names

    def has(self, names: Set[str]) -> bool:
        """Return whether the robot may enter these passages."""
        return self._granted is None or names <= (self._granted | self._waived)

    @property
    def barred(self) -> PassageAhead | None:
        """The passage before which the robot has to wait now; None where it may drive on."""
        if not self._ahead or self._is_in_first or self.has({passage.name for passage in self._ahead}):
            return None
        return self._ahead[0] if self._ahead[0].enters <= WAITING_ROOM else None

    @property
    def ahead(self) -> frozenset[str]:
        """The names of the passages ahead that are taken together."""
        return frozenset(passage.name for passage in self._ahead)

"""The topological map: doors that were seen, and ways between them that were gone.

Places are what lies between doors; a mission begins and ends in one. A way leads from one node to another; a node
is a door or a place where a mission began or ended.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from math import cos, hypot, pi, sin
from pathlib import Path
from typing import Any

from apps.indoor_navigation.algorithms.planning.search import length
from apps.indoor_navigation.algorithms.planning.terrain import Strip
from apps.indoor_navigation.data import DLEData, Door, Place
from geometry import wrap_angle

SAME = 0.45  # m between the centres of what is taken for one door
SAME_AXIS = 0.6  # rad between normals, whichever way through
SPACING = 0.5  # m between the points of a way that is remembered
HALF_WAY = 0.15  # m to each side of a way that was gone
HALF_WALL = 0.15  # m to each side of where a wall must be
NEWEST = 50.0  # sightings at most that count: a door's place follows slowly, but follows
PLACE = "place"


@dataclass(frozen=True, slots=True)
class MapParameters:
    """When a door is believed, and what follows from it.

    sightings, confidence: at least, for a door to be believed. wall: m to each side of a door where a wall is expected.
    ways: remembered at most.
    """

    sightings: int
    confidence: float
    wall: float
    ways: int


@dataclass(frozen=True, slots=True)
class KnownDoor:
    """One door, the mean of its sightings. normal: either way through, rad. passed: how often it was gone through."""

    x: float
    y: float
    width: float
    normal: float
    confidence: float
    sightings: int = 1
    passed: int = 0

    @property
    def centre(self) -> Place:
        """In odom."""
        return self.x, self.y

    def beside(self, along: float, ahead: float = 0.0) -> Place:
        """A place so many m to the left of its centre, and ahead, for who looks along its normal."""
        return (
            self.x - along * sin(self.normal) + ahead * cos(self.normal),
            self.y + along * cos(self.normal) + ahead * sin(self.normal),
        )

    def crossed(self, start: Place, end: Place) -> float:
        """1 where a straight way leads through it along its normal, -1 against it, 0 where it does not lead through."""
        behind, ahead = self.ahead(start), self.ahead(end)
        if behind == ahead or (behind > 0.0) == (ahead > 0.0):
            return 0.0
        part = behind / (behind - ahead)
        x, y = start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
        if hypot(x - self.x, y - self.y) > self.width / 2.0:
            return 0.0
        return 1.0 if ahead > behind else -1.0

    def ahead(self, place: Place) -> float:
        """How far beyond the door a place is, for who looks along its normal, m."""
        return (place[0] - self.x) * cos(self.normal) + (place[1] - self.y) * sin(self.normal)

    def aside(self, place: Place) -> float:
        """How far to the left of its middle line a place is, for who looks along its normal, m."""
        return (place[1] - self.y) * cos(self.normal) - (place[0] - self.x) * sin(self.normal)

    def is_seen_as(self, seen: Door) -> bool:
        """Whether a sighting is of this door."""
        turn = abs(wrap_angle(seen.normal - self.normal))
        return hypot(seen.x - self.x, seen.y - self.y) < SAME and min(turn, pi - turn) < SAME_AXIS

    def seen_again(self, seen: Door) -> "KnownDoor":
        """With one more sighting, which counts as much as it is sure."""
        before = min(float(self.sightings), NEWEST) * self.confidence
        part = seen.confidence / (before + seen.confidence) if before + seen.confidence > 0.0 else 1.0
        turn = wrap_angle(seen.normal - self.normal)
        turn = turn if abs(turn) < pi / 2.0 else wrap_angle(turn + pi)
        return replace(
            self,
            x=self.x + part * (seen.x - self.x),
            y=self.y + part * (seen.y - self.y),
            width=self.width + part * (seen.width - self.width),
            normal=wrap_angle(self.normal + part * turn),
            confidence=max(self.confidence + part * (seen.confidence - self.confidence), 0.0),
            sightings=self.sightings + 1,
        )


@dataclass(frozen=True, slots=True)
class _KnownWay:
    """A way that was gone. start, end: number of a door, or None for a place."""

    start: int | None
    end: int | None
    points: tuple[Place, ...]

    @property
    def length(self) -> float:
        """m."""
        return length(self.points)


@dataclass
class DoorsMap:
    """What is remembered from mission to mission."""

    parameters: MapParameters
    doors: list[KnownDoor] = field(default_factory=list)
    ways: list[_KnownWay] = field(default_factory=list)

    def see(self, data: DLEData) -> None:
        """Some doors have been seen."""
        for seen in data.doors:
            same = [number for number, door in enumerate(self.doors) if door.is_seen_as(seen)]
            if same:
                nearest = min(same, key=lambda n: hypot(self.doors[n].x - seen.x, self.doors[n].y - seen.y))
                self.doors[nearest] = self.doors[nearest].seen_again(seen)
            else:
                self.doors.append(KnownDoor(seen.x, seen.y, seen.width, seen.normal, seen.confidence))

    def is_believed(self, door: KnownDoor) -> bool:
        """Whether it was seen, or gone through, often enough."""
        parameters = self.parameters
        return door.passed > 0 or (door.sightings >= parameters.sightings and door.confidence >= parameters.confidence)

    @property
    def believed(self) -> list[tuple[int, KnownDoor]]:
        """The doors to plan with, and their numbers."""
        return [(number, door) for number, door in enumerate(self.doors) if self.is_believed(door)]

    def crossed(self, start: Place, end: Place) -> tuple[int, float] | None:
        """The believed door through which a straight way leads, and whether along its normal (1) or against it."""
        for number, door in self.believed:
            if direction := door.crossed(start, end):
                return number, direction
        return None

    def around(self, place: Place, reach: float) -> int | None:
        """The believed door in which a place is, so many m before or behind its line at most."""
        for number, door in self.believed:
            if abs(door.ahead(place)) < reach and abs(door.aside(place)) < door.width / 2.0:
                return number
        return None

    def passed(self, number: int) -> None:
        """Somebody has gone through this door."""
        self.doors[number] = replace(self.doors[number], passed=self.doors[number].passed + 1)

    def gone(self, start: int | None, end: int | None, trail: Sequence[Place]) -> None:
        """A way has been gone from one node to another; between two doors the shortest is kept."""
        points = thinned(trail)
        if len(points) < 2:
            return
        way = _KnownWay(start, end, points)
        same = [other for other in self.ways if _joins(other, way)]
        if any(other.length <= way.length for other in same):
            return
        self.ways = [other for other in self.ways if other not in same] + [way]
        self.ways = self.ways[-self.parameters.ways :]

    def gone_before(self) -> tuple[Strip, ...]:
        """The floor along all ways that were gone."""
        return tuple(Strip(a, b, HALF_WAY) for way in self.ways for a, b in pairwise(way.points))

    def walls(self) -> tuple[Strip, ...]:
        """Where walls must be, since doors are in walls."""
        return tuple(
            Strip(
                door.beside(side * (door.width / 2.0 + HALF_WALL)),
                door.beside(side * (door.width / 2.0 + self.parameters.wall)),
                HALF_WALL,
            )
            for _, door in self.believed
            for side in (-1.0, 1.0)
        )

    def forget(self) -> None:
        """Know nothing any more."""
        self.doors, self.ways = [], []

    def to_json(self) -> dict[str, Any]:
        """For a file or a picture. Doors that are not believed are left out, and ways are numbered anew."""
        numbers: dict[int | None, int] = {old: new for new, (old, _) in enumerate(self.believed)}
        ways = [
            {"from": numbers.get(way.start, PLACE), "to": numbers.get(way.end, PLACE), "points": way.points}
            for way in self.ways
        ]
        return {"doors": [asdict(door) for _, door in self.believed], "ways": ways}

    def remember(self, told: Mapping[str, Any]) -> None:
        """Know what was told to a file, and nothing else.

        Raises:
            ValueError: It is no such map.
        """
        try:
            doors = [KnownDoor(**door) for door in told["doors"]]
            ways = [
                _KnownWay(_node(way["from"], doors), _node(way["to"], doors), tuple((x, y) for x, y in way["points"]))
                for way in told["ways"]
            ]
            if any(not isinstance(value, int | float) for door in doors for value in asdict(door).values()):
                raise ValueError("a door has a value that is no number")
        except (LookupError, TypeError, ValueError) as err:
            raise ValueError(f"this is no map of doors: {err!r}") from err
        self.doors, self.ways = doors, ways

    def read(self, path: Path) -> None:
        """Remember what is in a file, if there is one.

        Raises:
            ValueError: The file cannot be used; says why.
        """
        try:
            self.remember(json.loads(path.read_text(encoding="utf-8")))
        except FileNotFoundError:
            return
        except (OSError, ValueError) as err:
            raise ValueError(f"the map of doors {path} cannot be used: {err}; remove it to begin a new one") from err

    def write(self, path: Path) -> None:
        """Write a file; an existing one is replaced as a whole.

        Raises:
            OSError: It cannot be written.
        """
        beside = path.with_name(path.name + ".new")
        beside.write_text(json.dumps(self.to_json(), indent=1) + "\n", encoding="utf-8")
        beside.replace(path)


def thinned(trail: Sequence[Place], spacing: float = SPACING) -> tuple[Place, ...]:
    """Points of a trail so far apart, its first and last among them."""
    kept = list(trail[:1])
    for point in trail[1:-1]:
        if hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) >= spacing:
            kept.append(point)
    return (*kept, *trail[-1:]) if len(trail) > 1 else tuple(kept)


def _joins(one: _KnownWay, other: _KnownWay) -> bool:
    """Whether both lead from the same door to the same door."""
    doors = {one.start, one.end}
    return (
        None not in doors and doors == {other.start, other.end} and (one.start == one.end) == (other.start == other.end)
    )


def _node(told: Any, doors: Sequence[KnownDoor]) -> int | None:
    if told == PLACE:
        return None
    if not isinstance(told, int) or not 0 <= told < len(doors):
        raise ValueError(f"there is no door {told!r}")
    return told

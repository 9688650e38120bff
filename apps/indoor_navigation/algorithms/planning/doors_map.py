"""The topological map: doors that were seen, and ways between them that the robot has driven.

A way leads from one node to another; a node is a door, or a place where a mission began or ended.
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

SAME_CENTRE = 0.45  # m between the centres of two sightings of one door
SAME_AXIS = 0.6  # rad between their normals, in either direction
SPACING = 0.5  # m between the points of a remembered way
WAY_HALF_WIDTH = 0.3  # m to each side of a remembered way that counts as known floor
WALL_HALF_WIDTH = 0.15  # m to each side of an expected wall
MAX_SIGHTINGS = 50.0  # that count in the mean, so that the place of a door still follows drifting odometry
PLACE = "place"


@dataclass(frozen=True, slots=True)
class MapParameters:
    """When a door is used for planning, and what follows from it.

    sightings, confidence: minimum for a door to be used. wall: m to each side of a door where a wall is expected. ways:
    maximum number of remembered ways.
    """

    sightings: int
    confidence: float
    wall: float
    ways: int


@dataclass(frozen=True, slots=True)
class KnownDoor:
    """One door, the mean of its sightings. normal: direction through it, rad. passed: how often the robot passed it."""

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
        """Return the place so many m to the left of its centre and ahead, seen along its normal."""
        return (
            self.x - along * sin(self.normal) + ahead * cos(self.normal),
            self.y + along * cos(self.normal) + ahead * sin(self.normal),
        )

    def crossed(self, start: Place, end: Place) -> float:
        """Return 1 where a straight way leads through it along its normal, -1 against it, 0 where it does not."""
        behind, ahead = self.ahead(start), self.ahead(end)
        if behind == ahead or (behind > 0.0) == (ahead > 0.0):
            return 0.0
        part = behind / (behind - ahead)
        x, y = start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
        if hypot(x - self.x, y - self.y) > self.width / 2.0:
            return 0.0
        return 1.0 if ahead > behind else -1.0

    def ahead(self, place: Place) -> float:
        """Return how far behind the door a place is, seen along its normal, m."""
        return (place[0] - self.x) * cos(self.normal) + (place[1] - self.y) * sin(self.normal)

    def aside(self, place: Place) -> float:
        """Return how far to the left of its middle line a place is, seen along its normal, m."""
        return (place[1] - self.y) * cos(self.normal) - (place[0] - self.x) * sin(self.normal)

    def is_seen_as(self, seen: Door) -> bool:
        """Return whether a sighting is of this door."""
        turn = abs(wrap_angle(seen.normal - self.normal))
        return hypot(seen.x - self.x, seen.y - self.y) < SAME_CENTRE and min(turn, pi - turn) < SAME_AXIS

    def seen_again(self, seen: Door) -> "KnownDoor":
        """Return the door with one more sighting, weighted by its confidence."""
        before = min(float(self.sightings), MAX_SIGHTINGS) * self.confidence
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
    """A way that the robot has driven. start, end: number of a door, or None for a place."""

    start: int | None
    end: int | None
    points: tuple[Place, ...]

    @property
    def length(self) -> float:
        """m."""
        return length(self.points)


@dataclass
class DoorsMap:
    """Doors and ways that are remembered from mission to mission."""

    parameters: MapParameters
    doors: list[KnownDoor] = field(default_factory=list)
    ways: list[_KnownWay] = field(default_factory=list)

    def see(self, data: DLEData) -> None:
        """Add sightings of doors."""
        for seen in data.doors:
            same = [number for number, door in enumerate(self.doors) if door.is_seen_as(seen)]
            if same:
                nearest = min(same, key=lambda n: hypot(self.doors[n].x - seen.x, self.doors[n].y - seen.y))
                self.doors[nearest] = self.doors[nearest].seen_again(seen)
            else:
                self.doors.append(KnownDoor(seen.x, seen.y, seen.width, seen.normal, seen.confidence))

    def is_believed(self, door: KnownDoor) -> bool:
        """Return whether a door was seen often enough, or passed."""
        parameters = self.parameters
        return door.passed > 0 or (door.sightings >= parameters.sightings and door.confidence >= parameters.confidence)

    @property
    def believed(self) -> list[tuple[int, KnownDoor]]:
        """The doors for planning, and their numbers."""
        return [(number, door) for number, door in enumerate(self.doors) if self.is_believed(door)]

    def crossed(self, start: Place, end: Place) -> tuple[int, float] | None:
        """Return the believed door through which a straight way leads, and 1 along its normal or -1 against it."""
        for number, door in self.believed:
            if direction := door.crossed(start, end):
                return number, direction
        return None

    def around(self, place: Place, reach: float) -> int | None:
        """Return the believed door in which a place is, up to so many m before or behind its line."""
        for number, door in self.believed:
            if abs(door.ahead(place)) < reach and abs(door.aside(place)) < door.width / 2.0:
                return number
        return None

    def passed(self, number: int) -> None:
        """Count a passage through a door."""
        self.doors[number] = replace(self.doors[number], passed=self.doors[number].passed + 1)

    def gone(self, start: int | None, end: int | None, trail: Sequence[Place]) -> None:
        """Remember a way from one node to another; between two doors the shortest one is kept."""
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
        """Return the floor along all remembered ways."""
        return tuple(Strip(a, b, WAY_HALF_WIDTH) for way in self.ways for a, b in pairwise(way.points))

    def walls(self) -> tuple[Strip, ...]:
        """Return the strips beside doors where walls are expected."""
        return tuple(
            Strip(
                door.beside(side * (door.width / 2.0 + WALL_HALF_WIDTH)),
                door.beside(side * (door.width / 2.0 + self.parameters.wall)),
                WALL_HALF_WIDTH,
            )
            for _, door in self.believed
            for side in (-1.0, 1.0)
        )

    def forget(self) -> None:
        """Forget all doors and ways."""
        self.doors, self.ways = [], []

    def to_json(self) -> dict[str, Any]:
        """Return the map for a file or a picture, with believed doors only; the doors are renumbered."""
        numbers: dict[int | None, int] = {old: new for new, (old, _) in enumerate(self.believed)}
        ways = [
            {"from": numbers.get(way.start, PLACE), "to": numbers.get(way.end, PLACE), "points": way.points}
            for way in self.ways
        ]
        return {"doors": [asdict(door) for _, door in self.believed], "ways": ways}

    def remember(self, told: Mapping[str, Any]) -> None:
        """Replace the map by one of `to_json`.

        Raises:
            ValueError: The object is not a valid map.
        """
        try:
            doors = [KnownDoor(**door) for door in told["doors"]]
            ways = [
                _KnownWay(_node(way["from"], doors), _node(way["to"], doors), tuple((x, y) for x, y in way["points"]))
                for way in told["ways"]
            ]
            if any(not isinstance(value, int | float) for door in doors for value in asdict(door).values()):
                raise ValueError("a door has a value that is not a number")
        except (LookupError, TypeError, ValueError) as err:
            raise ValueError(f"this is not a map of doors: {err!r}") from err
        self.doors, self.ways = doors, ways

    def read(self, path: Path) -> None:
        """Remember what is in a file, if there is one.

        Raises:
            ValueError: The file cannot be used; says why.
        """
        try:
            self.remember(json.loads(path.read_text(encoding="utf-8")))
        except FileNotFoundError:  # no doors are known yet
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
    """Return points of a trail at a spacing, m, with its first and last point."""
    kept = list(trail[:1])
    for point in trail[1:-1]:
        if hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) >= spacing:
            kept.append(point)
    return (*kept, *trail[-1:]) if len(trail) > 1 else tuple(kept)


def _joins(one: _KnownWay, other: _KnownWay) -> bool:
    """Return whether both ways connect the same doors."""
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

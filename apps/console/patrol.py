"""Patrols of the surveillance application: rooms, tours and alarms, as its agents publish them. No page, no clock."""

import asyncio
import re
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from apps.console.map_layers import is_number
from apps.console.placing import FramePlaces
from bus import Bus, MessageError, Sample, keys
from bus.aio import hand_over
from bus.bus import Closeable
from geometry import Pose2D

_MANAGER, _PATROL = "*/agents/patrol_manager/results", "*/agents/patrol/results"
_OLD = 4.0  # s after which a patrol is not shown any more; its manager publishes once a second
_MOST_ROOMS, _MOST_ALARMS, _MOST_ROBOTS = 200, 20, 60
_MOST_PICTURES = 20
_LARGEST = 1_000_000  # characters of a picture in base64
_SAME_ALARM = 10.0  # s between an alarm of the team and the picture of it
_IMAGE = re.compile(r"[A-Za-z0-9+/]+={0,2}")
_FORMATS = ("jpeg", "png")


@dataclass(frozen=True, slots=True)
class PatrolRoom:
    """A room. x, y: m in the frame of the map. robot: that has it; empty for none. neglect: s since the last visit."""

    name: str
    x: float
    y: float
    robot: str
    neglect: float
    visits: int


@dataclass(frozen=True, slots=True)
class PatrolAlarm:
    """An intruder. x, y: m in the frame of the map. at: s since 1970. is_seen: whether a robot sees it now.

    picture: address of the image, `data:`; empty without one.
    """

    number: int
    at: float
    x: float
    y: float
    room: str
    robot: str
    sensor: str
    follower: str
    is_seen: bool
    picture: str = ""


@dataclass(frozen=True, slots=True)
class Patrol:
    """What is known of a patrol. tours: rooms of each robot, the next one first. does: in words, by robot."""

    rooms: tuple[PatrolRoom, ...]
    tours: Mapping[str, tuple[str, ...]]
    does: Mapping[str, str]
    alarms: tuple[PatrolAlarm, ...]
    longest: float

    def layout(self, places: FramePlaces) -> dict[str, Any]:
        """Return what is drawn: `tours`, robot and places, and `alarms`, x, y, number and whether it is seen; m."""
        at = {room.name: (room.x, room.y) for room in self.rooms}
        # all robots of a patrol are localized on one map
        frame = next(map(places.map_of, self.tours), Pose2D())

        def shown(x: float, y: float) -> list[float]:
            return [round(each, 3) for each in frame.transform(x, y)]

        tours = [[robot, [shown(*at[room]) for room in tour if room in at]] for robot, tour in self.tours.items()]
        return {
            "tours": tours,
            "alarms": [[*shown(each.x, each.y), each.number, each.is_seen] for each in self.alarms],
        }


@dataclass(frozen=True, slots=True)
class _Picture:
    robot: str
    at: float
    address: str


class PatrolWatch(Closeable):
    """The patrol of the team, kept up to date in one event loop."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        """Subscribe, in a running event loop. clock: returns s; that of a recording while one is shown."""
        self._clock = clock
        self._heard = float("-inf")
        self._told: Mapping[str, Any] = {}
        self._pictures: deque[_Picture] = deque(maxlen=_MOST_PICTURES)
        loop = asyncio.get_running_loop()
        take = partial(hand_over, loop, self.take)
        self._subscriptions = [bus.subscribe(key, take) for key in (_MANAGER, _PATROL)]

    @property
    def patrol(self) -> Patrol | None:
        """The patrol; None while none goes on."""
        if abs(self._clock() - self._heard) > _OLD:
            return None
        return patrol_of(self._told, self._picture_of)

    def take(self, sample: Sample) -> None:
        """Take a result of the manager, or of the agent of a robot; what is malformed is left out."""
        try:
            told = sample.decoded()
        except MessageError:  # of any program; the next one may be right
            return
        if not isinstance(told, Mapping):
            return
        robot, suffix = keys.split(sample.key)
        if suffix.endswith("patrol_manager/results"):
            self._told, self._heard = told, self._clock()
        elif is_number(told.get("stamp")) and (address := image_address(told.get("picture"))):
            self._pictures.append(_Picture(robot, float(told["stamp"]), address))

    def close(self) -> None:
        """End the subscriptions."""
        for each in self._subscriptions:
            each.close()

    def _picture_of(self, robot: str, at: float) -> str:
        """Return the image that a robot made nearest to the time of an alarm, s since 1970; empty without one."""
        near = [each for each in self._pictures if each.robot == robot and abs(each.at - at) <= _SAME_ALARM]
        return min(near, key=lambda each: abs(each.at - at)).address if near else ""


def patrol_of(told: Mapping[str, Any], picture_of: Callable[[str, float], str]) -> Patrol:
    """Return the patrol that a manager has told of; what is malformed is left out.

    Args:
        told: Its result.
        picture_of: Returns the address of the image of a robot at a time, s since 1970; empty without one.
    """
    rooms = [
        PatrolRoom(name, row["x"], row["y"], str(row.get("robot") or ""), row["neglect"], int(row["visits"]))
        for name, row in _rows(told.get("rooms"), _MOST_ROOMS)
        if all(is_number(row.get(each)) for each in ("x", "y", "neglect", "visits"))
    ]
    robots = dict(_rows(told.get("robots"), _MOST_ROBOTS))
    tours = {
        robot: tuple(str(room)[:100] for room in row["rooms"][:_MOST_ROOMS])
        for robot, row in robots.items()
        if isinstance(row.get("rooms"), list)
    }
    stamp, listed = _number(told.get("stamp")) or 0.0, told.get("alarms")
    alarms = [
        _alarm(row, stamp, picture_of)
        for row in (listed[-_MOST_ALARMS:] if isinstance(listed, list) else ())
        if isinstance(row, Mapping) and all(is_number(row.get(each)) for each in ("number", "x", "y", "ago"))
    ]
    does = {robot: str(row.get("does") or "")[:200] for robot, row in robots.items()}
    return Patrol(tuple(rooms), tours, does, tuple(alarms), _number(told.get("longest")) or 0.0)


def image_address(told: Any) -> str:
    """Return the address `data:` of an image, `format` and `data` in base64; empty for anything else."""
    match told:
        case {"format": str(kind), "data": str(data)} if kind in _FORMATS and len(data) <= _LARGEST:
            return f"data:image/{kind};base64,{data}" if _IMAGE.fullmatch(data) else ""
    return ""


def _alarm(row: Mapping[str, Any], stamp: float, picture_of: Callable[[str, float], str]) -> PatrolAlarm:
    robot, at, seen_ago = str(row.get("robot") or "")[:100], stamp - row["ago"], _number(row.get("seen_ago"))
    return PatrolAlarm(
        int(row["number"]),
        at,
        row["x"],
        row["y"],
        str(row.get("room") or "")[:100],
        robot,
        str(row.get("sensor") or "")[:40],
        str(row.get("follower") or "")[:100],
        seen_ago is not None and seen_ago < _OLD,
        picture_of(robot, at),
    )


def _number(value: Any) -> float | None:
    return float(value) if is_number(value) else None


def _rows(value: Any, most: int) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the first objects of an object, with their names."""
    rows = list(value.items())[:most] if isinstance(value, Mapping) else []
    return [(str(name)[:100], row) for name, row in rows if isinstance(row, Mapping)]

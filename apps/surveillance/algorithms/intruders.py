"""From what is unexplained in single readings to intruders: what is seen long enough, and is no furniture."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import dist

from apps.surveillance.algorithms.changes import UnexplainedThing
from apps.surveillance.settings import AlarmSettings
from geometry import Point

_SMOOTHING = 0.4  # share of a new sighting in the place of a thing


class AlarmSensor(StrEnum):
    """What has seen an intruder."""

    LASER = "laser"
    SONAR = "sonar"
    CAMERA = "camera"


@dataclass(slots=True)
class WatchedThing:
    """Something that is not explained, over several readings.

    place: m in `map`. since, seen_at: s of the first and the last sighting. sightings: how many. solid: in how many of
    them it was solid. start: where it was seen first. is_told: it has raised an alarm. sensor: that sees it.
    """

    place: Point
    since: float
    seen_at: float
    sensor: AlarmSensor
    sightings: int = 1
    solid: int = 0
    start: Point = field(default=(0.0, 0.0))
    is_told: bool = False

    @property
    def moved(self) -> float:
        """How far it is from where it was seen first, m."""
        return dist(self.place, self.start)


class IntruderWatch:
    """Follows unexplained things of one robot, and tells which are new intruders. Times are s on any steady clock."""

    def __init__(self, settings: AlarmSettings) -> None:
        self._settings = settings
        self._needed = {
            AlarmSensor.LASER: settings.scans,
            AlarmSensor.SONAR: settings.sonar_readings,
            AlarmSensor.CAMERA: settings.images,
        }
        self._things: list[WatchedThing] = []

    @property
    def intruders(self) -> list[WatchedThing]:
        """Those that have raised an alarm and are still seen."""
        return [each for each in self._things if each.is_told]

    def take(self, now: float, sensor: AlarmSensor, things: Sequence[UnexplainedThing]) -> list[WatchedThing]:
        """Take what one reading shows; returns the intruders that are new.

        Args:
            now: s, of the reading.
            sensor: That made it.
            things: That are unexplained.
        """
        settings = self._settings
        self._things = [each for each in self._things if now - each.seen_at <= settings.forget_s]
        seen: list[WatchedThing] = []
        for thing in sorted(things, key=lambda each: not each.is_solid):
            place = thing.x, thing.y
            if not thing.is_solid and any(dist(each.place, place) <= settings.jump_m for each in seen):
                continue  # the other leg
            seen.append(watched := self._matched(now, sensor, place, seen))
            watched.solid += thing.is_solid
        alarms = [each for each in seen if not each.is_told and self._is_confirmed(each)]
        for each in alarms:
            each.is_told = True
        return alarms

    def settled(self, now: float) -> list[WatchedThing]:
        """Return intruders that have stood still for so long that they are furniture, and watch them no more."""
        limits = self._settings
        settled = [
            each
            for each in self._things
            if each.is_told and each.moved <= limits.still_m and now - each.since >= limits.furniture_s
        ]
        for each in settled:
            self._things.remove(each)
        return settled

    def _is_confirmed(self, thing: WatchedThing) -> bool:
        """Whether it was seen for long enough, each time solid; of what walks a leg is enough, but for one time."""
        is_walking = thing.solid > 0 and thing.moved > self._settings.still_m
        sightings = thing.sightings if is_walking else thing.solid
        lasts = thing.seen_at - thing.since
        return sightings >= self._needed[thing.sensor] and lasts >= self._settings.confirm_s

    def _matched(self, now: float, sensor: AlarmSensor, place: Point, taken: Sequence[WatchedThing]) -> WatchedThing:
        """Return the thing that is seen at a place, a new one if there is none near."""
        best, least = None, self._settings.jump_m
        for each in self._things:
            away = dist(each.place, place)
            if each.sensor is sensor and each not in taken and away <= least:
                best, least = each, away
        if best is None:
            best = WatchedThing(place, now, now, sensor, start=place)
            self._things.append(best)
            return best
        x, y = best.place
        best.place = x + _SMOOTHING * (place[0] - x), y + _SMOOTHING * (place[1] - y)
        best.seen_at, best.sightings = now, best.sightings + 1
        return best


@dataclass(slots=True)
class TeamAlarm:
    """An intruder as the team knows it.

    time: s of the first alarm. place: the latest, m in `map`. seen_at: s. may_be: robots of the team that it may be,
    because nobody knows where they are.
    """

    number: int
    time: float
    robot: str
    sensor: str
    place: Point
    seen_at: float
    follower: str = ""
    may_be: tuple[str, ...] = ()


class TeamAlarms:
    """Alarms of all robots; what several of them see at one place and time is one intruder."""

    def __init__(self, settings: AlarmSettings) -> None:
        self._settings = settings
        self.alarms: list[TeamAlarm] = []

    def take(self, now: float, robot: str, sensor: str, place: Point) -> tuple[TeamAlarm, bool]:
        """Take the alarm or a later sighting of a robot; returns the intruder, and whether it is a new one."""
        for each in reversed(self.alarms):
            is_near = dist(each.place, place) <= self._settings.same_m
            if is_near and now - each.seen_at <= self._settings.same_s:
                each.place, each.seen_at = place, now
                return each, False
        alarm = TeamAlarm(len(self.alarms) + 1, now, robot, sensor, place, now)
        self.alarms.append(alarm)
        return alarm, True

"""The record of one night: what happened, and when rooms were visited."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from geometry import Point

_MOST = 20_000  # moments that are kept; of a longer night, every second, third and so on


@dataclass(frozen=True, slots=True)
class NightAlarm:
    """An alarm: its number, s since the beginning, place (m in `map`), room, who saw it and by which sensor."""

    number: int
    time: float
    place: Point
    room: str
    robot: str
    sensor: str


@dataclass(slots=True)
class NightRecord:
    """What happened, one entry for each look at the status.

    times: s since the beginning. neglect: s by room, at each time. paths: places by robot, m in `map`. told: sentences
    with their times. pictures: of alarms, by number, JPEG or PNG. rooms: places by name. status: the latest.
    """

    times: list[float] = field(default_factory=list)
    neglect: dict[str, list[float]] = field(default_factory=dict)
    paths: dict[str, list[Point]] = field(default_factory=dict)
    told: list[str] = field(default_factory=list)
    pictures: dict[int, list[bytes]] = field(default_factory=dict)
    alarms: dict[int, NightAlarm] = field(default_factory=dict)
    rooms: dict[str, Point] = field(default_factory=dict)
    status: Mapping[str, Any] = field(default_factory=dict)

    def add(self, time: float, status: Mapping[str, Any]) -> None:
        """Add what the manager tells."""
        self.status = status
        self.times.append(time)
        for room, each in status["rooms"].items():
            self.rooms[room] = float(each["x"]), float(each["y"])
            self.neglect.setdefault(room, [0.0] * (len(self.times) - 1)).append(float(each["neglect"]))
        for robot, each in status["robots"].items():
            if each["pose"] is not None:
                self.paths.setdefault(robot, []).append((float(each["pose"][0]), float(each["pose"][1])))
        for each in status["alarms"]:
            number = int(each["number"])
            if number not in self.alarms:
                place = float(each["x"]), float(each["y"])
                begun = max(0.0, time - float(each["ago"]))
                self.alarms[number] = NightAlarm(
                    number, begun, place, str(each["room"]), str(each["robot"]), str(each["sensor"])
                )
        if len(self.times) > _MOST:
            self._thin()

    def summary(self) -> list[str]:
        """Return what there is to say at the end."""
        rooms = self.status.get("rooms", {})
        lines = [
            f"{room}: {each['visits']} visits, longest neglect {each['longest']:.0f} s" for room, each in rooms.items()
        ]
        lines.append(f"{len(self.alarms)} alarms" if len(self.alarms) != 1 else "1 alarm")
        return lines

    def _thin(self) -> None:
        """Keep every second moment."""
        self.times = self.times[::2]
        self.neglect = {room: each[::2] for room, each in self.neglect.items()}
        self.paths = {robot: each[::2] for robot, each in self.paths.items()}


def most_neglected(record: NightRecord) -> Sequence[str]:
    """Rooms by their longest neglect, the longest first."""
    rooms = record.status.get("rooms", {})
    return sorted(rooms, key=lambda room: -float(rooms[room]["longest"]))

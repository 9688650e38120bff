"""The robots on the bus, as the console knows them: descriptions, readings, paths."""

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import hypot
from typing import Any

from apps.console.readings import LatestReading
from bus import Bus, BusError, MessageError, Sample, Subscription, keys
from bus.aio import hand_over, query
from bus.bus import Closeable
from bus.keys import Topic
from bus.messages import heading

_SETTLE = 0.3  # s after the last change of a robot's elements until its description is read
_ATTEMPTS = 5  # to read a description; the time between two is doubled
_ANSWER = 2.0  # s for a description
_TRAIL = 0.05  # m between two points of a path
_MOST_POINTS = 2000  # of a path

Pose = tuple[float, float, float]
"""x and y, m, and heading, rad."""


@dataclass(slots=True)
class WatchedRobot:
    """One robot.

    is_there: whether its gateway lives. description: of the gateway; empty before it has answered. lease: the state of
    its leases; None before it is known. state: the newest RobotState; None before the first. trail: the path driven, x
    and y in odom, m, since the console runs. trail_start: number of points that have been dropped from its beginning.
    """

    name: str
    is_there: bool = False
    description: dict[str, Any] = field(default_factory=dict)
    lease: dict[str, Any] | None = None
    state: Any = None
    trail: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MOST_POINTS))
    readings: dict[str, LatestReading] = field(default_factory=dict)

    @property
    def elements(self) -> dict[str, dict[str, Any]]:
        """The descriptions of its elements, by name."""
        listed = self.description.get("elements")
        rows = listed if isinstance(listed, list) else []
        return {str(row["name"]): row for row in rows if isinstance(row, dict) and "name" in row}

    @property
    def is_emulated(self) -> bool | None:
        """Whether it is emulated; None before that is known."""
        value = self.description.get("emulated")
        return bool(value) if self.description else None

    @property
    def is_connected(self) -> bool:
        """Whether its gateway lives and is connected to it."""
        return self.is_there and self.state is not None and self.state.connection == "connected"

    @property
    def is_stopped(self) -> bool:
        """Whether an emergency stop holds it."""
        return self.state is not None and bool(self.state.estop)

    @property
    def pose(self) -> Pose | None:
        """Where it is in its frame odom; None before that is known."""
        message = self.newest(keys.ODOM)
        if message is None:
            return None
        pose = message.pose.pose
        return float(pose.position.x), float(pose.position.y), heading(pose.orientation)

    def newest(self, topic: Topic) -> Any:
        """Return the newest message of a stream; None if none has come."""
        reading = self.readings.get(topic.suffix)
        return reading.message if reading is not None else None

    def holder(self, element: str = "base") -> str:
        """Return who has the lease on the robot or an element; empty for nobody."""
        lease = self.lease or {}
        elements = lease.get("elements")
        row = elements.get(element) if isinstance(elements, Mapping) else None
        for each in (lease, row):
            if isinstance(each, Mapping) and isinstance(each.get("holder"), str):
                return str(each["holder"])
        return ""


class RobotWatch(Closeable):
    """The robots on a bus, kept up to date in one event loop.

    robots: by name; a robot that has gone is kept, since it may come back. changes: counts the changes of presence,
    descriptions, states and leases. trails_begun: counts how often the paths were replaced. clock: returns the time of
    readings, s.
    """

    ALWAYS = (keys.ODOM, keys.BATTERY, keys.BUMPERS, keys.DIAGNOSTICS)
    """Streams that are subscribed to as long as the robot is there; the others when a page needs them first."""

    def __init__(
        self, bus: Bus, on_event: Callable[[str, str, str], None], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Start watching, in a running event loop.

        Args:
            bus: The bus.
            on_event: Called with the kind of an event, the robot, and what has happened.
            clock: Returns the time of readings, s; that of a recording while one is shown.
        """
        self.clock = clock
        self.robots: dict[str, WatchedRobot] = {}
        self.changes = self.trails_begun = 0
        self._bus = bus
        self._tell = on_event
        self._loop = asyncio.get_running_loop()
        self._reading: dict[str, asyncio.Task[None]] = {}
        self._open: dict[str, list[Subscription]] = {}
        note = partial(hand_over, self._loop, self._note_token)
        self._tokens = [bus.watch_alive(f"*/{token.suffix}", note) for token in (keys.ALIVE, keys.ELEMENT_ALIVE)]

    @property
    def names(self) -> list[str]:
        """The names of all robots, those that have gone included."""
        return sorted(self.robots)

    def reading(self, robot: str, topic: Topic) -> LatestReading:
        """Return the newest reading of a stream; the first call subscribes to it."""
        known = self.robots[robot]
        if topic.suffix not in known.readings:
            known.readings[topic.suffix] = LatestReading(self._bus, topic.key(robot), topic.type_name, self.clock)
        return known.readings[topic.suffix]

    def sample_paths(self) -> None:
        """Note where the robots are, for their paths."""
        for robot in self.robots.values():
            if robot.is_there and (pose := robot.pose) is not None:
                x, y = pose[:2]
                if not robot.trail or hypot(x - robot.trail[-1][0], y - robot.trail[-1][1]) >= _TRAIL:
                    robot.trail.append((x, y))

    def replace_paths(self, paths: Mapping[str, Iterable[tuple[float, float]]]) -> None:
        """Replace the paths of all robots, after a jump in a recording: x and y in odom, m, by robot."""
        for name, robot in self.robots.items():
            robot.trail.clear()
            robot.trail.extend(paths.get(name, ()))
        self.trails_begun += 1

    def close(self) -> None:
        """Stop watching."""
        for token in self._tokens:
            token.close()
        for task in self._reading.values():
            task.cancel()
        for name in list(self._open):
            self._ignore(name)

    def _note_token(self, key: str, is_alive: bool) -> None:
        name, suffix = keys.split(key)
        robot = self.robots.setdefault(name, WatchedRobot(name))
        self.changes += 1
        if suffix == keys.ALIVE.suffix:
            robot.is_there = is_alive
            self._tell("connection", name, "has come" if is_alive else "has gone: its gateway does not run any more")
            if is_alive:
                self._follow(robot)
            else:
                self._ignore(name)
                robot.state = robot.lease = None
        if robot.is_there and (name not in self._reading or self._reading[name].done()):
            self._reading[name] = asyncio.ensure_future(self._read(robot))

    def _follow(self, robot: WatchedRobot) -> None:
        name = robot.name
        self._ignore(name)
        self._open[name] = [
            self._bus.subscribe(keys.STATE.key(name), partial(self._take_state, robot), urgent=True),
            self._bus.subscribe(keys.LEASE_STATE.key(name), partial(self._take_lease, robot), urgent=True),
        ]
        for topic in self.ALWAYS:
            self.reading(name, topic)

    def _ignore(self, name: str) -> None:
        for subscription in self._open.pop(name, ()):
            subscription.close()
        readings = self.robots[name].readings
        for reading in readings.values():
            reading.close()
        readings.clear()

    async def _read(self, robot: WatchedRobot) -> None:
        """Read the description and the leases, once the elements have settled."""
        for attempt in range(_ATTEMPTS):
            before = self.changes
            await asyncio.sleep(_SETTLE * 2.0**attempt)
            try:
                answers = await query(self._bus, keys.DESCRIPTION.key(robot.name), None, _ANSWER)
                leases = await query(self._bus, keys.LEASE_STATE.key(robot.name), {}, _ANSWER)
            except (BusError, TimeoutError):  # asked again in the next round
                continue
            robot.description = answers[0].value
            self._note_lease(robot, leases[0].value)
            if self.changes == before + 1:
                return

    def _take_state(self, robot: WatchedRobot, sample: Sample) -> None:  # on the bus's thread
        try:
            hand_over(self._loop, self._note_state, robot, sample.decoded())
        except MessageError:  # of any program; the next one may be right
            return

    def _note_state(self, robot: WatchedRobot, state: Any) -> None:
        before, robot.state = robot.state, state
        for kind, what in state_events(before, state):
            self._tell(kind, robot.name, what)
        if before is None or _standing_of(before) != _standing_of(state):
            self.changes += 1

    def _take_lease(self, robot: WatchedRobot, sample: Sample) -> None:  # on the bus's thread
        try:
            hand_over(self._loop, self._note_lease, robot, sample.decoded())
        except MessageError:  # likewise
            return

    def _note_lease(self, robot: WatchedRobot, lease: dict[str, Any]) -> None:
        before, robot.lease = robot.lease, lease
        self.changes += 1
        for what in lease_events(before, lease):
            self._tell("lease", robot.name, what)


def state_events(before: Any, state: Any) -> Iterator[tuple[str, str]]:
    """Yield what has happened between two RobotStates of a robot: kind of event, and words.

    Args:
        before: The earlier one; None if there was none, and then nothing has happened.
        state: The later one.
    """
    if before is None:
        return
    if before.connection != state.connection:
        yield "connection", f"is {state.connection}"
    if before.estop != state.estop:
        yield "e-stop", "is held by an emergency stop" if state.estop else "is free again"
    for fault in state.faults:
        if fault not in before.faults:
            yield "refusal" if " was refused" in fault else "fault", fault


def lease_events(before: Mapping[str, Any] | None, lease: Mapping[str, Any]) -> Iterator[str]:
    """Yield in words what has changed between two states of a robot's leases; nothing if there was none before."""
    if before is None:
        return
    was, now = _holders(before), _holders(lease)
    for place in sorted(was.keys() | now.keys()):
        if was.get(place) != now.get(place):
            who = f"{now[place]} has the lease on" if place in now else f"{was[place]} has no lease any more on"
            yield f"{who} the {place}"


def _standing_of(state: Any) -> tuple[Any, ...]:
    return state.connection, state.estop, state.motors, list(state.faults)


def _holders(lease: Mapping[str, Any]) -> dict[str, str]:
    """Return who holds the robot and its elements, by the state of its leases."""
    elements = lease.get("elements")
    rows = {"robot": lease, **(elements if isinstance(elements, Mapping) else {})}
    return {
        str(place): str(row["holder"])
        for place, row in rows.items()
        if isinstance(row, Mapping) and isinstance(row.get("holder"), str)
    }

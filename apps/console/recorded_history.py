"""What a whole recording tells at once: its events, the paths of its robots, and when its slow streams changed."""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from apps.console.recorded_missions import RecordedMissions, is_of_mission
from apps.console.robots import lease_events, state_events
from apps.console.timeline import Timeline
from bus import MessageError, Sample, keys
from recorder.channels import TOKENS
from recorder.recording import McapRecording

_PATH = 200_000_000  # ns between two points of a path
_SLOW = 2.0  # Hz; streams with fewer messages are looked up after a jump
_MONITOR, _MISSIONS = "/agents/monitor/results", "/navigation/user_interface/send/LogMessage"
_MOST_EVENTS = 20_000


@dataclass(slots=True)
class RecordedHistory:
    """What happened in a recording.

    timeline: the events, by the times at which they were recorded. paths: of each robot, times in ns since 1970 and
    points in odom, m. missions: of the indoor navigations. slow: by key, the times of the messages of streams that
    have few, ns since 1970.
    """

    timeline: Timeline
    paths: dict[str, tuple[list[int], list[tuple[float, float]]]] = field(default_factory=dict)
    missions: RecordedMissions = field(default_factory=RecordedMissions)
    slow: dict[str, list[int]] = field(default_factory=dict)

    @classmethod
    def of(cls, recording: McapRecording) -> "RecordedHistory":
        """Read a recording from its beginning to its end; what cannot be decoded is left out."""
        found = cls(Timeline(lambda: recording.start_ns / 1e9, _MOST_EVENTS))
        most = _SLOW * max(recording.duration, 10.0)
        slow = {each.key for each in recording.channels if each.count <= most and is_reading(each.key)}
        reader = _HistoryReader(found)

        def is_wanted(key: str) -> bool:
            return key in slow or key == TOKENS or key.endswith(_MONITOR) or is_of_mission(key) or reader.has(key)

        for time_ns, _, sample in recording.samples(is_wanted=is_wanted):
            if sample.key in slow:
                found.slow.setdefault(sample.key, []).append(time_ns)
            try:
                if is_of_mission(sample.key):
                    found.missions.take(sample.key, sample.decoded(), time_ns)
                reader.take(sample, time_ns)
            except MessageError:  # a malformed message is part of the recording, and no part of the history
                continue
        return found

    def paths_until(self, time_ns: int) -> dict[str, list[tuple[float, float]]]:
        """Return the paths from the beginning to a time: points in odom, m, by robot."""
        return {name: points[: bisect_right(times, time_ns)] for name, (times, points) in self.paths.items()}

    def newest_before(self, time_ns: int) -> dict[str, int]:
        """Return when the newest messages of the slow streams came until a time, ns since 1970, by key."""
        found = {key: bisect_right(times, time_ns) for key, times in self.slow.items()}
        return {key: self.slow[key][count - 1] for key, count in found.items() if count}


class _HistoryReader:
    """Makes events and paths of samples in the order of their times."""

    def __init__(self, history: RecordedHistory) -> None:
        self._history = history
        self._states: dict[str, tuple[bytes, Any]] = {}
        self._leases: dict[str, Mapping[str, Any]] = {}
        self._alive: dict[str, bool] = {}

    def has(self, key: str) -> bool:
        return keys.topic_of(key) in (keys.ODOM, keys.STATE, keys.LEASE_STATE)

    def take(self, sample: Sample, time_ns: int) -> None:
        """Note one sample. Raises: MessageError: It cannot be decoded."""
        key, at, tell = sample.key, time_ns / 1e9, self._history.timeline.tell
        robot, _ = keys.split(key)
        if key == TOKENS:
            self._take_token(sample.decoded(), at)
        elif key.endswith(_MONITOR):
            self._history.timeline.hear_monitor({**sample.decoded(), "time": at})
        elif key.endswith(_MISSIONS):
            self._history.timeline.hear_mission(robot, sample.decoded(), at)
        elif (topic := keys.topic_of(key)) is keys.ODOM:
            self._take_odometry(robot, sample, time_ns)
        elif topic is keys.STATE:
            payload, before = self._states.get(robot) or (b"", None)
            if payload[12:] != sample.payload[12:]:  # without the stamp
                state = sample.decoded()
                self._states[robot] = sample.payload, state
                for kind, what in state_events(before, state):
                    tell(kind, robot, what, at)
        elif topic is keys.LEASE_STATE:
            lease = sample.decoded()
            for what in lease_events(self._leases.get(robot), lease):
                tell("lease", robot, what, at)
            self._leases[robot] = lease

    def _take_token(self, token: Any, at: float) -> None:
        match token:
            case {"key": str(key), "alive": bool(is_alive)} if keys.topic_of(key) is keys.ALIVE:
                if self._alive.get(key, False) != is_alive:
                    words = "has come" if is_alive else "has gone: its gateway does not run any more"
                    self._history.timeline.tell("connection", keys.split(key)[0], words, at)
                self._alive[key] = is_alive

    def _take_odometry(self, robot: str, sample: Sample, time_ns: int) -> None:
        times, points = self._history.paths.setdefault(robot, ([], []))
        if not times or time_ns - times[-1] >= _PATH:
            place = sample.decoded().pose.pose.position
            times.append(time_ns)
            points.append((float(place.x), float(place.y)))


def is_reading(key: str) -> bool:
    """Return whether a key is that of a stream whose newest message holds until the next one."""
    topic = keys.topic_of(key)
    return topic is not None and topic.kind is keys.Kind.STREAM and topic is not keys.RESULT

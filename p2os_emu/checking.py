"""Comparison of a recorded robot with the emulated one, which receives the recorded client's bytes in virtual time.

The host's bytes reach the emulator at their recorded times, so both robots' packets lie on one clock. They are compared
kind by kind: how many, how often, when, how long, and field by field. Rooms differ, so what only the room decides is
left out, and odometry counts from the first SIP of each. A value that the other robot shows within a cycle is the same.
SIPs from before or after the other robot's are not compared: its cycle began at another time.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf, isinf, tau
from statistics import median
from typing import Any, NamedTuple

from p2os import RobotModel
from p2os.fields import POSITION_UNITS
from p2os.sip import SONAR_SIZE
from p2os.wire_log import FrameSource, WireLog, WireLogEntry, plain
from p2os_emu.emulator import Emulator
from p2os_emu.fit import BARE, Fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.recording import RecordedBytes, Recording
from p2os_emu.surroundings import EmulatedSurroundings

LEAD = 0.5
"""s that the emulated robot has been on when the first recorded byte comes."""
SIP = "SIP"
ONE_CYCLE = 0.1
"""s; answers may come so much earlier or later."""
COUNT_SLACK = 0.05
PERIOD_SLACK = 0.1
"""Fractions by which the number of packets and the time between them may differ."""
TOLERANCES: Mapping[str, float] = {
    "x": 0.1,
    "y": 0.1,
    "heading": 0.1,
    "control": 0.1,
    "left_velocity": 0.1,
    "right_velocity": 0.1,
    "rotational_velocity": 0.2,
}
"""By field, SI; other numbers must agree to a thousandth."""
DEFAULT_TOLERANCE = 1e-3
OF_THE_ROOM = frozenset(
    {"sonar", "battery", "battery_fine", "compass", "analog", "charge_state", "temperature", "state_of_charge"}
    | {"controller_time", "readings", "ranges"}
)
"""Fields that the surroundings or the hour decide."""
SIPS_OF_ALL_DISCS = 10
"""In so many SIPs every sonar disc has its turn."""
ODOMETRY = ("x", "y", "heading")


class RecordingDifference(NamedTuple):
    """One way in which the two differ.

    kind: name of the packet. aspect: "number of packets", "period" (s), "time" (of an answer, s), "size" (of the
    payload, without sonar readings, bytes), "sonar numbers" or a field. recorded, emulated: SI.
    packets, of: how many differ of how many compared. time: of the first, s on the recording.
    """

    kind: str
    aspect: str
    recorded: Any
    emulated: Any
    packets: int
    of: int
    time: float

    def as_json(self) -> dict[str, Any]:
        """As plain values."""
        return self._asdict() | {"recorded": plain(self.recorded), "emulated": plain(self.emulated)}

    def __str__(self) -> str:
        how_often = f" in {self.packets} of {self.of}, first at {self.time:.2f} s" if self.of > 1 else ""
        return (
            f"{self.kind}: {self.aspect} differs{how_often}: "
            f"recorded {_shown(self.recorded)}, emulated {_shown(self.emulated)}"
        )


def replay(
    recording: Recording,
    model: RobotModel,
    world: EmulatedSurroundings,
    fit: Fit = BARE,
    seed: int = 0,
    *,
    as_simulator: bool = False,
) -> list[RecordedBytes]:
    """Send the recorded host's bytes to an emulated robot.

    Args:
        recording: Gives the host's bytes, their times and the robot's name.
        model: Of the emulated robot.
        world: An empty one; it is stepped.
        fit: Accessories.
        seed: Of every chance.
        as_simulator: The robot executes the commands of MobileSim.
    Returns:
        What the robot said, on the recording's clock.
    """
    name = recording.identity.name if recording.identity else recording.name or model.name
    emulator = Emulator(world, LinkProfile("ideal"), seed=seed, as_simulator=as_simulator)
    link = MemoryLink()
    emulator.add(name, model, link, fit=fit, cables={part: MemoryLink() for part in fit.cables})
    start = recording.moments[0].time - LEAD - emulator.time
    host = recording.of(FrameSource.HOST)
    said: list[RecordedBytes] = []
    while start + emulator.time < recording.moments[-1].time:
        while host and host[0].time <= start + emulator.time:
            link.client_write(host.pop(0).data)
        emulator.step()
        said += [RecordedBytes(start + emulator.time, FrameSource.ROBOT, data) for data in link.client_read_pieces()]
    emulator.close()
    return said


def compare(
    recorded: Iterable[RecordedBytes], emulated: Iterable[RecordedBytes], model: RobotModel
) -> list[RecordingDifference]:
    """Return the differences between two robots that received the same bytes.

    Args:
        recorded, emulated: What each said; what hosts said is left out.
        model: Gives the scales.
    Returns:
        Nothing where they agree.
    """
    ours, theirs = _by_kind(emulated, model), _by_kind(recorded, model)
    differences: list[RecordingDifference] = []
    for kind in sorted(ours.keys() | theirs.keys()):
        if kind not in ours or kind not in theirs:
            here, there = len(theirs.get(kind, ())), len(ours.get(kind, ()))
            first = (theirs.get(kind) or ours[kind])[0].time
            differences.append(RecordingDifference(kind, "number of packets", here, there, 1, 1, first))
        else:
            differences += _Comparison(kind, theirs[kind], ours[kind], model).differences()
    return differences


def _by_kind(moments: Iterable[RecordedBytes], model: RobotModel) -> dict[str, list[WireLogEntry]]:
    log = WireLog(model)
    kinds: dict[str, list[WireLogEntry]] = {}
    for time, source, data in moments:
        if source is FrameSource.ROBOT:
            for entry in log.receive(source, data, time):
                kinds.setdefault(_kind(entry), []).append(entry)
    return kinds


def _kind(entry: WireLogEntry) -> str:
    if entry.problem:
        return f"{entry.name} ({entry.problem})"
    return SIP if entry.name.startswith("SIP") else entry.name


class _Comparison:
    """The packets of one kind."""

    def __init__(
        self, kind: str, recorded: Sequence[WireLogEntry], emulated: Sequence[WireLogEntry], model: RobotModel
    ) -> None:
        self._kind = kind
        self._recorded = recorded
        self._emulated = emulated
        self._span = POSITION_UNITS * model.scales.distance
        self._pairs = [pair for pair in zip(recorded, self._counterparts(), strict=True) if pair[1]]

    def differences(self) -> list[RecordingDifference]:
        """All of them."""
        found = [*self._numbers(), *self._differing("size", _size, _equal)]
        if self._kind == SIP:
            found += self._sonar()
        else:
            found += self._differing("time", lambda entry: entry.time, lambda a, b: abs(a - b) <= ONE_CYCLE)
        for name in self._recorded[0].fields:
            if name not in OF_THE_ROOM:
                found += self._differing(name, self._reader(name), self._measure(name))
        return found

    def _counterparts(self) -> Iterator[Sequence[WireLogEntry]]:
        """For each recorded packet the emulated ones it may be like: the same in order, or those of the same cycle."""
        if len(self._recorded) == len(self._emulated) and self._kind != SIP:
            yield from ([entry] for entry in self._emulated)
            return
        times = [entry.time for entry in self._emulated]
        for entry in self._recorded:
            if self._kind == SIP and not times[0] <= entry.time <= times[-1]:
                yield []
                continue
            first = bisect_left(times, entry.time - ONE_CYCLE)
            near = self._emulated[first : bisect_right(times, entry.time + ONE_CYCLE)]
            yield near or self._emulated[min(first, len(times) - 1) :][:1]

    def _numbers(self) -> Iterator[RecordingDifference]:
        here, there = len(self._recorded), len(self._emulated)
        first = self._recorded[0].time
        if abs(here - there) > 1 + COUNT_SLACK * here:
            yield RecordingDifference(self._kind, "number of packets", here, there, 1, 1, first)
        if self._kind == SIP and min(here, there) > 2:
            recorded, emulated = _period(self._recorded), _period(self._emulated)
            if abs(recorded - emulated) > PERIOD_SLACK * recorded:
                yield RecordingDifference(self._kind, "period", recorded, emulated, 1, 1, first)

    def _sonar(self) -> Iterator[RecordingDifference]:
        recorded, emulated = _discs(self._recorded), _discs(self._emulated)
        if recorded != emulated and min(len(self._recorded), len(self._emulated)) >= SIPS_OF_ALL_DISCS:
            yield RecordingDifference(SIP, "sonar numbers", recorded, emulated, 1, 1, self._recorded[0].time)

    def _differing(
        self, aspect: str, value: Callable[[WireLogEntry], Any], agree: Callable[[Any, Any], bool]
    ) -> Iterator[RecordingDifference]:
        differing = [
            (value(entry), value(near[len(near) // 2]), entry.time)
            for entry, near in self._pairs
            if not any(agree(value(entry), value(each)) for each in near)
        ]
        if differing:
            recorded, emulated, time = differing[0]
            yield RecordingDifference(self._kind, aspect, recorded, emulated, len(differing), len(self._pairs), time)

    def _reader(self, name: str) -> Callable[[WireLogEntry], Any]:
        """Reads a field; those of odometry from each robot's own start."""
        if self._kind != SIP or name not in ODOMETRY:
            return lambda entry: entry.fields.get(name)
        starts = {id(entry): robot[0].fields[name] for robot in (self._recorded, self._emulated) for entry in robot}
        span = tau if name == "heading" else self._span
        return lambda entry: _around(entry.fields[name] - starts[id(entry)], span)

    def _measure(self, name: str) -> Callable[[Any, Any], bool]:
        tolerance = TOLERANCES.get(name, DEFAULT_TOLERANCE)
        span = {"heading": tau, "control": tau, "x": self._span, "y": self._span}.get(name, inf)
        return lambda a, b: _agree(a, b, tolerance, span)


def _around(difference: float, span: float) -> float:
    """The shorter way round a counter that rolls over after `span`."""
    return difference if isinf(span) else (difference + span / 2) % span - span / 2


def _agree(a: Any, b: Any, tolerance: float, span: float) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return abs(_around(a - b, span)) <= tolerance
    return bool(a == b)


def _size(entry: WireLogEntry) -> int:
    return len(entry.raw) - SONAR_SIZE * len(entry.fields.get("sonar", ()))


def _discs(sips: Sequence[WireLogEntry]) -> tuple[int, ...]:
    """The sonar discs that ever reported."""
    return tuple(sorted({number for sip in sips for number, _ in sip.fields["sonar"]}))


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(plain(value))


def _equal(a: Any, b: Any) -> bool:
    return bool(a == b)


def _period(entries: Sequence[WireLogEntry]) -> float:
    """The usual time between two, s."""
    return median(after.time - before.time for before, after in pairwise(entries))

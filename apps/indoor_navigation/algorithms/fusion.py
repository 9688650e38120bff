"""Command fusion: the weighted mean of the commands of all sources, within the limits of all of them.

The fuser waits for no source. A command counts until the reading that it results from reaches the maximum age of its
source. So a source that has died or hangs neither moves the robot nor stops it, unless it is `required`: without such a
source the robot would be blind, and stands.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import copysign, inf, isfinite

from apps.indoor_navigation.data import MotionCmd

FUSED = "motion_fuser"
LIMITS = "limit", "back", "left", "right"
NON_NEGATIVE = "weight", *LIMITS
NUMBERS = "stamp", "linear", "angular", *NON_NEGATIVE
MAX_GAP = 0.3  # s between two fused commands; after a longer gap the base has stopped the robot
LATE_COMMANDS = 20  # too old on arrival in a row after which it is no delay; each from another reading
MAX_VALUE = 1e6  # of any value of a command except its stamp; a larger one is an error


class InvalidCommand(ValueError):
    """A command has a value that is not a finite number, or a negative weight or limit."""


@dataclass(frozen=True, slots=True)
class CommandSource:
    """How the commands of a source are used.

    The defaults apply to sources that the wiring does not name, and so cannot come from a wiring file.

    max_age: maximum age of the reading of a command, s. weight: factor of the weights of its commands. required: the
    robot stands while there is no young command of this source.
    """

    max_age: float = 0.5
    weight: float = 1.0
    required: bool = False


@dataclass(frozen=True, slots=True)
class FusionParameters:
    """Limits of the fused command, and its sources.

    linear, angular: maximum speeds, m/s and rad/s. acceleration, braking: m/s², for increasing and decreasing speed in
    either direction. angular_acceleration, angular_braking: likewise, rad/s². sources: by name; for others the defaults
    of `CommandSource` apply.
    """

    linear: float
    angular: float
    acceleration: float
    braking: float
    angular_acceleration: float
    angular_braking: float
    sources: dict[str, CommandSource] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SourceCommand:
    """The last command of a source. read_at: time of its reading, s of the fuser's own clock."""

    command: MotionCmd
    read_at: float
    source: CommandSource

    def age(self, now: float) -> float:
        """Return the age of the reading, s."""
        return now - self.read_at

    def is_young(self, now: float) -> bool:
        """Return whether the command may be used."""
        return self.age(now) <= self.source.max_age

    @property
    def weight(self) -> float:
        """Weight of the command in the mean."""
        return self.source.weight * self.command.weight


class Fusion:
    """The last command of each source, and the last fused speed."""

    def __init__(self, parameters: FusionParameters) -> None:
        self._parameters = parameters
        self._heard: dict[str, SourceCommand] = {}
        self._late: dict[str, int] = {}  # readings in a row whose commands were too old on arrival, by source
        self._linear = self._angular = 0.0
        self._fused_at = -inf

    @property
    def heard(self) -> Mapping[str, SourceCommand]:
        """The last command of each source, of any age."""
        return self._heard

    def hear(self, command: MotionCmd, now: float, wall_time: float) -> None:
        """Take a command of a source.

        Args:
            command: The command.
            now: s of the fuser's own clock, which never jumps.
            wall_time: s since 1970. It gives the age of the reading once: when the clock is set later, or the same
                stamp arrives again, the command does not become younger.
        Raises:
            InvalidCommand: The command is ignored, and the previous one remains while it is young.
        """
        _check(command)
        read_at = now - max(0.0, wall_time - command.stamp)
        before = self._heard.get(command.source)
        is_repeated = before is not None and before.command.stamp == command.stamp
        if before is not None and is_repeated:
            read_at = min(read_at, before.read_at)
        source = self._parameters.sources.get(command.source) or CommandSource()
        heard = self._heard[command.source] = SourceCommand(command, read_at, source)
        if not is_repeated:
            self._late[command.source] = 0 if heard.is_young(now) else self._late.get(command.source, 0) + 1

    def is_late(self, source: str) -> bool:
        """Return whether new commands of a required source keep arriving, all of them too old to be used.

        The readings have stamps of another machine, so its clock may be behind.
        """
        heard = self._heard[source]
        return heard.source.required and self._late[source] >= LATE_COMMANDS

    def young(self, now: float) -> list[SourceCommand]:
        """Return the commands that may be used."""
        return [heard for heard in self._heard.values() if heard.is_young(now)]

    def fuse(self, now: float, wall_time: float) -> MotionCmd:
        """Return the command for the base, with the stamp of the newest reading, or of now if there is none.

        The speed changes no faster than the accelerations allow, with two exceptions: limits apply at once, and the
        robot stops at once when all sources or a required one are silent.
        """
        young = self.young(now)
        limit, back, left, right = limits = [_least(young, name) for name in LIMITS]
        if not young or self._is_blind(young):
            self._linear = self._angular = 0.0
        else:
            linear, angular = self._wanted(young)
            self._approach(_between(-back, linear, limit), _between(-right, angular, left), now - self._fused_at)
            self._linear, self._angular = _between(-back, self._linear, limit), _between(-right, self._angular, left)
        self._fused_at = now
        stamp = max((one.command.stamp for one in young), default=wall_time)
        told = (each if isfinite(each) else None for each in limits)
        return MotionCmd(stamp, FUSED, self._linear, self._angular, float(bool(young)), *told)

    def _is_blind(self, young: list[SourceCommand]) -> bool:
        here = {one.command.source for one in young}
        return any(source.required and name not in here for name, source in self._parameters.sources.items())

    def _wanted(self, young: list[SourceCommand]) -> tuple[float, float]:
        """Return the weighted mean of the commands within the maximum speeds, m/s and rad/s."""
        weight = sum(one.weight for one in young)
        if weight == 0.0:
            return 0.0, 0.0
        linear = sum(one.weight * one.command.linear for one in young) / weight
        angular = sum(one.weight * one.command.angular for one in young) / weight
        fastest, swiftest = self._parameters.linear, self._parameters.angular
        return _between(-fastest, linear, fastest), _between(-swiftest, angular, swiftest)

    def _approach(self, linear: float, angular: float, elapsed: float) -> None:
        """Change the speed as far as the accelerations allow in `elapsed` seconds."""
        parameters = self._parameters
        if elapsed > MAX_GAP:
            self._linear = self._angular = elapsed = 0.0
        self._linear = _nearer(self._linear, linear, parameters.acceleration * elapsed, parameters.braking * elapsed)
        self._angular = _nearer(
            self._angular, angular, parameters.angular_acceleration * elapsed, parameters.angular_braking * elapsed
        )


def _check(command: MotionCmd) -> None:
    """Check the values of a command.

    Raises:
        InvalidCommand: A value is not possible.
    """
    if not isinstance(command.source, str):
        raise InvalidCommand(f"source of a command must be the name of a component, not {command.source!r}")
    for name in NUMBERS:
        value = getattr(command, name)
        if value is None and name in LIMITS:
            continue
        if type(value) not in (float, int) or not isfinite(value):  # a bool is an int to `isinstance`
            raise InvalidCommand(f"{name} of a command of {command.source} must be a finite number, not {value!r}")
        if abs(value) > MAX_VALUE and name != "stamp":
            raise InvalidCommand(f"{name} of a command of {command.source} must be within {MAX_VALUE:g}, not {value:g}")
        if value < 0.0 and name in NON_NEGATIVE:
            raise InvalidCommand(f"{name} of a command of {command.source} must not be below 0, as {value:g} is")


def _least(young: list[SourceCommand], name: str) -> float:
    """Return the smallest limit of one name; infinite where there is none."""
    return min((limit for one in young if (limit := getattr(one.command, name)) is not None), default=inf)


def _between(least: float, value: float, most: float) -> float:
    return max(least, min(most, value))


def _nearer(present: float, wanted: float, faster: float, slower: float) -> float:
    """Return the present speed changed towards the wanted one, by `faster` or `slower` at most, and not across 0."""
    if present * wanted < 0.0:
        wanted = 0.0
    step = faster if abs(wanted) > abs(present) else slower
    change = wanted - present
    return wanted if abs(change) <= step else present + copysign(step, change)

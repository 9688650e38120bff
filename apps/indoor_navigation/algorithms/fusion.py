"""One command out of many: the weighted mean of what the sources want, within what all of them allow.

Nobody is waited for. Each command counts from the reading that it follows from until its source's age limit, and no
longer, so that a source that has died or hangs neither moves the robot nor holds it, unless it is `required`: a robot
without it would be blind, and stands.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import copysign, inf, isfinite

from apps.indoor_navigation.data import MotionCmd

FUSED = "motion_fuser"
LIMITS = "limit", "back", "left", "right"
NOT_BELOW_ZERO = "weight", *LIMITS
NUMBERS = "stamp", "linear", "angular", *NOT_BELOW_ZERO
PAUSE = 0.3  # s without a fused command after which the robot stands, whatever the last one was
LARGEST = 1e6  # of any number of a command but its stamp; what is larger is a slip


class Unsound(ValueError):
    """A command that cannot be meant: a number of it is none, or its weight or limit is below zero."""


@dataclass(frozen=True, slots=True)
class CommandSource:
    """What a source's commands are worth.

    max_age: s from its reading for which a command is used. weight: with which its own weights are multiplied.
    required: the robot stands while there is no young command of it.
    """

    max_age: float = 0.5
    weight: float = 1.0
    required: bool = False


@dataclass(frozen=True, slots=True)
class FusionParameters:
    """How the commands of the sources are fused.

    linear, angular: the fastest, m/s and rad/s. acceleration, braking: m/s², towards more and less speed, either way.
    angular_acceleration, angular_braking: likewise, rad/s². sources: by their names; one that is not named is worth
    what `CommandSource` says.
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
    """The last command of a source. read_at: when its reading was made, s of the fuser's own clock."""

    command: MotionCmd
    read_at: float
    source: CommandSource

    def age(self, now: float) -> float:
        """Of the reading, s."""
        return now - self.read_at

    def is_young(self, now: float) -> bool:
        """Whether it may be used."""
        return self.age(now) <= self.source.max_age

    @property
    def weight(self) -> float:
        """Beside those of the others."""
        return self.source.weight * self.command.weight


class Fusion:
    """The last command of each source, and the speed that the robot was told last."""

    def __init__(self, parameters: FusionParameters) -> None:
        self._parameters = parameters
        self._heard: dict[str, SourceCommand] = {}
        self._linear = self._angular = 0.0
        self._fused_at = -inf

    @property
    def heard(self) -> Mapping[str, SourceCommand]:
        """The last command of each source, young or not."""
        return self._heard

    def hear(self, command: MotionCmd, now: float, wall_time: float) -> None:
        """A source has said what it wants.

        Args:
            command: As it has come.
            now: s of the fuser's own clock, which never jumps.
            wall_time: s since 1970. How old the reading is, is asked of it once only: a clock that is set afterwards
                makes nothing young again, and neither does one stamp that comes again and again.
        Raises:
            Unsound: The command is left out, and the one before it stands as long as it is young.
        """
        _check(command)
        read_at = now - max(0.0, wall_time - command.stamp)
        before = self._heard.get(command.source)
        if before is not None and before.command.stamp == command.stamp:
            read_at = min(read_at, before.read_at)
        source = self._parameters.sources.get(command.source) or CommandSource()
        self._heard[command.source] = SourceCommand(command, read_at, source)

    def young(self, now: float) -> list[SourceCommand]:
        """The commands that may be used."""
        return [heard for heard in self._heard.values() if heard.is_young(now)]

    def fuse(self, now: float, wall_time: float) -> MotionCmd:
        """The command for the base, of the newest reading that it follows from, or of now where it follows from none.

        The speed changes no faster than the accelerations allow, but two things are obeyed at once: limits, and the
        silence of all, or of a source that is required.
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
        """What they want, m/s and rad/s, whatever the robot does now."""
        weight = sum(one.weight for one in young)
        if weight == 0.0:
            return 0.0, 0.0
        linear = sum(one.weight * one.command.linear for one in young) / weight
        angular = sum(one.weight * one.command.angular for one in young) / weight
        fastest, swiftest = self._parameters.linear, self._parameters.angular
        return _between(-fastest, linear, fastest), _between(-swiftest, angular, swiftest)

    def _approach(self, linear: float, angular: float, elapsed: float) -> None:
        """Come nearer to a speed, as far as the accelerations allow in `elapsed` seconds."""
        parameters = self._parameters
        if elapsed > PAUSE:
            self._linear = self._angular = elapsed = 0.0
        self._linear = _nearer(self._linear, linear, parameters.acceleration * elapsed, parameters.braking * elapsed)
        self._angular = _nearer(
            self._angular, angular, parameters.angular_acceleration * elapsed, parameters.angular_braking * elapsed
        )


def _check(command: MotionCmd) -> None:
    """See whether a command can be meant.

    Raises:
        Unsound: It cannot; says why.
    """
    if not isinstance(command.source, str):
        raise Unsound(f"a command comes from a component with a name, not from {command.source!r}")
    for name in NUMBERS:
        value = getattr(command, name)
        if value is None and name in LIMITS:
            continue
        if type(value) not in (float, int) or not isfinite(value):  # a bool is an int to `isinstance`
            raise Unsound(f"{name} of a command of {command.source} must be a finite number, not {value!r}")
        if abs(value) > LARGEST and name != "stamp":
            raise Unsound(f"{name} of a command of {command.source} must be within {LARGEST:g}, not {value:g}")
        if value < 0.0 and name in NOT_BELOW_ZERO:
            raise Unsound(f"{name} of a command of {command.source} must not be below 0, as {value:g} is")


def _least(young: list[SourceCommand], name: str) -> float:
    """The smallest of the limits of one name."""
    return min((limit for one in young if (limit := getattr(one.command, name)) is not None), default=inf)


def _between(least: float, value: float, most: float) -> float:
    return max(least, min(most, value))


def _nearer(present: float, wanted: float, faster: float, slower: float) -> float:
    """From the present speed towards the wanted one, by `faster` or `slower` at the most; zero is never passed over."""
    if present * wanted < 0.0:
        wanted = 0.0
    step = faster if abs(wanted) > abs(present) else slower
    change = wanted - present
    return wanted if abs(change) <= step else present + copysign(step, change)

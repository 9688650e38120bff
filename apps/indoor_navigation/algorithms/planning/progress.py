"""Whether the robot comes on."""

from dataclasses import dataclass
from math import hypot, inf

from apps.indoor_navigation.data import ObstRead, Place
from geometry import wrap_angle

Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class ProgressParameters:
    """When the robot is stuck, and what follows.

    stuck: s within which it goes `step` m or turns `turn` rad, or is stuck. dead_end: s likewise in a dead end. around:
    likewise if it moves within so many m for `long` s, whatever it does there. turns: likewise if it has to turn at one
    place more often, since what it then does turns it away again. avoid: m around the place before it that
    is avoided then, for `avoid_for` s. strikes: how often it may be stuck before it gives up; after `fresh` m they
    count no more.
    """

    stuck: float
    step: float
    turn: float
    dead_end: float
    around: float
    long: float
    turns: int
    avoid: float
    avoid_for: float
    strikes: int
    fresh: float


class Progress:
    """Since when the robot is about where it is. All times are s of one clock."""

    def __init__(self, parameters: ProgressParameters) -> None:
        self._parameters = parameters
        self.begin()

    def begin(self) -> None:
        """A mission begins, or the robot's pose was set anew."""
        self._neighbourhood: Place | None = None
        self._strikes, self._struck_at = 0, -inf
        self._around_for, self._checked_at = 0.0, inf
        self._turned_at: Place = (inf, inf)
        self._turns = 0
        self.go_on()

    def go_on(self) -> None:
        """Something else is done from now on; the robot is given its time for that."""
        self._anchor: Pose | None = None
        self._anchored_at, self._dead_end_since = inf, inf
        self._checked_at = inf

    def see(self, reading: ObstRead, now: float) -> None:
        """Note a dead end."""
        self._dead_end_since = min(self._dead_end_since, now) if reading.is_dead_end else inf

    def turn(self, place: Place) -> None:
        """The robot has to turn on its place, before it goes on."""
        if _apart(place, self._turned_at) > self._parameters.step:
            self._turned_at, self._turns = place, 0
        self._turns += 1

    def is_held(self, pose: Pose, now: float) -> bool:
        """Whether it has neither gone nor turned for too long. Asked while it is to move, and only then."""
        parameters, anchor = self._parameters, self._anchor
        if (
            anchor is None
            or _apart(pose, anchor) > parameters.step
            or abs(wrap_angle(pose[2] - anchor[2])) > parameters.turn
        ):
            self._anchor, self._anchored_at = pose, now
        return now - self._anchored_at > parameters.stuck

    def is_stuck(self, pose: Pose, now: float) -> bool:
        """Whether it has come no farther for too long, whatever it did. Asked likewise."""
        parameters, is_held = self._parameters, self.is_held(pose, now)
        if self._neighbourhood is None or _apart(pose, self._neighbourhood) > parameters.around:
            self._neighbourhood, self._around_for = pose[:2], 0.0
        self._around_for += max(now - self._checked_at, 0.0)
        self._checked_at = now
        return (
            is_held
            or now - max(self._anchored_at, self._dead_end_since) > parameters.dead_end
            or self._around_for > parameters.long
            or self._turns > parameters.turns
        )

    def strike(self, travelled: float) -> int:
        """It is stuck once more; returns how often it was about here. travelled: m since the mission began."""
        self._strikes = self._strikes + 1 if travelled - self._struck_at < self._parameters.fresh else 1
        self._struck_at = travelled
        self._neighbourhood, self._turns = None, 0
        self.go_on()
        return self._strikes


def _apart(one: Pose | Place, other: Pose | Place) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])

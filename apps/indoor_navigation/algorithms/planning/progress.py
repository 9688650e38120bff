"""Detection of a robot that is stuck."""

from dataclasses import dataclass
from math import hypot, inf

from apps.indoor_navigation.data import Place, Pose
from geometry import wrap_angle


@dataclass(frozen=True, slots=True)
class ProgressParameters:
    """When the robot counts as stuck, and what follows.

    stuck: s without a motion of `step` m or `turn` rad. around, long: m around a place that it does not leave for s.
    avoid, avoid_for: m around the place ahead that costs more afterwards, for s. strikes: maximum number of times
    before the mission fails; after `fresh` m the count begins again.
    """

    stuck: float
    step: float
    turn: float
    around: float
    long: float
    avoid: float
    avoid_for: float
    strikes: int
    fresh: float


class Progress:
    """How long the robot has been at its place. All times are s of one clock.

    strikes: how often it was stuck around here.
    """

    def __init__(self, parameters: ProgressParameters) -> None:
        self._parameters = parameters
        self.begin()

    def begin(self) -> None:
        """Reset for a new mission, or after odom was set anew."""
        self._neighbourhood: Place | None = None
        self.strikes, self._struck_at = 0, -inf
        self._around_for, self._checked_at = 0.0, inf
        self.go_on()

    def go_on(self) -> None:
        """Restart the times, because the robot does something else from now on."""
        self._anchor: Pose | None = None
        self._anchored_at = inf
        self._checked_at = inf

    def is_held(self, pose: Pose, now: float) -> bool:
        """Return whether the robot has neither driven nor turned for too long; call only while it is to move."""
        parameters, anchor = self._parameters, self._anchor
        if (
            anchor is None
            or _apart(pose, anchor) > parameters.step
            or abs(wrap_angle(pose[2] - anchor[2])) > parameters.turn
        ):
            self._anchor, self._anchored_at = pose, now
        return now - self._anchored_at > parameters.stuck

    def stands_for(self, now: float) -> float:
        """Return for how long the robot has neither driven nor turned, s, as of the last `is_held`."""
        return max(0.0, now - self._anchored_at)

    def is_stuck(self, pose: Pose, now: float) -> bool:
        """Return whether the robot has made no progress for too long; call only while it is to move."""
        parameters, is_held = self._parameters, self.is_held(pose, now)
        if self._neighbourhood is None or _apart(pose, self._neighbourhood) > parameters.around:
            self._neighbourhood, self._around_for = pose[:2], 0.0
        self._around_for += max(now - self._checked_at, 0.0)
        self._checked_at = now
        return is_held or self._around_for > parameters.long

    def strike(self, travelled: float) -> int:
        """Count that the robot is stuck; return how often it was around here. travelled: m of this mission."""
        self.strikes = self.strikes + 1 if travelled - self._struck_at < self._parameters.fresh else 1
        self._struck_at = travelled
        self._neighbourhood = None
        self.go_on()
        return self.strikes


def _apart(one: Pose | Place, other: Pose | Place) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])

"""The situation of the robot: free, obstacle left, right or in front, near, corner, or unknown; with the reason."""

import math
from dataclasses import dataclass
from enum import Enum

from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.surroundings import FlowSurroundings

_SIDE = math.radians(60.0)  # direction of what counts as a side of a corner
_SECTOR = math.radians(40.0)  # width of it
_SEEN = 1.0  # m from the hull; an obstacle that is nearer shows that the images are no empty ones


class FlowSituation(Enum):
    """What the robot reacts to, from the least to the most urgent one.

    UNKNOWN: nothing is known ahead. BLIND: there are no usable images. CONTACT: something touches the robot.
    """

    FREE = "free"
    UNKNOWN = "unknown"
    LEFT = "obstacle left"
    RIGHT = "obstacle right"
    FRONT = "obstacle in front"
    NEAR = "near"
    CORNER = "corner"
    BLIND = "blind"
    CONTACT = "contact"

    @property
    def urgency(self) -> int:
        """Rank; left and right have the same."""
        order = list(FlowSituation)
        return order.index(FlowSituation.LEFT) if self is FlowSituation.RIGHT else order.index(self)


@dataclass(frozen=True, slots=True)
class SituationJudgement:
    """A situation and the reason for it, in words."""

    situation: FlowSituation
    reason: str


def judge(around: FlowSurroundings, settings: FlowSettings) -> SituationJudgement:
    """Return the situation by what is around the robot."""
    limits, speed = settings.situation, settings.drive.speed_m_s
    contact = max(0.0, around.ahead) / speed
    left, right = around.toward(_SIDE, _SECTOR), around.toward(-_SIDE, _SECTOR)
    half = settings.robot.width_m / 2.0
    if contact < limits.near_s or around.ahead < limits.corner_m:
        if max(left, right) < limits.corner_m + half:
            return SituationJudgement(
                FlowSituation.CORNER, f"{around.ahead:.1f} m are free ahead, {left:.1f} m left and {right:.1f} m right"
            )
        if contact < limits.near_s:
            return SituationJudgement(FlowSituation.NEAR, f"contact ahead in {contact:.1f} s")
    if contact < limits.front_s:
        return SituationJudgement(FlowSituation.FRONT, f"contact ahead in {contact:.1f} s")
    if min(around.left, around.right) < limits.side_m:
        is_left = around.left < around.right
        side = FlowSituation.LEFT if is_left else FlowSituation.RIGHT
        return SituationJudgement(side, f"{max(0.0, min(around.left, around.right)):.1f} m beside the robot")
    if around.known < settings.drive.look_m and around.ahead > _SEEN:
        return SituationJudgement(FlowSituation.UNKNOWN, "no column ahead shows how far it is")
    return SituationJudgement(FlowSituation.FREE, f"{min(around.ahead, around.known):.1f} m are known to be free ahead")


class SituationFilter:
    """Hysteresis: a more urgent situation counts at once, a less urgent one when it has lasted for a while."""

    def __init__(self, hold: float) -> None:
        """Begin with an unknown one. hold: s."""
        self.current = SituationJudgement(FlowSituation.UNKNOWN, "no image has come yet")
        self._hold = hold
        self._calm_since = math.inf

    def update(self, judged: SituationJudgement, time: float) -> SituationJudgement:
        """Take the situation of a time, s; returns the one that counts."""
        if judged.situation.urgency >= self.current.situation.urgency:
            self.current, self._calm_since = judged, math.inf
        else:
            self._calm_since = min(self._calm_since, time)
            if time - self._calm_since >= self._hold:
                self.force(judged)
        return self.current

    def force(self, judged: SituationJudgement) -> None:
        """Take a situation at once."""
        self.current, self._calm_since = judged, math.inf

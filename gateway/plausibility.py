"""Whether a SIP can be true: a checksum lets through some of what noise makes, and that must not become data.

Source: fact sheet section 1: of a million frames with random errors, hundreds to thousands pass the checksum.
"""

from math import pi
from typing import NamedTuple

from geometry import wrap_angle
from p2os import RobotModel, StandardSip
from p2os.fields import POSITION_UNITS
from p2os.robot_model import SONAR_ARRAY_SIZE, SONAR_ARRAYS

SPEED_MARGIN = 1.3
"""Wheels may turn faster than the model's limits by this factor."""
LATENESS = 0.25
"""Seconds by which a SIP may arrive later than the one before it."""
SLACK = 0.3, 1.0
"""m/s and rad/s that wheel velocities may fall short of the movement seen."""
HIGHEST_VOLTAGE = 2.5
"""Times the nominal voltage."""
INSISTENCE = 3
"""SIPs in a row that agree with each other are believed against the ones before: the counters were set anew."""
ROLLING = 5.0
"""Seconds for which a robot that is out of touch may roll on: its watchdog's two, and three to come to rest."""


class SipVerdict(NamedTuple):
    """What is thought of a SIP.

    doubt: what is wrong with it, in a word; None when it can be true and is believed.
    continues: its counters go on from the last SIP believed.
    """

    doubt: str | None
    continues: bool = False


class Plausibility:
    """Judges each SIP by the model and by the SIP believed before it."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._span = POSITION_UNITS * model.scales.distance
        self._top_speed = SPEED_MARGIN * (model.max_velocity + model.max_rotation * model.wheel_track / 2.0)
        self._believed: tuple[StandardSip, float] | None = None
        self._doubted: tuple[StandardSip, float] | None = None
        self._agreeing = 0
        self._is_new_link = True

    def begin_link(self) -> None:
        """The robot was out of touch: its next SIP may hold any position."""
        self._is_new_link = True
        self._doubted = None

    def judge(self, sip: StandardSip, now: float) -> SipVerdict:
        """Take the next SIP."""
        doubt = self._impossible(sip)
        if doubt is not None:
            return SipVerdict(doubt)
        doubt = self._does_not_follow(self._believed, sip, now)
        if doubt is None or self._is_new_link or self._insists(sip, now):
            continues = doubt is None and not (self._is_new_link and self._was_reset(sip))
            self._believed, self._doubted, self._is_new_link = (sip, now), None, False
            return SipVerdict(None, continues)
        self._doubted = (sip, now)
        return SipVerdict(doubt)

    def _insists(self, sip: StandardSip, now: float) -> bool:
        agrees = self._doubted is not None and self._does_not_follow(self._doubted, sip, now) is None
        self._agreeing = self._agreeing + 1 if agrees else 1
        return self._agreeing >= INSISTENCE

    def _was_reset(self, sip: StandardSip) -> bool:
        return self._believed is None or sip.x == sip.y == sip.heading == 0.0

    def _impossible(self, sip: StandardSip) -> str | None:
        if max(abs(sip.left_velocity), abs(sip.right_velocity)) > self._top_speed:
            return "speed"
        if any(number >= SONAR_ARRAYS * SONAR_ARRAY_SIZE for number, _ in sip.sonar):
            return "sonar number"
        if sip.best_battery > HIGHEST_VOLTAGE * self._model.battery_nominal:
            return "voltage"
        return None

    def _does_not_follow(self, before: tuple[StandardSip, float] | None, sip: StandardSip, now: float) -> str | None:
        if before is None:
            return None
        last, then = before
        if sip.count(None) != last.count(None):
            return "length"
        window = min(now - then, ROLLING) + LATENESS
        speed = max(map(abs, (*last[4:6], *sip[4:6])))
        step = max(self._around(sip.x - last.x), self._around(sip.y - last.y))
        if step > (SPEED_MARGIN * speed + SLACK[0]) * window:
            return "jump"
        rotation = max(abs(each.right_velocity - each.left_velocity) / self._model.wheel_track for each in (last, sip))
        allowed = (SPEED_MARGIN * rotation + SLACK[1]) * window
        if allowed < pi and abs(wrap_angle(sip.heading - last.heading)) > allowed:
            return "turn"
        return None

    def _around(self, difference: float) -> float:
        """The shorter way round the position counter, m."""
        return abs((difference + self._span / 2.0) % self._span - self._span / 2.0)
